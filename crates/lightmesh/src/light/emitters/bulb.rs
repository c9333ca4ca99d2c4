//! Small lamps that are balls: one light sample each, and random rays in the cone in which they are seen.
//!
//! A ball of radius R and luminance L is the same as a point of I = πR²L in its middle for every surface that sees all of
//! it, whatever the distance. That is what the mesh takes it for. Where light is to be exact, a ray goes to a random
//! direction of its cone, and brings L times the solid angle: with that of a surface that sees a part of the ball only, be
//! it because another stands before it or because the rest is below its horizon, the expectation is the integral.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use super::super::sample::{LightEmission, SampledLight};
use super::pieces::Pieces;
use super::strata::Item;
use crate::sampling::basis;

/// Limits of what counts as a ball: the least cosine between a piece's normal and the way outwards, the length of the
/// mean normal, and the furthest over the nearest piece, and the brightest over the darkest. A ball of 80 triangles has
/// cosines of 0.97 and distances that differ by a tenth; a cube gives half as much more to its corners' side than to its
/// faces'.
const OUTWARDS: f32 = 0.95;
const CLOSED: f64 = 0.1;
const OBLONG: f32 = 1.15;
const UNEVEN: f32 = 1.2;

/// A lamp that is about a ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bulb {
    pub middle: Vec3,
    /// Of the ball of the same area, metres.
    pub radius: f32,
    /// Of a ball around all of it, metres.
    pub reach: f32,
}

/// Returns the ball that the pieces of a lamp are about, if they are: closed, facing outwards, as far from their middle
/// and as bright all around.
pub(super) fn bulb(items: &[Item], facing: f32, pieces: &Pieces) -> Option<Bulb> {
    let (mut middle, mut normal, mut weight) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for item in items {
        middle += Vec3::from_slice(&item.at[..3]).as_dvec3() * f64::from(item.weight);
        normal += Vec3::from_slice(&item.at[3..]).as_dvec3() * f64::from(item.weight);
        weight += f64::from(item.weight);
    }
    let middle = (middle / weight).as_vec3();
    let (mut nearest, mut furthest, mut reach, mut area) = (f32::INFINITY, 0.0_f32, 0.0_f32, 0.0);
    let (mut darkest, mut brightest) = (f32::INFINITY, 0.0_f32);
    for item in items {
        let (d, n) = (Vec3::from_slice(&item.at[..3]) - middle, Vec3::from_slice(&item.at[3..]));
        if d.dot(n) < OUTWARDS * d.length() * facing {
            return None;
        }
        let (size, l) = (pieces.areas[item.index as usize], pieces.luminance[item.index as usize]);
        (nearest, furthest) = (nearest.min(d.length()), furthest.max(d.length()));
        (darkest, brightest) = (darkest.min(l), brightest.max(l));
        reach = reach.max(d.length() + size.sqrt());
        area += f64::from(size);
    }
    let is_closed = normal.length() < CLOSED * weight * f64::from(facing);
    let radius = (area as f32 * 0.25 * FRAC_1_PI).sqrt();
    let is_ball = is_closed && furthest < OBLONG * nearest && brightest < UNEVEN * darkest;
    is_ball.then_some(Bulb { middle, radius, reach })
}

impl Bulb {
    /// Returns a random part of the ball as a light that shines on a position, by u in [0, 1)²: its light there has the
    /// ball's as expectation. `middle` is the point that stands for all of it.
    pub(super) fn sample(&self, middle: SampledLight, at: Vec3, u: Vec2) -> SampledLight {
        let d = self.middle - at;
        let r2 = d.length_squared();
        let sin2 = self.radius * self.radius / r2;
        if sin2 >= 1.0 || !r2.is_normal() {
            return middle;
        }
        // A direction in the cone, even over its solid angle.
        let less = sin2 / (1.0 + (1.0 - sin2).sqrt());
        let below = u.x * less;
        let (z, s2) = (1.0 - below, below * (2.0 - below));
        let (s, phi) = (s2.max(0.0).sqrt(), TAU * u.y);
        let axis = d / r2.sqrt();
        let (t, b) = basis(axis);
        let direction = t * (s * libm::cosf(phi)) + b * (s * libm::sinf(phi)) + axis * z;
        // The ray ends before all of the lamp's own surface.
        let along = r2.sqrt() * z;
        let distance = (along - (self.reach * self.reach - r2 * s2).max(0.0).sqrt()).max(0.01 * along);
        SampledLight {
            position: at + direction * distance,
            intensity: middle.intensity * (TAU * less * distance * distance / (PI * self.radius * self.radius)),
            emission: LightEmission::Isotropic,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::radical_inverse;
    use super::*;
    use crate::Falloff;

    const BULB: Bulb = Bulb { middle: Vec3::new(0.3, 2.0, -0.1), radius: 0.25, reach: 0.27 };

    /// Mean over 4096 rays of what arrives on a plane of normal n through the origin.
    fn irradiance(n: Vec3) -> f32 {
        let intensity = Vec3::splat(PI * BULB.radius * BULB.radius);
        let middle = SampledLight { position: BULB.middle, intensity, emission: LightEmission::Isotropic };
        let place = |i: u32| Vec2::new((i as f32 + 0.5) / 4096.0, radical_inverse(i));
        let light = |i: u32| BULB.sample(middle, Vec3::ZERO, place(i));
        let given = |i: u32| {
            let light = light(i);
            let (d, f) = light.arriving(Falloff::InverseSquare, Vec3::ZERO);
            light.intensity.x * f * d.dot(n).max(0.0)
        };
        (0..4096).map(given).sum::<f32>() / 4096.0
    }

    /// A ball of luminance 1 that is all above the horizon: E = π sin²α cosθ; half below it, seen at a right angle:
    /// ∫ over half of the cone, (2α − sin 2α) / 2.
    #[test]
    fn random_rays_bring_the_light_of_the_ball() {
        let d = BULB.middle;
        let sin2 = BULB.radius * BULB.radius / d.length_squared();
        for n in [d.normalize(), (d + Vec3::X).normalize()] {
            let expected = PI * sin2 * n.dot(d.normalize());
            assert!((irradiance(n) / expected - 1.0).abs() < 1e-3, "{} {expected}", irradiance(n));
        }
        let a = sin2.sqrt().asin();
        let expected = 0.5 * (2.0 * a - (2.0 * a).sin());
        let found = irradiance(d.cross(Vec3::X).normalize());
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    }
}
