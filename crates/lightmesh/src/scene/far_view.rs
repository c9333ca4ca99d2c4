//! Cameras so far from a scene that rays in single precision would miss what they look at.

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};

use crate::geometry::{Aabb, Ray};

/// A camera is far where it is more than this many diagonals away from the scene's box: hits are off there by a
/// millionth of the diagonal. Nearer cameras keep their rays, bit for bit.
const FAR: f64 = 16.0;

/// Rays start this part of the diagonal before the box.
const MARGIN: f64 = 1.0 / 16.0;

/// The rays of a far camera, in double precision up to where they meet the scene's box.
#[derive(Clone, Copy, Debug)]
pub(super) struct FarView {
    eye: DVec3,
    forward: DVec3,
    /// From a pixel to its right and lower neighbour, at distance 1 for a pinhole.
    dx: DVec3,
    dy: DVec3,
    parallel: bool,
    center: DVec3,
    half: DVec3,
}

impl FarView {
    /// `None` for a camera that is not far from the box. `pixel`: the length of a pixel's edge, at distance 1 for a
    /// pinhole; `parallel`: it is none.
    pub(super) fn new(world_from_camera: &DAffine3, pixel: f64, parallel: bool, bounds: &Aabb) -> Option<Self> {
        let (m, eye) = (&world_from_camera.matrix3, world_from_camera.translation);
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let diagonal = (max - min).length();
        // An infinite box is never far away.
        let is_far = (eye - eye.clamp(min, max)).length() > FAR * diagonal;
        is_far.then(|| {
            let half = 0.5 * (max - min) + MARGIN * diagonal;
            Self {
                eye,
                forward: -m.z_axis.normalize_or(DVec3::Z),
                dx: m.x_axis.normalize_or(DVec3::X) * pixel,
                dy: m.y_axis.normalize_or(DVec3::Y) * -pixel,
                parallel,
                center: 0.5 * (min + max),
                half,
            }
        })
    }

    /// The ray through a film position, pixels from the middle of the picture; it starts where it enters the box, or
    /// else where it is nearest to its middle.
    pub(super) fn ray(&self, x: f32, y: f32) -> Ray {
        let offset = self.dx * f64::from(x) + self.dy * f64::from(y);
        let (origin, direction) = match self.parallel {
            true => (self.eye + offset, self.forward),
            false => (self.eye, (self.forward + offset).normalize()),
        };
        // The slab test; a component of zero gives infinities of the right sign, or NaN, which max and min pass over.
        let (a, b) = ((self.center - self.half - origin) / direction, (self.center + self.half - origin) / direction);
        let near = (0..3).map(|i| a[i].min(b[i])).fold(0.0, f64::max);
        let far = (0..3).map(|i| a[i].max(b[i])).fold(f64::INFINITY, f64::min);
        let t = if near <= far { near } else { (self.center - origin).dot(direction).max(0.0) };
        Ray::new((origin + direction * t).as_vec3(), direction.as_vec3())
    }

    /// Returns the distance of a point from the eye, metres.
    pub(super) fn distance(&self, p: Vec3) -> f32 {
        (p.as_dvec3() - self.eye).length() as f32
    }

    /// Returns the distance of a point along the camera's axis, metres.
    pub(super) fn depth(&self, p: Vec3) -> f32 {
        (p.as_dvec3() - self.eye).dot(self.forward) as f32
    }

    /// Returns a point's film position, pixels from the middle of the picture, and the size in pixels of a metre there.
    pub(super) fn project(&self, p: Vec3) -> (Vec2, f32) {
        let offset = p.as_dvec3() - self.eye;
        let scale = if self.parallel { 1.0 } else { 1.0 / offset.dot(self.forward) };
        let along = |axis: DVec3| offset.dot(axis) / axis.length_squared() * scale;
        (DVec2::new(along(self.dx), along(self.dy)).as_vec2(), (scale / self.dx.length()) as f32)
    }
}
