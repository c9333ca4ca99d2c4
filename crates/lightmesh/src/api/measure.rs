//! Measuring: irradiance at given points, without a camera.

use std::time::Instant;

use glam::Vec3;

use crate::integrator::{Lighting, MeterIrradiance, measure_paths, measure_waves};
use crate::{Error, LightMesh, Meter, Method, Progress, RenderOptions, RenderStats, Scene};

/// The irradiance at meters.
#[derive(Clone, Debug)]
pub struct Measured {
    /// By meter: what arrives from lights on the side that it faces, with no surface between; RGB, lux.
    pub direct: Vec<Vec3>,
    /// By meter: what arrives there after one diffuse reflection or more, and emission that gather rays find; RGB, lux.
    /// [`Method::Standard`] has none.
    pub indirect: Vec<Vec3>,
    /// Times, rays and the state of the mesh. `spp` is 1 but for [`Method::Path`].
    pub stats: RenderStats,
}

/// Measures the irradiance that arrives at every meter from the hemisphere that it faces, in rayon's current thread
/// pool.
///
/// Each meter gets what a surface there would get in a picture, by the same code:
///
/// | method | direct | indirect |
/// |---|---|---|
/// | [`Method::Mesh`], [`Method::Paper`], [`Method::Hybrid`]; with an error as `Hybrid` | read from `mesh`, which is filled as needed | the same |
/// | [`Method::Unbiased`] | its number of shadow rays, the mesh as control variate | as many gather rays |
/// | [`Method::Standard`] | a shadow ray to every light sample | none |
/// | [`Method::Path`] | [`PictureOptions::spp`](crate::PictureOptions::spp) samples | their paths |
///
/// What a meter reads depends on its own position and direction alone, bit for bit: not on other meters, threads, or
/// what was measured or rendered before. Meters outside the scene's box, where no mesh point is, get exact direct light
/// and gather their indirect light by rays of their own.
///
/// Size, samples, layers and cutoff of a picture have no part in it, but must be in range; samples count for
/// [`Method::Path`].
///
/// ```
/// # use glam::Vec3;
/// # use lightmesh::geometry::Sphere;
/// # use lightmesh::{Light, LightMesh, Material, Meter, Method, RenderOptions, Scene, SceneData, measure};
/// # fn main() -> Result<(), lightmesh::Error> {
/// // 100 cd, 2 m above a desk: 25 lux.
/// let scene = Scene::new(SceneData {
///     spheres: vec![Sphere { center: Vec3::new(5.0, 0.0, 0.0), radius: 1.0, material: 0 }],
///     materials: vec![Material::lambert(Vec3::splat(0.5))],
///     lights: vec![Light::Point { position: Vec3::Y * 2.75, intensity_cd: Vec3::splat(100.0), range: None }],
///     ..SceneData::default()
/// })?;
/// let options = RenderOptions { method: Method::Standard, ..RenderOptions::default() };
/// let mut mesh = LightMesh::new(&scene, &options)?;
/// let desk = Meter { position: Vec3::Y * 0.75, normal: Vec3::Y };
/// let measured = measure(&scene, &[desk], &options, &mut mesh, &())?;
/// assert!((measured.direct[0] - 25.0).length() < 1e-3);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`Error::InvalidMeter`] names the first meter that is not finite or faces nowhere. [`Error::InvalidOption`] for
/// options out of range, a mesh that was made for others, and options that need a picture: `refine` and
/// `lod-distance` put mesh points and rays where a picture needs them, `time_limit` ends when every pixel has a sample.
/// [`Error::OutOfMemory`] before an allocation that would exceed `options.limits.max_memory`; [`Error::Cancelled`] soon
/// after `progress` says so.
pub fn measure(
    scene: &Scene,
    meters: &[Meter],
    options: &RenderOptions,
    mesh: &mut LightMesh,
    progress: &dyn Progress,
) -> Result<Measured, Error> {
    let started = Instant::now();
    // Check options, memory and meters.
    options.validate()?;
    check_options(options)?;
    check_memory(meters.len() as u64, options.limits.max_memory)?;
    meters.iter().enumerate().try_for_each(|(index, meter)| meter.check(index))?;

    // Measure by the method.
    let (MeterIrradiance { direct, indirect }, mut stats) = match options.method {
        Method::Path => measure_paths(scene, meters, options, progress)?,
        Method::Standard => measure_waves(scene, meters, options, Lighting::Exact, progress)?,
        Method::Auto { .. } | Method::Mesh { .. } | Method::Paper { .. } | Method::Hybrid | Method::Unbiased { .. } => {
            mesh.check_compatible(options)?;
            measure_waves(scene, meters, options, Lighting::from_mesh(mesh), progress)?
        }
    };
    stats.spp = stats.spp.max(1);
    stats.seconds.render = started.elapsed().as_secs_f64();
    mesh.report(options, &mut stats);
    Ok(Measured { direct, indirect, stats })
}

/// Refuses what only a picture can decide.
fn check_options(options: &RenderOptions) -> Result<(), Error> {
    let refused = [
        ("refine", options.resolved().refinements > 0, "follows a picture; meters take a smaller spacing"),
        ("lod-distance", options.mesh.lod_distance.is_some(), "follows a camera; meters take a smaller spacing"),
        ("time-limit", options.picture.time_limit.is_some(), "is for pictures; every meter is measured"),
    ];
    match refused.into_iter().find(|(_, given, _)| *given) {
        Some((option, _, what)) => Err(Error::InvalidOption { option, what: what.into() }),
        None => Ok(()),
    }
}

/// Refuses so many meters that their results do not fit.
pub(crate) fn check_memory(meters: u64, limit_bytes: u64) -> Result<(), Error> {
    let needed_bytes = meters.saturating_mul(Meter::BYTES);
    if needed_bytes <= limit_bytes {
        return Ok(());
    }
    let what = "what so many meters read";
    Err(Error::OutOfMemory { what, needed_bytes, limit_bytes, advice: "measure fewer at a time" })
}
