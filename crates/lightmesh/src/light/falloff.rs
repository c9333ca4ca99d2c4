//! How light fades with distance: φ, what an intensity is divided by. Written for one light and for a block of them,
//! which a test holds together bit for bit.

use fearless_simd::{Simd, f32x16};

use crate::Falloff;

impl Falloff {
    /// φ at the distance `r`, whose square is `r2`: callers have both, or know how to round them.
    #[inline(always)]
    pub(crate) fn phi(self, r2: f32, r: f32) -> f32 {
        match self {
            Self::InverseSquare => r2,
            Self::ConstantPlusDistance { constant } => r + constant,
        }
    }

    /// The SIMD twin of [`Falloff::phi`].
    #[inline(always)]
    pub(super) fn phi_simd<S: Simd>(self, r2: f32x16<S>, r: f32x16<S>) -> f32x16<S> {
        match self {
            Self::InverseSquare => r2,
            Self::ConstantPlusDistance { constant } => r + constant,
        }
    }

    /// 1/φ: what one candela brings to a surface that faces it, lux.
    #[inline(always)]
    pub(crate) fn attenuation(self, r2: f32, r: f32) -> f32 {
        1.0 / self.phi(r2, r)
    }

    /// 1/(φ r), to be multiplied by a direction that keeps its length r.
    #[inline(always)]
    pub(crate) fn attenuation_over_distance(self, r2: f32, r: f32) -> f32 {
        1.0 / (self.phi(r2, r) * r)
    }

    /// The SIMD twin of [`Falloff::attenuation_over_distance`].
    #[inline(always)]
    pub(super) fn attenuation_over_distance_simd<S: Simd>(self, r2: f32x16<S>, r: f32x16<S>) -> f32x16<S> {
        1.0 / (self.phi_simd(r2, r) * r)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::prelude::*;
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::sampling::{hash, unit_f32};

    const FALLOFFS: [Falloff; 2] = [Falloff::InverseSquare, Falloff::ConstantPlusDistance { constant: 0.3 }];

    /// 1/r², and 1/(Const + r), at 2 m.
    #[test]
    fn attenuation_is_the_closed_form() {
        assert_eq!(FALLOFFS.map(|falloff| falloff.attenuation(4.0, 2.0)), [0.25, 1.0 / 2.3]);
        assert_eq!(FALLOFFS.map(|falloff| falloff.attenuation_over_distance(4.0, 2.0)), [0.125, 1.0 / 4.6]);
    }

    #[inline(always)]
    fn simd_values<S: Simd>(simd: S, falloff: Falloff, distances: &[f32; 16]) -> [f32; 16] {
        let r = f32x16::from_slice(simd, distances);
        let mut values = [0.0; 16];
        falloff.attenuation_over_distance_simd(r * r, r).store_slice(&mut values);
        values
    }

    /// At distances from 1 µm to 1000 km.
    #[test]
    fn one_light_and_a_block_of_lights_agree_bit_for_bit() {
        for i in 0..1000 {
            let distances: [f32; 16] =
                std::array::from_fn(|k| libm::powf(10.0, 12.0 * unit_f32(hash(16 * i + k as u32)) - 6.0));
            for falloff in FALLOFFS {
                for level in [Level::new(), Level::baseline()] {
                    let values = dispatch!(level, simd => simd_values(simd, falloff, &distances));
                    let one_by_one = distances.map(|r| falloff.attenuation_over_distance(r * r, r));
                    assert_eq!(values.map(f32::to_bits), one_by_one.map(f32::to_bits), "{falloff:?} {distances:?}");
                }
            }
        }
    }
}
