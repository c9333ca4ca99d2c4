//! Radiance from spherical harmonics of irradiance.

use std::f32::consts::{FRAC_PI_4, PI, TAU};

use glam::Vec3;

/// Irradiance E(n) = Σ E_lm Y_lm(n) up to l = 2, in the order l m = 00, 1−1, 10, 11, 2−2, 2−1, 20, 21, 22.
#[derive(Clone, Copy, Debug)]
pub(super) struct Irradiance(pub(super) [Vec3; 9]);

/// The factor of the cosine lobe for each band: E_lm = Â_l L_lm, with Â = π, 2π/3, π/4. Ramamoorthi and Hanrahan, "An
/// Efficient Representation for Irradiance Environment Maps", SIGGRAPH 2001, equations (5) and (8).
const COSINE_LOBE: [f32; 3] = [PI, TAU / 3.0, FRAC_PI_4];

impl Irradiance {
    /// Radiance along a unit direction: L(ω) = max(0, Σ E_lm / Â_l · Y_lm(ω)). A source sharper than l = 2 comes out
    /// blurred, with the same irradiance wherever nothing was below 0.
    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let band = |i: usize| COSINE_LOBE[[0, 1, 1, 1, 2, 2, 2, 2, 2][i]];
        let basis = basis(direction);
        let sum: Vec3 = (0..9).map(|i| self.0[i] * (basis[i] / band(i))).sum();
        sum.max(Vec3::ZERO)
    }
}

/// The real spherical harmonics up to l = 2 of a unit vector, all with positive signs: equation (3) of the paper.
fn basis(Vec3 { x, y, z }: Vec3) -> [f32; 9] {
    [
        0.282_095,
        0.488_603 * y,
        0.488_603 * z,
        0.488_603 * x,
        1.092_548 * x * y,
        1.092_548 * y * z,
        0.315_392 * (3.0 * z * z - 1.0),
        1.092_548 * x * z,
        0.546_274 * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ of f over evenly spread directions, times 4π/n.
    fn integral(f: impl Fn(Vec3) -> Vec3) -> Vec3 {
        const N: u32 = 20_000;
        let golden = PI * (3.0 - 5.0_f32.sqrt());
        let direction = |i: u32| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / N as f32;
            let (sin, phi) = ((1.0 - y * y).sqrt(), golden * i as f32);
            Vec3::new(sin * libm::cosf(phi), y, sin * libm::sinf(phi))
        };
        (0..N).map(|i| f(direction(i))).sum::<Vec3>() * (4.0 * PI / N as f32)
    }

    /// The irradiance of the radiance is the irradiance that was given: ∫ L max(0, n·ω) dω = E(n).
    #[test]
    fn the_radiance_gives_back_the_irradiance() {
        // Of a sky 3 + y + 0.5 x + 0.4 x z: never below 0.
        let l = |d: Vec3| Vec3::splat(3.0 + d.y + 0.5 * d.x + 0.4 * d.x * d.z);
        let coefficient = |i: usize| {
            let lobe = COSINE_LOBE[[0, 1, 1, 1, 2, 2, 2, 2, 2][i]];
            integral(|d| l(d) * basis(d)[i]) * lobe
        };
        let irradiance = Irradiance(std::array::from_fn(coefficient));
        for n in [Vec3::Y, Vec3::X, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.6, 0.8)] {
            assert!((irradiance.radiance(n) - l(n)).abs().max_element() < 0.01, "{n}");
            let given = (0..9).map(|i| irradiance.0[i] * basis(n)[i]).sum::<Vec3>();
            let got = integral(|d| irradiance.radiance(d) * n.dot(d).max(0.0));
            assert!((got - given).abs().max_element() < 0.02, "{n}: {got} {given}");
        }
    }

    /// E = π everywhere is a sky of radiance 1: E_00 = π / Y_00.
    #[test]
    fn an_even_sky() {
        let mut e = [Vec3::ZERO; 9];
        e[0] = Vec3::splat(PI / 0.282_095);
        assert!((Irradiance(e).radiance(Vec3::Y) - 1.0).abs().max_element() < 1e-5);
        e[1] = Vec3::splat(-100.0);
        assert_eq!(Irradiance(e).radiance(Vec3::Y), Vec3::ZERO);
    }
}
