//! `--stats`: what a render took, as JSON.

use lightmesh::{MeshStats, RayCounts, RenderStats};
use serde::Serialize;

/// The whole document; keys in this order.
#[derive(Debug, Serialize)]
pub(crate) struct Stats {
    pub(crate) version: &'static str,
    pub(crate) method: &'static str,
    pub(crate) scene: String,
    pub(crate) threads: usize,
    pub(crate) image: ImageStats,
    /// Whether `--time-limit` ended the render before all samples were taken.
    pub(crate) time_limit_reached: bool,
    pub(crate) triangles: u64,
    pub(crate) lights: u64,
    pub(crate) light_samples: u64,
    pub(crate) seconds: SecondsStats,
    pub(crate) rays: RayStats,
    pub(crate) mesh: MeshesStats,
    pub(crate) fallbacks: FallbackStats,
    /// What more bounces would add, as a part of all light; `null` where nothing is known of it.
    pub(crate) energy_left_out: Option<f64>,
    /// Where `--error` asked for one; 0: the light is exact.
    pub(crate) estimated_error: Option<f64>,
    pub(crate) peak_memory_bytes: u64,
}

/// The picture.
#[derive(Debug, Serialize)]
pub(crate) struct ImageStats {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Those that every pixel has.
    pub(crate) spp: u32,
}

/// Wall-clock seconds.
#[derive(Debug, Serialize)]
pub(crate) struct SecondsStats {
    pub(crate) load: f64,
    pub(crate) build: f64,
    pub(crate) primary: f64,
    pub(crate) demand: f64,
    pub(crate) fill_direct: f64,
    pub(crate) fill_indirect: f64,
    pub(crate) shade: f64,
    pub(crate) render: f64,
    pub(crate) output: f64,
    pub(crate) total: f64,
}

impl SecondsStats {
    /// The renderer's seconds; those around it are still 0.
    pub(crate) fn of(stats: &RenderStats) -> Self {
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
            output: 0.0,
            total: 0.0,
        }
    }
}

/// Rays by purpose.
#[derive(Debug, Serialize)]
pub(crate) struct RayStats {
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

/// Both meshes.
#[derive(Debug, Serialize)]
pub(crate) struct MeshesStats {
    direct: OneMeshStats,
    indirect: OneMeshStats,
}

impl From<&RenderStats> for MeshesStats {
    fn from(stats: &RenderStats) -> Self {
        Self { direct: stats.direct.into(), indirect: stats.indirect.into() }
    }
}

/// Surface points at which no point of a mesh could be read: shadow rays, or gather rays, were shot instead.
#[derive(Debug, Serialize)]
pub(crate) struct FallbackStats {
    direct: u64,
    indirect: u64,
}

impl From<&RenderStats> for FallbackStats {
    fn from(stats: &RenderStats) -> Self {
        Self { direct: stats.exact_fallbacks, indirect: stats.gather_fallbacks }
    }
}

/// One mesh.
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

/// The most memory that this process has held, bytes, from Linux' /proc (VmHWM); 0 on other systems.
pub(crate) fn peak_memory_bytes() -> u64 {
    std::fs::read_to_string("/proc/self/status").ok().and_then(|status| high_water_mark(&status)).unwrap_or(0)
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
