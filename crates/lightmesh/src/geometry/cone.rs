//! What a sample stands for about its ray.

use glam::Vec3;

/// The cone about a ray that a camera sample stands for (Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984): its width tells
/// textures how much of them to average. It goes on through mirrors and glass as if they were flat (Akenine-Möller et al.,
/// "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1), 2021, section 3, without their curvature), and
/// unbent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cone {
    /// Width at the ray's origin, metres.
    pub width: f32,
    /// By how much it grows, metres per metre.
    pub spread: f32,
    /// Where its axis is beside the ray, in widths; perpendicular to the ray.
    pub aside: Vec3,
}

impl Cone {
    /// A ray that stands for nothing but itself: textures are looked up at points.
    pub(crate) const POINT: Self = Self { width: 0.0, spread: 0.0, aside: Vec3::ZERO };

    /// Its width after so many metres, metres.
    pub(crate) fn width_at(self, distance: f32) -> f32 {
        self.width + self.spread * distance
    }

    /// The cone that goes on as it is from the surface that this one has met after so many metres.
    pub(crate) fn after(self, distance: f32) -> Self {
        Self { width: self.width_at(distance), ..self }
    }

    /// The cone in the mirror that turns direction `from` to direction `to`.
    pub(crate) fn mirrored(self, from: Vec3, to: Vec3) -> Self {
        let n = (to - from).normalize_or_zero();
        Self { aside: self.aside - n * (2.0 * n.dot(self.aside)), ..self }
    }
}
