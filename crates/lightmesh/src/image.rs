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
pub struct RayCounts {
    /// Through the camera's film.
    pub primary: u64,
    /// From a hit or a mesh point to a light.
    pub shadow: u64,
    /// From indirect mesh points, or a path's diffuse bounces.
    pub gather: u64,
    /// Mirrored, refracted and passed through, and those that find out whether mesh points are inside solids.
    pub secondary: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.gather + self.secondary
    }
}

/// The state of one mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshStats {
    /// Distance between neighbours, metres.
    pub spacing_m: f64,
    /// Points that have been evaluated.
    pub points_used: u64,
    /// Points that a mesh filled over the whole scene's box would have.
    pub points_total: u64,
    /// Evaluated points that were found invalid (inside a solid).
    pub points_invalid: u64,
    /// Memory, bytes.
    pub bytes: u64,
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// By step.
    pub seconds: Seconds,
    /// By purpose.
    pub rays: RayCounts,
    /// The direct mesh after the frame.
    pub direct: MeshStats,
    /// The indirect mesh after the frame.
    pub indirect: MeshStats,
    /// Hits at which no mesh point was usable and light was computed exactly.
    pub exact_fallbacks: u64,
}
