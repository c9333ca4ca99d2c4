//! Ray cones: the part of the picture that a camera sample stands for.

use glam::Vec3;

/// The cone about a ray that a camera sample stands for (Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984): textures
/// are averaged over its width. Mirrors and glass reflect and transmit it as if they were flat (Akenine-Möller et al.,
/// "Improved Shader and Texture Level of Detail Using Ray Cones", JCGT 10(1), 2021, section 3, without their
/// curvature), and refraction does not change it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cone {
    /// Width at the ray's origin, metres.
    pub width: f32,
    /// How much its width grows, metres per metre.
    pub spread: f32,
    /// From the ray to its axis, in widths; perpendicular to the ray.
    pub offset: Vec3,
}

impl Cone {
    /// No width: textures are looked up at points.
    pub(crate) const POINT: Self = Self { width: 0.0, spread: 0.0, offset: Vec3::ZERO };

    /// Returns its width after so many metres, metres.
    pub(crate) fn width_at(self, distance: f32) -> f32 {
        self.width + self.spread * distance
    }

    /// Returns the cone that continues from a surface that this one meets after so many metres.
    pub(crate) fn after(self, distance: f32) -> Self {
        Self { width: self.width_at(distance), ..self }
    }

    /// Returns the cone behind a mirror that reflects direction `from` to direction `to`.
    pub(crate) fn mirrored(self, from: Vec3, to: Vec3) -> Self {
        let n = (to - from).normalize_or_zero();
        Self { offset: self.offset - n * (2.0 * n.dot(self.offset)), ..self }
    }
}
