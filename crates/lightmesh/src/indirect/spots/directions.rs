//! Directions to bright spots: random ones, and their density for every direction.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::rectangle::Rectangle;
use crate::sampling::basis;

/// Directions evenly spread in a cone.
#[derive(Clone, Copy, Debug)]
pub(in crate::indirect) struct EvenCone {
    /// Unit.
    pub axis: Vec3,
    pub cos: f32,
}

impl EvenCone {
    pub(in crate::indirect) fn sample(&self, u: Vec2) -> Vec3 {
        let z = 1.0 - u.x * (1.0 - self.cos);
        let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), TAU * u.y);
        let (t, b) = basis(self.axis);
        t * (r * libm::cosf(phi)) + b * (r * libm::sinf(phi)) + self.axis * z
    }

    /// Density per steradian.
    pub(in crate::indirect) fn pdf(&self, direction: Vec3) -> f32 {
        if direction.dot(self.axis) < self.cos { 0.0 } else { 1.0 / self.solid_angle() }
    }

    pub(in crate::indirect) fn solid_angle(&self) -> f32 {
        (TAU * (1.0 - self.cos)).max(1e-6)
    }
}

/// The directions from a point to a spot.
#[derive(Clone, Copy, Debug)]
pub(in crate::indirect) enum SpotDirections {
    /// To where the lamp's rays meet a plane: [`SpotShape::Plane`], seen from `x`.
    Plane { x: Vec3, lamp: Vec3, foot: Vec3, n: Vec3, cone: EvenCone },
    /// Evenly spread in a cone, with a density per steradian.
    Cone { cone: EvenCone, pdf: f32 },
    /// To places evenly spread in a rectangle, seen from `x`.
    Rectangle { x: Vec3, rectangle: Rectangle },
}

impl SpotDirections {
    /// A unit direction, by u in [0, 1)²; `None` where the lamp's ray does not meet the plane.
    pub(in crate::indirect) fn sample(&self, u: Vec2) -> Option<Vec3> {
        match *self {
            Self::Plane { x, lamp, foot, n, cone } => {
                let l = cone.sample(u);
                let cos = -n.dot(l);
                (cos > 0.0).then(|| (lamp + l * (n.dot(lamp - foot) / cos) - x).normalize_or_zero())
            }
            Self::Cone { cone, .. } => Some(cone.sample(u)),
            Self::Rectangle { x, rectangle } => (rectangle.sample(u) - x).try_normalize(),
        }
    }

    /// The density of [`Self::sample`] per steradian.
    #[inline(always)]
    pub(in crate::indirect) fn pdf(&self, direction: Vec3) -> f32 {
        match *self {
            Self::Plane { x, lamp, foot, n, cone } => {
                // Where the ray meets the plane, and the lamp's ray there.
                let cos = -n.dot(direction);
                let t = n.dot(x - foot) / cos;
                if cos <= 1e-6 || t <= 0.0 {
                    return 0.0;
                }
                let l = x + direction * t - lamp;
                let r2 = l.length_squared();
                let l = l / r2.sqrt();
                cone.pdf(l) * (-n.dot(l)).max(0.0) / r2 * (t * t / cos)
            }
            Self::Cone { cone, pdf } => {
                if direction.dot(cone.axis) < cone.cos {
                    0.0
                } else {
                    pdf
                }
            }
            Self::Rectangle { x, rectangle } => rectangle.pdf(x, direction),
        }
    }
}

/// The cone in which a ball is seen from outside.
pub(in crate::indirect) fn cone_of_ball(x: Vec3, center: Vec3, radius: f32) -> EvenCone {
    let d = center - x;
    let r2 = d.length_squared();
    EvenCone { axis: d / r2.sqrt(), cos: (1.0 - radius * radius / r2).max(0.0).sqrt() }
}
