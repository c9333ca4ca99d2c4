//! What each light of a sum gives at a surface, kept so that lights can be looked at one by one afterwards.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;

use super::samples::{LANES, LightSamples, for_each_block, sum};
use crate::Falloff;

/// Surface and attenuation of a sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    /// Metres.
    pub position: Vec3,
    /// Unit shading normal.
    pub n: Vec3,
    /// Unit geometric normal: lights below its plane are doubtful.
    pub ng: Vec3,
    /// So are lights within 60° of this direction, of any length; zero: none are.
    pub occluder_direction: Vec3,
    /// φ3.
    pub falloff: Falloff,
}

/// What the lights of a block of [`LANES`] give at a surface.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct BlockTerms {
    /// Towards each light: x, y, z.
    directions: [[f32; LANES]; 3],
    /// f max(0, n · d): what its intensity is multiplied by.
    pub factors: [f32; LANES],
    /// c_i, mean over the channels.
    pub contributions: [f32; LANES],
    /// The sum of the masses.
    pub contribution: f32,
    /// Which of them are doubtful, a bit per lane; all of these shine on the surface.
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

    /// Towards light i, not of unit length.
    #[inline(always)]
    pub(crate) fn direction(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.directions;
        Vec3::new(x[i], y[i], z[i])
    }

    /// Which lights give at least so much, a bit per lane.
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
    /// Looks at all lights from a surface: Σ w_i c_i, lux per channel, with a weight for every lane, and Σ c_i, mean over the channels.
    #[inline(always)]
    pub(crate) fn evaluate<S: Simd>(
        &mut self,
        simd: S,
        lights: &LightSamples,
        receiver: &Receiver,
        weights: &[f32],
    ) -> (Vec3, f32) {
        let Receiver { position, n, ng, occluder_direction: doubt, falloff } = *receiver;
        self.blocks.resize(lights.lanes() / LANES, BlockTerms::NOTHING);
        let zero = f32x16::splat(simd, 0.0);
        let beyond_least = 0.25 * doubt.length_squared();
        let (mut r, mut g, mut b) = (zero, zero, zero);
        let mut total = 0.0;
        let mut rooms = self.blocks.iter_mut().zip(weights.chunks_exact(LANES));
        for_each_block(
            simd,
            lights,
            falloff,
            position,
            #[inline(always)]
            |block, _, l| {
                let Some((terms, w)) = rooms.next() else { return };
                let e = (l.dx * n.x + l.dy * n.y + l.dz * n.z).max(zero) * l.f;
                let [red, green, blue] =
                    [&block.r, &block.g, &block.b].map(|channel| f32x16::load_array_ref(simd, channel));
                let mass = e * (red + green + blue) * (1.0 / 3.0);
                let above = l.dx * ng.x + l.dy * ng.y + l.dz * ng.z;
                let mut doubtful = above.simd_le(zero);
                if beyond_least > 0.0 {
                    let r2 = l.dx * l.dx + l.dy * l.dy + l.dz * l.dz;
                    let beyond = l.dx * doubt.x + l.dy * doubt.y + l.dz * doubt.z;
                    doubtful |= (beyond * beyond.abs()).simd_gt(r2 * beyond_least);
                }
                terms.towards_occluder = (doubtful & mass.simd_gt(zero)).to_bitmask() as u32;
                for (room, d) in terms.directions.iter_mut().zip([l.dx, l.dy, l.dz]) {
                    d.store_array(room);
                }
                e.store_array(&mut terms.factors);
                mass.store_array(&mut terms.contributions);
                terms.contribution = sum(mass);
                total += terms.contribution;
                let weighted = e * f32x16::from_slice(simd, w);
                r += weighted * red;
                g += weighted * green;
                b += weighted * blue;
            },
        );
        (Vec3::new(sum(r), sum(g), sum(b)), total)
    }

    /// Reckons with lanes that are clusters: in front of a surface of this normal they give at least `least`, by lane, in lux, mean over
    /// the channels, if any of their lights, which are within `radii` of their places, can be above it.
    #[inline(always)]
    pub(crate) fn raise_to_least(&mut self, n: Vec3, least: &[f32], radii: &[f32]) {
        let rooms = self.blocks.iter_mut().zip(least.chunks_exact(LANES)).zip(radii.chunks_exact(LANES));
        for ((terms, least), radii) in rooms {
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

    /// The blocks, as they were seen last.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> &[BlockTerms] {
        &self.blocks
    }
}
