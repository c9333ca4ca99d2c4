//! Sphere lights: punctual lights with a radius, as isotropic points in a ball that together look like a Lambertian
//! sphere.
//!
//! Points of density ∝ 1/√(R² − r²) in a ball of radius R project to a uniform disk from every side (Abel's transform
//! of it is constant): far away the ball is the sphere of equal power, penumbras included. By Newton's shell theorem
//! the irradiance vector outside the ball, I d/|d|³ summed over the points, is exactly that of one point in the middle,
//! as a Lambertian sphere's is. Unlike patches on a sphere, no sample faces away, and each is a plain point light.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;

use super::super::sample::{LightSample, SampledLight};
use super::super::stratum::{LaneStratum, Reach, Stratum};
use crate::sampling::{hash, unit_f32};
use crate::scene::Light;

/// Samples a point of the unit ball by u in [0, 1)³: r = sin a with (2a − sin 2a)/π = u.x, and a uniform direction.
pub(crate) fn sample_unit_ball(u: Vec3) -> Vec3 {
    let z = 1.0 - 2.0 * u.y;
    let phi = TAU * u.z;
    let s = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(s * libm::cosf(phi), s * libm::sinf(phi), z) * libm::sinf(angle(u.x))
}

/// The a of [`sample_unit_ball`], by bisection: 24 steps leave 2⁻²⁴ · π/2.
fn angle(u: f32) -> f32 {
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..24 {
        let a = 0.5 * (low + high);
        if 2.0 * a - libm::sinf(2.0 * a) < PI * u { low = a } else { high = a }
    }
    0.5 * (low + high)
}

/// Parts of a ball of equal volume in the numbers of [`sample_unit_ball`], the same for all sphere lights.
#[derive(Debug, Default)]
pub(super) struct BallStrata {
    boxes: Vec<[Vec3; 2]>,
}

impl BallStrata {
    /// `n` parts: the cube of numbers is halved again and again across the longest side of what it is in the ball.
    pub(super) fn new(n: u32) -> Self {
        let mut boxes = Vec::with_capacity(n as usize);
        divide(Vec3::ZERO, Vec3::ONE, n, &mut boxes);
        Self { boxes }
    }

    /// Returns a random point of part i of a light with this radius, as a light.
    pub(super) fn sample_light(&self, light: &Light, part: u32, radius: f32, u: Vec3) -> SampledLight {
        let light = light.moved(self.sample(part, u) * radius).dimmed(1.0 / self.boxes.len() as f32);
        SampledLight::of(&LightSample::Punctual(light))
    }

    /// Returns a point of the unit ball in part i by u in [0, 1)³.
    fn sample(&self, i: u32, u: Vec3) -> Vec3 {
        let [min, max] = self.boxes[i as usize];
        sample_unit_ball(min + (max - min) * u)
    }

    /// Returns a light for each part, in place of one with this radius; a directional light stays what it is.
    pub(super) fn lights(&self, index: u32, light: &Light, radius: f32) -> Vec<(LightSample, LaneStratum)> {
        if matches!(light, Light::Directional { .. }) {
            return vec![(LightSample::Punctual(*light), LaneStratum::default())];
        }
        let n = self.boxes.len() as u32;
        let at = |i: u32| {
            // Anywhere in the part, so that no direction sees them in rows.
            let u = Vec3::from_array([0, 1, 2].map(|k| unit_f32(hash(3 * i + k))));
            let sample = LightSample::Punctual(light.moved(self.sample(i, u) * radius).dimmed(1.0 / n as f32));
            let reach = Reach { radius: 2.0 * radius, spread: 0.0 };
            (sample, LaneStratum { stratum: Stratum::Ball { light: index, part: i }, reach })
        };
        (0..n).map(at).collect()
    }
}

fn divide(min: Vec3, max: Vec3, n: u32, boxes: &mut Vec<[Vec3; 2]>) {
    if n <= 1 {
        boxes.push([min, max]);
        return;
    }
    // Depth, height and turn of the part, in units of the radius.
    let (size, middle) = (max - min, 0.5 * (min + max));
    let z = 1.0 - 2.0 * middle.y;
    let lengths = Vec3::new(1.0, 2.0, TAU * (1.0 - z * z).max(0.0).sqrt()) * size * Vec3::new(1.0, 0.8, 0.8);
    let axis = if lengths.z >= lengths.x.max(lengths.y) { 2 } else { usize::from(lengths.y > lengths.x) };
    let left = n / 2;
    let (mut low, mut high) = (max, min);
    low[axis] = min[axis] + size[axis] * (left as f32 / n as f32);
    high[axis] = low[axis];
    divide(min, low, left, boxes);
    divide(high, max, n - left, boxes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::assert_uniform;

    fn invert_ball(p: Vec3) -> Vec3 {
        let r = p.length();
        let a = libm::asinf(r.min(1.0));
        let phi = libm::atan2f(p.y, p.x) / TAU;
        Vec3::new((2.0 * a - libm::sinf(2.0 * a)) / PI, 0.5 * (1.0 - p.z / r), if phi < 0.0 { phi + 1.0 } else { phi })
    }

    #[test]
    fn inverting_a_thousand_points_gives_their_numbers_back() {
        for i in 0..1000 {
            let u = Vec3::from_array([0, 1, 2].map(|d| 0.001 + 0.998 * sobol_burley::sample(i, d, 5)));
            let back = invert_ball(sample_unit_ball(u));
            assert!((back - u).abs().max_element() < 2e-3, "{u} {back}");
        }
    }

    /// The projection on any plane is a uniform disk, over 32 rings of equal area.
    #[test]
    fn sphere_lights_look_like_uniform_disks() {
        for axis in [Vec3::X, Vec3::new(0.36, 0.48, 0.8)] {
            let mut rings = [0_u32; 32];
            for i in 0..20_000 {
                let u = Vec3::from_array([0, 1, 2].map(|d| unit_f32(hash(3 * i + d))));
                let p = sample_unit_ball(u);
                let r2 = (p - axis * p.dot(axis)).length_squared();
                rings[(r2 * 32.0).min(31.0) as usize] += 1;
            }
            assert_uniform(&rings);
        }
    }

    /// A random part, and a random point of it, is a random point of the ball: its numbers fill 64 cells evenly.
    #[test]
    fn parts_fill_the_ball_evenly() {
        for n in [1, 37, 64] {
            let strata = BallStrata::new(n);
            let unit = |k: u32| unit_f32(hash(k));
            let mut cells = [0_u32; 64];
            for i in 0..20_000 {
                let part = (unit(4 * i) * n as f32) as u32;
                let u = Vec3::from_array([1, 2, 3].map(|k| unit(4 * i + k)));
                let at = (invert_ball(strata.sample(part, u)) * 4.0).min(Vec3::splat(3.0)).as_uvec3();
                cells[(at.x * 16 + at.y * 4 + at.z) as usize] += 1;
            }
            assert_uniform(&cells);
        }
    }
}
