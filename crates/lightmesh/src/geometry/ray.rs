//! A ray with its interval, and the offset that keeps it off the surface it starts from.

use glam::Vec3;

/// A half-line `origin + t · direction`, t in (`t_min`, `t_max`).
///
/// `direction` need not be of unit length: t counts in units of it, which keeps t the same number in world and
/// object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, metres.
    pub origin: Vec3,
    /// Direction, any non-zero length.
    pub direction: Vec3,
    /// Hits at t ≤ `t_min` are not seen.
    pub t_min: f32,
    /// Hits at t ≥ `t_max` are not seen.
    pub t_max: f32,
}

impl Ray {
    /// A ray over t in (0, ∞).
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The open segment from `from` to `to`: t in (0, 1).
    pub fn segment(from: Vec3, to: Vec3) -> Self {
        Self { origin: from, direction: to - from, t_min: 0.0, t_max: 1.0 }
    }

    /// The point at t, metres.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// u, half the distance between 1 and the next float.
const UNIT_ROUNDOFF: f32 = 1.0 / (1 << 24) as f32;

/// How far off a surface its rays start, in units of u times the largest coordinate that was rounded on the way to the
/// point.
const PER_COORDINATE: f32 = 64.0;

/// The same, in units of u times the size of the primitive.
const PER_SIZE: f32 = 16.0;

/// Returns how far off a surface rays start that must not meet it, metres: a bound of two rounding errors, that of the
/// point and that of the test by which the ray would meet the surface again (the idea of Wächter and Binder, "A Fast
/// and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems, 2019, ch. 6; the analysis that of Pharr, Jakob
/// and Humphreys, *Physically Based Rendering*, 4th ed., section 6.8).
///
/// `coordinate`: the largest coordinate of the point, and of whatever was added up to it, metres. Interpolation rounds
/// by a few u of it, which is the float spacing there; the rest is for surfaces that authors laid upon each other, whose
/// places are rounded as well. `size`: the largest extent of the primitive along an axis. The triangle test of Woop et
/// al. sees its corners moved by up to 6 u times their distance from the ray's origin.
#[inline(always)]
pub(crate) fn self_distance(coordinate: f32, size: f32) -> f32 {
    (coordinate * PER_COORDINATE + size * PER_SIZE) * UNIT_ROUNDOFF
}

/// Returns where a ray along `direction` leaves a surface: the point, moved by `distance` (metres) to the side of the
/// geometric `normal` (unit) on which the ray goes, so that it does not hit the surface itself.
pub fn offset_origin(point: Vec3, normal: Vec3, distance: f32, direction: Vec3) -> Vec3 {
    let step = normal * distance;
    if normal.dot(direction) < 0.0 { point - step } else { point + step }
}
