//! Sphere lights: punctual lights with a radius, as isotropic points in a ball that together look like a Lambertian
//! sphere.
//!
//! Points of density ∝ 1/√(R² − r²) in a ball of radius R project to a uniform disk from every side (Abel's transform
//! of it is constant): far away the ball is the sphere of equal power, penumbras included. By Newton's shell theorem
//! the irradiance vector outside the ball, I d/|d|³ summed over the points, is exactly that of one point in the middle,
//! as a Lambertian sphere's is. Unlike patches on a sphere, no sample faces away, and each is a plain point light.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;

use super::super::sample::LightSample;
use super::radical_inverse;
use crate::sampling::unit_f32;
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

/// Returns `n` evenly distributed points of equal power in place of a light; a directional light stays what it is.
pub(super) fn samples(light: &Light, radius: f32, n: u32) -> Vec<LightSample> {
    if matches!(light, Light::Directional { .. }) {
        return vec![LightSample::Punctual(*light)];
    }
    (0..n)
        .map(|i| {
            // Directions on a spherical Fibonacci lattice, radii by the radical inverse: neighbours differ in depth.
            let golden = unit_f32(i.wrapping_mul(2_654_435_769));
            let u = Vec3::new(radical_inverse(i), (i as f32 + 0.5) / n as f32, golden);
            LightSample::Punctual(light.moved(sample_unit_ball(u) * radius).dimmed(1.0 / n as f32))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::assert_uniform;
    use crate::sampling::hash;

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
}
