//! The parts into which lights fall that a light mesh keeps for themselves: what shines from a finite distance, the sky, and
//! suns.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16};
use glam::Vec3;

use super::samples::{LANES, LightSamples, for_each_block, sum};
use super::stratum::Stratum;
use crate::Falloff;

/// How many parts there are.
pub(crate) const PARTS: usize = 3;
/// Lights at a finite distance.
pub(crate) const NEAR: usize = 0;
/// Parts of the environment.
pub(crate) const SKY: usize = 1;
/// Parallel lights of their own.
pub(crate) const SUNS: usize = 2;

impl LightSamples {
    /// [`Self::irradiance`] of each part of the lights (see [`LightSamples::part`]).
    pub(crate) fn irradiance_of_parts(
        &self,
        level: Level,
        falloff: Falloff,
        points: impl ExactSizeIterator<Item = (Vec3, Vec3)>,
        out: &mut Vec<[Vec3; PARTS]>,
    ) {
        out.clear();
        out.reserve(points.len());
        dispatch!(level, simd => irradiance_of_parts_simd(simd, self, falloff, points, out));
    }

    /// Returns the part of the lights to which a lane belongs: [`NEAR`], [`SKY`] or [`SUNS`].
    pub(crate) fn part(&self, lane: usize) -> usize {
        match (self.is_directional(lane), self.stratum(lane)) {
            (false, _) => NEAR,
            (true, Stratum::Sky(_)) => SKY,
            (true, _) => SUNS,
        }
    }

    /// Whether there are suns, or lights of two parts.
    pub(crate) fn has_parts(&self) -> bool {
        let mut lit = (0..self.lanes()).filter(|&lane| self.intensity(lane) != Vec3::ZERO).map(|lane| self.part(lane));
        let first = lit.next();
        first.is_some_and(|first| first == SUNS || lit.any(|part| part != first))
    }
}

#[inline(always)]
fn irradiance_of_parts_simd<S: Simd>(
    simd: S,
    lights: &LightSamples,
    falloff: Falloff,
    points: impl ExactSizeIterator<Item = (Vec3, Vec3)>,
    out: &mut Vec<[Vec3; PARTS]>,
) {
    let zero = f32x16::splat(simd, 0.0);
    let plain = (lights.blocks.len() - lights.spots.len()) * LANES;
    // By block of spots and part: 1 for the lanes that belong to it.
    let belongs = |first: usize, part: usize| -> [f32; LANES] {
        std::array::from_fn(|i| f32::from(u8::from(lights.part(first + i) == part)))
    };
    let masks: Vec<[[f32; LANES]; PARTS]> =
        (plain..lights.lanes()).step_by(LANES).map(|first| std::array::from_fn(|part| belongs(first, part))).collect();
    for (p, n) in points {
        let mut sums = [[zero; 3]; PARTS];
        for_each_block(
            simd,
            lights,
            falloff,
            p,
            #[inline(always)]
            |block, first, l| {
                let e = (l.dx * n.x + l.dy * n.y + l.dz * n.z).max(zero) * l.f;
                // All before the spots are at finite distances.
                let masks = first.checked_sub(plain).map(|lane| &masks[lane / LANES]);
                for (channel, intensity) in [&block.r, &block.g, &block.b].into_iter().enumerate() {
                    let light = e * f32x16::from_slice(simd, intensity);
                    match masks {
                        None => sums[NEAR][channel] += light,
                        Some(masks) => {
                            for (sum, mask) in sums.iter_mut().zip(masks) {
                                sum[channel] += light * f32x16::load_array_ref(simd, mask);
                            }
                        }
                    }
                }
            },
        );
        out.push(sums.map(|channels| Vec3::from_array(channels.map(sum))));
    }
}
