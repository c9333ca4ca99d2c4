//! `--stats`: what a render took, as JSON.

use std::time::Duration;

use lightmesh::{ErrorEstimate, Image, LightMesh, MeshStats, RayCounts, RenderOptions, RenderStats, Scene};
use lightmesh_io::output::Denoised;
use serde::Serialize;

use crate::error_report::{is_kept, lacks_caustics};

/// The whole document; keys in this order.
#[derive(Debug, Serialize)]
pub struct Stats {
    version: &'static str,
    method: &'static str,
    scene: String,
    threads: usize,
    image: ImageStats,
    /// Whether `--time-limit` ended the render before all samples were taken.
    time_limit_reached: bool,
    triangles: u64,
    lights: u64,
    light_samples: u64,
    seconds: SecondsStats,
    rays: RayStats,
    mesh: MeshesStats,
    fallbacks: FallbackStats,
    /// The light that more bounces would add, as a fraction of all light; `null` if it is unknown.
    energy_left_out: Option<f64>,
    /// The estimated error of the picture, with the method auto; 0 means that the light is exact.
    estimated_error: Option<f64>,
    /// The same, what it is made of, and whether it is within the bound.
    estimate: Option<EstimateStats>,
    /// What that error is made of.
    error_estimate: Option<ErrorStats>,
    /// Pixels that were infinite or not a number, and are black.
    non_finite_pixels: u64,
    /// The library, with its version, that took the picture's noise out, with `--denoise`.
    denoiser: Option<String>,
    /// The most memory that the process has held; `null` where the system does not tell.
    peak_memory_bytes: Option<u64>,
}

impl Stats {
    /// Collects the statistics of a finished frame of the scene with this name, rendered in the current thread pool.
    /// The seconds before and after the render are still 0.
    pub fn new(name: String, scene: &Scene, options: &RenderOptions, frame: &RenderStats) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            method: options.method.name(),
            scene: name,
            threads: rayon::current_num_threads(),
            image: ImageStats { width: options.picture.width, height: options.picture.height, spp: frame.spp },
            time_limit_reached: frame.time_limit_reached,
            triangles: scene.triangle_count(),
            lights: scene.data().lights.len() as u64,
            light_samples: scene.light_sample_count(),
            seconds: SecondsStats::of(frame),
            rays: frame.rays.into(),
            mesh: frame.into(),
            fallbacks: frame.into(),
            energy_left_out: frame.truncated_light,
            estimated_error: frame.estimated_error,
            estimate: EstimateStats::of(options, frame),
            error_estimate: frame.error_estimate.map(Into::into),
            non_finite_pixels: frame.non_finite_pixels,
            denoiser: None,
            peak_memory_bytes: peak_memory_bytes(),
        }
    }

    /// Adds what took the noise out, and how long that took.
    pub fn with_denoised(mut self, denoised: Option<&Denoised>) -> Self {
        self.denoiser = denoised.map(|denoised| denoised.by.clone());
        self.seconds.denoise = denoised.map_or(0.0, |denoised| denoised.seconds);
        self
    }

    /// Adds the times around the render: reading, building, writing, and all together.
    pub fn with_seconds(mut self, load: Duration, build: Duration, output: Duration, total: Duration) -> Self {
        let seconds = &mut self.seconds;
        (seconds.load, seconds.build) = (load.as_secs_f64(), build.as_secs_f64());
        (seconds.output, seconds.total) = (output.as_secs_f64(), total.as_secs_f64());
        self
    }
}

/// Statistics of measuring with meters, or of filling a mesh ahead: the part of [`Stats`] without a picture.
#[derive(Debug, Serialize)]
pub struct WorkStats {
    version: &'static str,
    method: &'static str,
    threads: usize,
    /// Samples that every meter has.
    spp: u32,
    seconds: SecondsStats,
    rays: RayStats,
    mesh: MeshesStats,
    fallbacks: FallbackStats,
    energy_left_out: Option<f64>,
}

impl WorkStats {
    /// Collects the statistics of work in the current thread pool.
    pub fn new(options: &RenderOptions, work: &RenderStats) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            method: options.method.name(),
            threads: rayon::current_num_threads(),
            spp: work.spp,
            seconds: SecondsStats { total: work.seconds.render, ..SecondsStats::of(work) },
            rays: work.rays.into(),
            mesh: work.into(),
            fallbacks: work.into(),
            energy_left_out: work.truncated_light,
        }
    }
}

/// The picture.
#[derive(Debug, Serialize)]
struct ImageStats {
    width: u32,
    height: u32,
    /// Samples that every pixel has.
    spp: u32,
}

/// Wall-clock seconds.
#[derive(Debug, Serialize)]
struct SecondsStats {
    load: f64,
    build: f64,
    primary: f64,
    demand: f64,
    fill_direct: f64,
    fill_indirect: f64,
    shade: f64,
    render: f64,
    denoise: f64,
    output: f64,
    total: f64,
}

impl SecondsStats {
    /// The renderer's seconds; those around it are still 0.
    fn of(stats: &RenderStats) -> Self {
        let s = stats.seconds;
        Self {
            load: 0.0,
            build: 0.0,
            primary: s.primary,
            demand: s.demand,
            fill_direct: s.fill_direct,
            fill_indirect: s.fill_indirect,
            shade: s.shade,
            render: s.render,
            denoise: 0.0,
            output: 0.0,
            total: 0.0,
        }
    }
}

/// Rays by purpose.
#[derive(Debug, Serialize)]
struct RayStats {
    primary: u64,
    shadow: u64,
    gather: u64,
    secondary: u64,
}

impl From<RayCounts> for RayStats {
    fn from(rays: RayCounts) -> Self {
        Self { primary: rays.primary, shadow: rays.shadow, gather: rays.gather, secondary: rays.secondary }
    }
}

/// The error of a picture with a bound on it.
#[derive(Debug, Serialize)]
struct EstimateStats {
    /// Of all light and all pixels: root mean square, relative to the picture's mean.
    error: f64,
    /// The part of it by noise of samples: on outlines, in textures, and of light that is found by chance.
    edges: Option<f64>,
    /// What the picture leaves out for the most part.
    left_out: Vec<&'static str>,
    /// Whether it is within the bound.
    kept: bool,
}

impl EstimateStats {
    fn of(options: &RenderOptions, frame: &RenderStats) -> Option<Self> {
        let (bound, estimate) = (options.method.error()?, frame.error_estimate.as_ref()?);
        let left_out = [("caustics", lacks_caustics(estimate)), ("further bounces", lacks_bounces(frame, bound))];
        Some(Self {
            error: estimate.all,
            edges: frame.sampling_error,
            left_out: left_out.into_iter().filter_map(|(name, is)| is.then_some(name)).collect(),
            kept: is_kept(bound, estimate),
        })
    }
}

/// Whether further bounces would add more than the bound allows.
fn lacks_bounces(frame: &RenderStats, bound: f32) -> bool {
    frame.truncated_light.is_none_or(|part| part > f64::from(bound))
}

/// What verification by paths found out: relative root mean squares, and parts of all light.
#[derive(Debug, Serialize)]
struct ErrorStats {
    direct: f64,
    uncertainty: f64,
    bias: f64,
    caustics: f64,
    path_spp: u64,
}

impl From<ErrorEstimate> for ErrorStats {
    fn from(estimate: ErrorEstimate) -> Self {
        let ErrorEstimate { direct, uncertainty, bias, caustics, path_spp, .. } = estimate;
        Self { direct, uncertainty, bias, caustics, path_spp }
    }
}

/// Both meshes.
#[derive(Debug, Serialize)]
pub struct MeshesStats {
    direct: OneMeshStats,
    indirect: OneMeshStats,
}

impl MeshesStats {
    /// Collects the statistics of a light mesh.
    pub fn of(mesh: &LightMesh) -> Self {
        Self { direct: mesh.stats().into(), indirect: mesh.indirect_stats().into() }
    }
}

impl From<&RenderStats> for MeshesStats {
    fn from(stats: &RenderStats) -> Self {
        Self { direct: stats.direct.into(), indirect: stats.indirect.into() }
    }
}

/// Surface points at which no point of a mesh could be read: shadow rays, or gather rays, were shot instead.
#[derive(Debug, Serialize)]
struct FallbackStats {
    direct: u64,
    indirect: u64,
}

impl From<&RenderStats> for FallbackStats {
    fn from(stats: &RenderStats) -> Self {
        Self { direct: stats.exact_fallbacks, indirect: stats.gather_fallbacks }
    }
}

/// Statistics of one mesh, direct or indirect.
#[derive(Debug, Serialize)]
struct OneMeshStats {
    spacing_m: f64,
    points_used: u64,
    points_refined: u64,
    points_total: u64,
    points_invalid: u64,
    bytes: u64,
}

impl From<MeshStats> for OneMeshStats {
    fn from(mesh: MeshStats) -> Self {
        Self {
            spacing_m: mesh.spacing_m,
            points_used: mesh.points_used,
            points_refined: mesh.points_refined,
            points_total: mesh.points_total,
            points_invalid: mesh.points_invalid,
            bytes: mesh.bytes,
        }
    }
}

/// Says that pixels of a picture are black because they were no numbers; `None` where all are.
pub fn non_finite_message(frame: &RenderStats, image: &Image) -> Option<String> {
    let (count, all) = (frame.non_finite_pixels, image.pixels.len());
    (count > 0).then(|| {
        format!(
            "{count} of {all} pixels were infinite or not a number and are black: a size, a distance or a light of the \
             scene is too large or too small for 32-bit floats"
        )
    })
}

/// The most memory that this process has held, bytes, from Linux' /proc (VmHWM); `None` on other systems.
fn peak_memory_bytes() -> Option<u64> {
    std::fs::read_to_string("/proc/self/status").ok().and_then(|status| high_water_mark(&status))
}

/// VmHWM of a /proc status file, in bytes; the kernel counts it in units of 1024.
fn high_water_mark(status: &str) -> Option<u64> {
    let value = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    value.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_found() {
        assert_eq!(high_water_mark("Name:\tx\nVmHWM:\t    2048 kB\nVmRSS:\t 1 kB\n"), Some(2 << 20));
        assert_eq!(high_water_mark("Name:\tx\n"), None);
    }
}
