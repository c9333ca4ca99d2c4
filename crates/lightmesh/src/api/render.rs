//! The front door: one picture of a scene.

use std::time::Instant;

use glam::Vec3;

use crate::film::{Film, RenderClock};
use crate::integrator::{Dots, Lighting, paint, render_path, render_waves};
use crate::{Aov, Camera, Error, Image, Layer, LightMesh, Method, Progress, RenderOptions, RenderStats, Scene};

/// A finished picture and what it took.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Linear, cd/m².
    pub image: Image,
    /// The layers of [`PictureOptions::aovs`](crate::PictureOptions::aovs), in the order of [`Aov::ALL`].
    pub layers: Vec<Layer>,
    /// Times, rays and the state of the mesh.
    pub stats: RenderStats,
}

/// Renders one picture in rayon's current thread pool. `mesh` is read and filled by the methods that have one
/// ([`Method::has_mesh`]); keep it between frames of the same scene, and what one frame filled the next one only reads.
/// The picture is the same bit for bit whatever the number of threads, whatever frames came before and whether a
/// [`Viewer`](crate::Viewer) looks at it, unless its time is limited.
///
/// # Errors
/// [`Error::InvalidOption`] for options out of range or a mesh that was made for others, [`Error::OutOfMemory`] before an
/// allocation that would exceed `options.limits.max_memory`, [`Error::Cancelled`] soon after `progress` says so.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    progress: &dyn Progress,
) -> Result<Frame, Error> {
    options.validate()?;
    let viewer = progress.viewer();
    match viewer {
        Some(_) => options.check_viewed_picture_memory()?,
        None => options.check_picture_memory()?,
    }
    let started = Instant::now();
    let mut watch = RenderClock::new(progress, viewer, started, options.picture.time_limit);
    let mut film = new_film(scene, camera, options);
    let mut stats = match options.method {
        Method::Standard => render_waves(scene, &mut film, options, Lighting::Exact, &mut watch)?,
        Method::Path => render_path(scene, &mut film, options, &mut watch)?,
        Method::Mesh { .. } | Method::Paper { .. } | Method::Hybrid | Method::Unbiased { .. } => {
            mesh.check_compatible(options)?;
            render_waves(scene, &mut film, options, Lighting::Mesh(mesh), &mut watch)?
        }
    };
    stats.spp = film.whole_passes();
    stats.time_limit_reached = stats.spp < options.picture.spp;
    let film_frame = film.rays_and_size();
    let (image, mut layers) = film.into_image();
    if options.picture.aovs.contains(Aov::Points) {
        let (rays, width, height) = film_frame;
        stats.rays.secondary += paint(scene, (&rays, width, height), &mut layers, &points(mesh));
    }
    layers.retain(|layer| options.picture.aovs.contains(layer.aov));
    stats.seconds.render = started.elapsed().as_secs_f64();
    mesh.report(options, &mut stats);
    if let Some(viewer) = viewer {
        viewer.show(image.clone());
    }
    Ok(Frame { image, layers, stats })
}

/// An empty film.
pub(crate) fn new_film(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Film {
    let mut film = Film::new(camera, options);
    if !scene.averages_textures() {
        film.drop_cones();
    }
    film
}

/// The points of both meshes, and what they look like in a picture of them.
fn points(mesh: &LightMesh) -> Vec<(Dots, f32, Vec<Vec3>)> {
    let direct = mesh.direct.points();
    let mut points = vec![
        (Dots::DIRECT, direct.spacing(), direct.valid_positions().collect()),
        (Dots::DIRECT_INVALID, direct.spacing(), direct.invalid_positions().collect()),
    ];
    if let Some(indirect) = mesh.indirect.as_ref().map(|field| field.points()) {
        points.push((Dots::INDIRECT, indirect.spacing(), indirect.valid_positions().collect()));
        points.push((Dots::INDIRECT_INVALID, indirect.spacing(), indirect.invalid_positions().collect()));
    }
    points
}
