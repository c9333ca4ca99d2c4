//! Rendering: one picture of a scene through a camera.

use std::time::Instant;

use super::light_around::white_around;
use crate::film::{Film, RenderClock, blacken_non_finite, cut_noise_below_black};
use crate::integrator::{Dots, Lighting, PointCloud, WaveFrame, adapt, paint_points, render_path, truncated_light};
use crate::mesh::Points;
use crate::scene::validate::check_camera;
use crate::{Aov, Camera, Error, Image, Layer, LightMesh, Method, Progress, RenderOptions, RenderStats, Scene};

/// A finished picture.
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
/// [`Error::InvalidOption`] for options out of range or a mesh that was made for others, [`Error::InvalidScene`] for a
/// camera whose lens or place is out of range, [`Error::OutOfMemory`] before an allocation that would exceed `options.limits.max_memory`, [`Error::Cancelled`] soon after `progress` says so.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    progress: &dyn Progress,
) -> Result<Frame, Error> {
    // Check options and memory.
    options.validate()?;
    check_camera(camera, scene.data().origin, || format!("camera \"{}\"", camera.name))?;
    let viewer = progress.viewer();
    options.check_film_memory(viewer.is_some(), scene.has_unlit(), scene.bytes())?;

    // Draw by the method.
    let started = Instant::now();
    let mut clock = RenderClock::new(progress, viewer, started, options.picture.time_limit);
    let mut film = new_film(scene, camera, options);
    film.set_white(white_around(scene, camera)?);
    let mut stats = match options.method {
        Method::Path => render_path(scene, &mut film, options, &mut clock)?,
        Method::Standard => render_waves(scene, &mut film, options, Lighting::Exact, &mut clock)?,
        Method::Auto { .. } | Method::Mesh { .. } | Method::Paper { .. } | Method::Hybrid | Method::Unbiased { .. } => {
            mesh.check_compatible(options)?;
            render_waves(scene, &mut film, options, Lighting::from_mesh(mesh), &mut clock)?
        }
    };

    stats.spp = film.whole_passes();
    stats.time_limit_reached = stats.spp < options.picture.spp;

    // Paint mesh points over the picture, where a layer wants them.
    let view = film.view();
    let (mut image, mut layers) = film.into_image();
    if options.picture.aovs.contains(Aov::Points) {
        stats.rays.secondary += paint_points(scene, &view, &mut layers, &points(mesh));
    }
    layers.retain(|layer| options.picture.aovs.contains(layer.aov));
    stats.non_finite_pixels = blacken_non_finite(&mut image, &mut layers);
    cut_noise_below_black(&mut image, options.method);
    stats.seconds.render = started.elapsed().as_secs_f64();
    mesh.report(options, &mut stats);
    if let Some(viewer) = viewer {
        viewer.show(image.clone());
    }
    Ok(Frame { image, layers, stats })
}

/// Adapts mesh and lighting to the picture, then draws it.
fn render_waves(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    lighting: Lighting<'_>,
    clock: &mut RenderClock<'_>,
) -> Result<RenderStats, Error> {
    let mut stats = RenderStats::default();
    let mut frame = WaveFrame::new(scene, options, lighting);
    let plan = adapt(&mut frame, film, clock, &mut stats)?;
    frame.draw_picture(film, plan, clock, &mut stats)?;
    stats.truncated_light = truncated_light(&mut frame, film, plan, clock)?;
    Ok(stats)
}

/// Makes the empty film of a picture.
pub(crate) fn new_film(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Film {
    let mut film = Film::new(scene, camera, options);
    if !scene.averages_textures() {
        film.drop_cones();
    }
    film
}

/// Lists the points of both meshes, with what they look like in a picture of them.
fn points(mesh: &LightMesh) -> Vec<PointCloud> {
    let list = |points: &Points, valid: Dots, invalid: Dots| {
        let spacing = points.spacing();
        [
            PointCloud { dots: valid, spacing, positions: points.valid_positions().collect() },
            PointCloud { dots: invalid, spacing, positions: points.invalid_positions().collect() },
        ]
    };
    let mut points = list(mesh.direct.points(), Dots::DIRECT, Dots::DIRECT_INVALID).to_vec();
    if let Some(field) = &mesh.indirect {
        points.extend(list(field.points(), Dots::INDIRECT, Dots::INDIRECT_INVALID));
    }
    points
}
