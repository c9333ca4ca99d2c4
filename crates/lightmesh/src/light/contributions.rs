//! The contribution of each light to the sum at a surface, kept so that lights can be treated one by one afterwards.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;

use super::samples::{LANES, LightSamples, for_each_block, sum};
use crate::Falloff;

/// The least contribution of a stratum that may shine on a surface, in units of its light there if both faced each
/// other, times its radius over its distance. Empirical, not varied.
const LEAST: f32 = 0.1;

/// The surface point of a sum, and the attenuation of its lights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    /// Metres.
    pub position: Vec3,
    /// Unit shading normal.
    pub n: Vec3,
    /// Unit geometric normal: lights below its plane are probably occluded.
    pub ng: Vec3,
    /// Direction towards a near occluder, of any length: lights within 60° of it are probably occluded; zero: there is
    /// none.
    pub occluder_direction: Vec3,
    /// φ3.
    pub falloff: Falloff,
}

/// The contributions of a block of [`LANES`] lights at a surface.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct BlockTerms {
    /// Directions towards each light: x, y, z.
    directions: [[f32; LANES]; 3],
    /// f max(0, n · d), by which an intensity is multiplied.
    pub factors: [f32; LANES],
    /// c_i, mean over the channels.
    pub contributions: [f32; LANES],
    /// The sum of the contributions.
    pub contribution: f32,
    /// Which of the lights that shine on the surface are probably occluded, a bit per lane.
    pub towards_occluder: u32,
}

impl BlockTerms {
    const NOTHING: Self = Self {
        directions: [[0.0; LANES]; 3],
        factors: [0.0; LANES],
        contributions: [0.0; LANES],
        contribution: 0.0,
        towards_occluder: 0,
    };

    /// Returns the direction towards light i, not of unit length.
    #[inline(always)]
    pub(crate) fn direction(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.directions;
        Vec3::new(x[i], y[i], z[i])
    }

    /// Returns which lights contribute at least so much, a bit per lane.
    #[inline(always)]
    pub(crate) fn giving<S: Simd>(&self, simd: S, least: f32) -> u32 {
        f32x16::load_array_ref(simd, &self.contributions).simd_ge(f32x16::splat(simd, least)).to_bitmask() as u32
    }
}

/// The terms of all lights at one surface, block by block; kept between calls.
#[derive(Debug, Default)]
pub(crate) struct LightTerms {
    blocks: Vec<BlockTerms>,
}

impl LightTerms {
    /// Evaluates all lights at a surface. Returns Σ w_i c_i, lux per channel, with a weight for every lane, and Σ c_i,
    /// mean over the channels.
    #[inline(always)]
    pub(crate) fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        lights: &LightSamples,
        receiver: &Receiver,
        weights: &[f32],
    ) -> (Vec3, f32) {
        let Receiver { position, n, ng, occluder_direction, falloff } = *receiver;
        self.blocks.resize(lights.lanes() / LANES, BlockTerms::NOTHING);
        let zero = f32x16::splat(simd, 0.0);
        let least_cos2 = 0.25 * occluder_direction.length_squared();
        let (mut r, mut g, mut b) = (zero, zero, zero);
        let mut total = 0.0;
        let mut slots = self.blocks.iter_mut().zip(weights.chunks_exact(LANES));
        for_each_block(
            simd,
            lights,
            falloff,
            position,
            #[inline(always)]
            |block, _, l| {
                let Some((terms, w)) = slots.next() else { return };
                let e = (l.dx * n.x + l.dy * n.y + l.dz * n.z).max(zero) * l.f;
                let [red, green, blue] =
                    [&block.r, &block.g, &block.b].map(|channel| f32x16::load_array_ref(simd, channel));
                let contribution = e * (red + green + blue) * (1.0 / 3.0);
                // Mark lights below the geometric plane or near the occluder.
                let above = l.dx * ng.x + l.dy * ng.y + l.dz * ng.z;
                let mut towards_occluder = above.simd_le(zero);
                if least_cos2 > 0.0 {
                    let r2 = l.dx * l.dx + l.dy * l.dy + l.dz * l.dz;
                    let along = l.dx * occluder_direction.x + l.dy * occluder_direction.y + l.dz * occluder_direction.z;
                    towards_occluder |= (along * along.abs()).simd_gt(r2 * least_cos2);
                }
                terms.towards_occluder = (towards_occluder & contribution.simd_gt(zero)).to_bitmask() as u32;
                // Keep the terms, and add the weighted sum.
                for (lanes, d) in terms.directions.iter_mut().zip([l.dx, l.dy, l.dz]) {
                    d.store_array(lanes);
                }
                e.store_array(&mut terms.factors);
                contribution.store_array(&mut terms.contributions);
                terms.contribution = sum(contribution);
                total += terms.contribution;
                let weighted = e * f32x16::from_slice(simd, w);
                r += weighted * red;
                g += weighted * green;
                b += weighted * blue;
            },
        );
        (Vec3::new(sum(r), sum(g), sum(b)), total)
    }

    /// Raises the contributions of lanes that are clusters to at least `least`, by lane, in lux, mean over the
    /// channels, if any of their lights, which are within `radii` of their representatives, can be in front of a
    /// surface of this normal.
    #[inline(always)]
    pub(crate) fn raise_to_least(&mut self, n: Vec3, least: &[f32], radii: &[f32]) {
        let slots = self.blocks.iter_mut().zip(least.chunks_exact(LANES)).zip(radii.chunks_exact(LANES));
        for ((terms, least), radii) in slots {
            let [x, y, z] = &terms.directions;
            let mut more = 0.0;
            for i in 0..LANES {
                let above = n.x * x[i] + n.y * y[i] + n.z * z[i] + radii[i];
                let raised = if above > 0.0 { least[i] } else { 0.0 }.max(terms.contributions[i]);
                more += raised - terms.contributions[i];
                terms.contributions[i] = raised;
            }
            terms.contribution += more;
        }
    }

    /// Raises the contributions of lights whose strata may shine on a surface of normal n although their middle does
    /// not: some must be expected wherever light may arrive, or sampling in proportion to it would have a bias.
    #[inline(always)]
    pub(crate) fn raise_strata<S: Simd>(&mut self, simd: S, n: Vec3, lights: &LightSamples) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let load = |array: &[f32; LANES]| f32x16::load_array_ref(simd, array);
        let first_spots = lights.blocks.len() - lights.spots.len();
        let first_patches = first_spots - lights.patches.len();
        let slots = self.blocks.iter_mut().zip(&lights.blocks).zip(&lights.reaches);
        for (index, ((terms, block), reaches)) in slots.enumerate() {
            // How far each light is, in metres or of unit directions, and how large in comparison.
            let [x, y, z] = terms.directions.each_ref().map(load);
            let (radius, spread) = (load(&reaches.radius), load(&reaches.spread));
            let mut r2 = (x * x + y * y + z * z).max(radius * radius * 0.25);
            let mut ahead = one;
            if let Some(spots) = index.checked_sub(first_spots).map(|k| &lights.spots[k]) {
                r2 = load(&spots.w).simd_gt(zero).select(r2, one);
            }
            let r = r2.max(f32x16::splat(simd, f32::MIN_POSITIVE)).sqrt();
            let ratio = radius / r;
            if let Some(patch) = index.checked_sub(first_patches).and_then(|k| lights.patches.get(k)) {
                let cos = -(x * load(&patch.ax) + y * load(&patch.ay) + z * load(&patch.az)) / r;
                ahead = cos.max(cos * load(&patch.back)) + spread + ratio;
            }
            // Not below the surface, nor behind the emitter.
            let above = x * n.x + y * n.y + z * n.z + radius;
            let strength = (load(&block.r) + load(&block.g) + load(&block.b)) * (LEAST / 3.0);
            let least = (ratio + spread).min(one) / (r * r) * strength;
            let least = (above.min(ahead)).simd_gt(zero).select(least, zero);
            let contributions = load(&terms.contributions);
            let raised = least.max(contributions);
            terms.contribution += sum(raised - contributions);
            raised.store_array(&mut terms.contributions);
        }
    }

    /// The blocks of the last evaluation.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> &[BlockTerms] {
        &self.blocks
    }
}
