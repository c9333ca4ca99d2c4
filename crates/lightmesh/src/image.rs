//! The finished picture and what its making took.

use glam::Vec3;

/// A linear picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB, cd/m², row by row from the upper left.
    pub pixels: Vec<Vec3>,
}

/// Wall-clock seconds of a frame's steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Seconds {
    /// Camera rays and what they hit.
    pub primary: f64,
    /// Finding out which mesh points are read.
    pub demand: f64,
    /// Evaluating direct mesh points.
    pub fill_direct: f64,
    /// Evaluating indirect mesh points.
    pub fill_indirect: f64,
    /// Interpolation, light sums, shadow rays at pixels, mirrored and refracted rays.
    pub shade: f64,
    /// Everything between the built scene and the finished linear picture.
    pub render: f64,
}

/// Rays traced, by purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RayCounts {
    /// Through the camera's film.
    pub primary: u64,
    /// From a hit or a mesh point to a light.
    pub shadow: u64,
    /// From indirect mesh points, or a path's diffuse bounces.
    pub gather: u64,
    /// Mirrored, refracted and passed through, and those that find out what mesh points and surfaces see of each other.
    pub secondary: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.gather += other.gather;
        self.secondary += other.secondary;
    }
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.gather + self.secondary
    }
}

/// The state of one mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeshStats {
    /// Distance between neighbours, metres.
    pub spacing_m: f64,
    /// Points that have been evaluated.
    pub points_used: u64,
    /// Those of them that are on finer levels than the first.
    pub points_refined: u64,
    /// Points that a mesh filled over the whole scene's box would have.
    pub points_total: u64,
    /// Evaluated points that were found invalid (inside a solid).
    pub points_invalid: u64,
    /// Memory, bytes.
    pub bytes: u64,
}

impl std::ops::AddAssign for Seconds {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.demand += other.demand;
        self.fill_direct += other.fill_direct;
        self.fill_indirect += other.fill_indirect;
        self.shade += other.shade;
        self.render += other.render;
    }
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RenderStats {
    /// Samples that every pixel has; fewer than [`PictureOptions::spp`](crate::PictureOptions::spp) where the time limit was
    /// reached: some pixels may have an eighth more then, or one more. Outlines of lamps have more (64).
    pub spp: u32,
    /// Whether the time limit ended the work before all samples were taken.
    pub time_limit_reached: bool,
    /// By step.
    pub seconds: Seconds,
    /// By purpose.
    pub rays: RayCounts,
    /// The direct mesh after the frame.
    pub direct: MeshStats,
    /// The indirect mesh after the frame.
    pub indirect: MeshStats,
    /// Surface points at which no point of the direct mesh was usable: shadow rays were shot.
    pub exact_fallbacks: u64,
    /// Surface points at which no point of the indirect mesh was usable: gather rays were shot.
    pub gather_fallbacks: u64,
    /// Shadow rays of mesh points, of all shadow rays.
    pub fill_shadow_rays: u64,
    /// The error that the picture is estimated to have, RMS relative to its mean, where one was asked for; 0: its light is exact.
    pub estimated_error: Option<f64>,
    /// What bounces after the last one would add, estimated, as a part of all light; `None` where nothing is known of it.
    pub truncated_light: Option<f64>,
}

impl RenderStats {
    /// Adds what a part of the same frame took: seconds, rays and counts.
    pub(crate) fn add(&mut self, part: &Self) {
        self.seconds += part.seconds;
        self.rays += part.rays;
        self.exact_fallbacks += part.exact_fallbacks;
        self.gather_fallbacks += part.gather_fallbacks;
        self.fill_shadow_rays += part.fill_shadow_rays;
        self.estimated_error = self.estimated_error.or(part.estimated_error);
    }
}
