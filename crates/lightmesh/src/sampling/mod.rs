//! Sample positions: the film, the hemisphere, and choices; all seeded from (pixel, sample, dimension).

mod bits;
#[cfg(test)]
pub(crate) mod chi_square;
mod piecewise_constant;
mod pixel_order;
mod rng;

use std::f32::consts::TAU;

pub(crate) use bits::set_bits;
use glam::{Vec2, Vec3};
pub(crate) use piecewise_constant::Table;
pub(crate) use pixel_order::PixelOrder;
pub(crate) use rng::{INV_GOLDEN, fold_seed, hash, seed_of_coordinate, seed_of_position, seed_of_surface, unit_f32};

/// Samples of one pixel: an Owen-scrambled Sobol sequence (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020),
/// four dimensions at a time, decorrelated between sequences and groups of dimensions by their seeds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler {
    index: u32,
    seed: u32,
    dimension: u32,
    choices: u32,
}

impl Sampler {
    /// Makes the sampler of the `sample`-th path of a pixel by itself.
    pub(crate) fn new(seed: u64, pixel: u32, sample: u32) -> Self {
        Self::in_sequence(hash(fold_seed(seed) ^ pixel), sample)
    }

    /// Makes the sampler of a point of the sequence of a seed.
    fn in_sequence(seed: u32, index: u32) -> Self {
        Self { index, seed, dimension: 0, choices: 0 }
    }

    /// Returns the sampler of one of `count` paths that this one splits into. All such paths of a pixel share one point
    /// set.
    pub(crate) fn split(&self, branch: u32, count: u32) -> Self {
        // Sets have at most 2¹⁶ points.
        let index = u64::from(self.index) * u64::from(count) + u64::from(branch);
        let seed = hash(self.seed.wrapping_add(1 + (index >> 16) as u32));
        Self { index: index as u32 & 0xffff, seed, dimension: 0, choices: 0 }
    }

    /// Returns the next number, in [0, 1).
    pub(crate) fn next(&mut self) -> f32 {
        let group = self.dimension / 4;
        let x = sobol_burley::sample(self.index, self.dimension % 4, self.seed.wrapping_add(hash(group)));
        self.dimension += 1;
        x
    }

    /// Returns a number in [0, 1) that uses no dimension of the sequence: for choices, most of which have one
    /// alternative only.
    pub(crate) fn choice(&mut self) -> f32 {
        self.choices += 1;
        unit_f32(hash(hash(self.seed ^ hash(self.index)).wrapping_add(self.choices)))
    }

    /// The next two numbers, from one stratified pair.
    pub(crate) fn next_pair(&mut self) -> Vec2 {
        self.dimension += self.dimension % 2;
        Vec2::new(self.next(), self.next())
    }
}

/// Returns the positions of `count` samples of a pixel in [0, 1)², in units of 2⁻³²: Owen-scrambled Sobol points.
pub(crate) fn film_samples(count: u32) -> Vec<[u32; 2]> {
    let digits = |i, dimension| (sobol_burley::sample(i, dimension, 0) * (1_u64 << 32) as f32) as u32;
    (0..count).map(|i| [digits(i, 0), digits(i, 1)]).collect()
}

/// A direction about +Z with pdf cosθ / π, from u in [0, 1)²: Malley's method on a uniform disk in polar coordinates.
pub(crate) fn sample_cosine_hemisphere(u: Vec2) -> Vec3 {
    let (r, phi) = (u.x.sqrt(), TAU * u.y);
    let z = (1.0 - u.x).max(0.0).sqrt();
    Vec3::new(r * libm::cosf(phi), r * libm::sinf(phi), z)
}

/// The density of [`sample_cosine_hemisphere`] per steradian, at this cosine; 0 below the horizon.
pub(crate) fn pdf_cosine_hemisphere(cos: f32) -> f32 {
    cos.max(0.0) * std::f32::consts::FRAC_1_PI
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al., "Building an Orthonormal
/// Basis, Revisited", JCGT 2017).
pub(crate) fn basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse of `sample_cosine_hemisphere`.
    fn invert_cosine_hemisphere(w: Vec3) -> Vec2 {
        let phi = libm::atan2f(w.y, w.x) / TAU;
        Vec2::new(w.x * w.x + w.y * w.y, if phi < 0.0 { phi + 1.0 } else { phi })
    }

    #[test]
    fn inverting_a_thousand_directions_gives_their_numbers_back() {
        for i in 0..1000 {
            let u = Vec2::new(sobol_burley::sample(i, 0, 1), sobol_burley::sample(i, 1, 1));
            let w = sample_cosine_hemisphere(u);
            assert!((w.length() - 1.0).abs() < 1e-5);
            assert!((invert_cosine_hemisphere(w) - u).length() < 1e-4, "{u} {w}");
        }
    }

    /// u is uniform, so the inverted samples of an independent rejection sampler (uniform points of the disk, lifted)
    /// fill 64 cells of equal probability evenly.
    #[test]
    fn the_density_is_the_cosine() {
        let mut cells = [0u32; 64];
        for i in 0..40_000u32 {
            let unit = |k: u32| unit_f32(hash(i * 2 + k));
            let (x, y) = (2.0 * unit(0) - 1.0, 2.0 * unit(1) - 1.0);
            if x * x + y * y >= 1.0 {
                continue;
            }
            let u = invert_cosine_hemisphere(Vec3::new(x, y, (1.0 - x * x - y * y).sqrt()));
            cells[((u.x * 8.0) as usize).min(7) * 8 + ((u.y * 8.0) as usize).min(7)] += 1;
        }
        chi_square::assert_uniform(&cells);
    }

    /// ∫ cosθ / π over the hemisphere is 1, by the midpoint rule in (cosθ, φ).
    #[test]
    fn the_pdf_integrates_to_one() {
        let n = 1000;
        let integral: f32 = (0..n).map(|i| pdf_cosine_hemisphere((i as f32 + 0.5) / n as f32) * TAU / n as f32).sum();
        assert!((integral - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_basis_is_orthonormal_and_right_handed() {
        for n in [Vec3::X, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.6, 0.0, -0.8), Vec3::new(0.36, 0.48, 0.8)] {
            let (t, b) = basis(n);
            assert!((t.cross(b) - n).length() < 1e-5 && t.dot(b).abs() < 1e-6 && (t.length() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn samplers_differ_between_pixels_and_repeat_themselves() {
        let first = |pixel| Sampler::new(7, pixel, 0).next();
        assert_eq!(first(1), first(1));
        assert_ne!(first(1), first(2));
    }
}
