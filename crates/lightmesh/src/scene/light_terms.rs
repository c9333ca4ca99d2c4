//! Sums over lights of which each has its own weight, and the lights of the sum that are wanted one by one.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16};
use glam::Vec3;

use super::light_samples::{LANES, LightSamples, for_each_block, lanes_of_block, sum};
use crate::Falloff;

/// One light as it shines on a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    pub lane: u32,
    /// Its place in the list of those that were asked for; `None`: it is none of them, but doubtful.
    pub index: Option<u32>,
    /// Towards it.
    pub direction: Vec3,
    /// f max(0, n · d): what its intensity is multiplied by.
    pub factor: f32,
    /// c_i, mean over the channels.
    pub mass: f32,
}

/// What the lights of a block of [`LANES`] give together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlockSum {
    /// The sum of c_i, mean over the channels, of all but those that are wanted one by one.
    pub mass: f32,
    /// Which those are, a bit per lane.
    pub terms: u32,
}

/// Surface and attenuation of a sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    /// Metres.
    pub position: Vec3,
    /// Unit shading normal.
    pub n: Vec3,
    /// Unit geometric normal: lights below its plane are wanted one by one.
    pub ng: Vec3,
    /// So are lights within 60° of this direction, of any length; zero: none are.
    pub doubt: Vec3,
    /// φ3.
    pub falloff: Falloff,
}

impl LightSamples {
    /// Σ w_i c_i, lux per channel, with a weight for every lane, over all lights but the terms: those of `lanes` (ascending)
    /// and the doubtful ones that shine on the surface; and what each block gives.
    pub(crate) fn weighted_irradiance(
        &self,
        level: Level,
        receiver: &Receiver,
        weights: &[f32],
        lanes: &[u32],
        terms: &mut Vec<Term>,
        sums: &mut Vec<BlockSum>,
    ) -> Vec3 {
        terms.clear();
        sums.clear();
        let mut sum = Vec3::ZERO;
        dispatch!(level, simd => {
            sum = weighted_irradiance_simd(simd, self, receiver, weights, lanes, (terms, sums));
        });
        sum
    }

    /// f max(0, n · d) and d of every light of a block.
    pub(crate) fn block_terms(&self, level: Level, receiver: &Receiver, block: usize) -> [(Vec3, f32); LANES] {
        dispatch!(level, simd => block_terms_simd(simd, self, receiver, block))
    }
}

#[inline(always)]
fn weighted_irradiance_simd<S: Simd>(
    simd: S,
    lights: &LightSamples,
    receiver: &Receiver,
    weights: &[f32],
    lanes: &[u32],
    (terms, sums): (&mut Vec<Term>, &mut Vec<BlockSum>),
) -> Vec3 {
    let Receiver { position, n, ng, doubt, falloff } = *receiver;
    let zero = f32x16::splat(simd, 0.0);
    let (mut r, mut g, mut b) = (zero, zero, zero);
    let mut index = 0;
    for_each_block(
        simd,
        lights,
        falloff,
        position,
        #[inline(always)]
        |block, first, l| {
            let e = (l.dx * n.x + l.dy * n.y + l.dz * n.z).max(zero) * l.f;
            let [red, green, blue] = [&block.r, &block.g, &block.b].map(|channel| f32x16::from_slice(simd, channel));
            let mass = e * (red + green + blue) * (1.0 / 3.0);
            let above = l.dx * ng.x + l.dy * ng.y + l.dz * ng.z;
            let r2 = l.dx * l.dx + l.dy * l.dy + l.dz * l.dz;
            let beyond = l.dx * doubt.x + l.dy * doubt.y + l.dz * doubt.z;
            let doubtful = (above.simd_le(zero)
                | (beyond * beyond.abs()).simd_gt(r2 * (0.25 * doubt.length_squared())))
                & mass.simd_gt(zero);
            let asked = lanes.get(index).is_some_and(|&lane| (lane as usize) < first + LANES);
            let mut w = f32x16::from_slice(simd, &weights[first..first + LANES]);
            if asked || doubtful.any_true() {
                // Some of the block are wanted one by one.
                let (mut factors, mut d, mut masses, mut ws) =
                    ([0.0; LANES], [[0.0; LANES]; 3], [0.0; LANES], [0.0; LANES]);
                e.store_slice(&mut factors);
                l.dx.store_slice(&mut d[0]);
                l.dy.store_slice(&mut d[1]);
                l.dz.store_slice(&mut d[2]);
                mass.store_slice(&mut masses);
                w.store_slice(&mut ws);
                let mut wanted = doubtful.to_bitmask() as u32;
                let begin = index;
                while let Some(&lane) = lanes.get(index).filter(|&&lane| (lane as usize) < first + LANES) {
                    wanted |= 1 << (lane as usize - first);
                    index += 1;
                }
                let bits = wanted;
                let mut asked = (begin..index).map(|i| (i as u32, lanes[i])).peekable();
                while wanted != 0 {
                    let i = wanted.trailing_zeros() as usize;
                    wanted &= wanted - 1;
                    let lane = (first + i) as u32;
                    let index = asked.next_if(|&(_, asked)| asked == lane).map(|(index, _)| index);
                    ws[i] = 0.0;
                    let mass = std::mem::take(&mut masses[i]);
                    if mass > 0.0 {
                        let direction = Vec3::new(d[0][i], d[1][i], d[2][i]);
                        terms.push(Term { lane, index, direction, factor: factors[i], mass });
                    }
                }
                w = f32x16::from_slice(simd, &ws);
                sums.push(BlockSum { mass: masses.iter().sum(), terms: bits });
            } else {
                sums.push(BlockSum { mass: sum(mass), terms: 0 });
            }
            let weighted = e * w;
            r += weighted * red;
            g += weighted * green;
            b += weighted * blue;
        },
    );
    Vec3::new(sum(r), sum(g), sum(b))
}

#[inline(always)]
fn block_terms_simd<S: Simd>(
    simd: S,
    lights: &LightSamples,
    receiver: &Receiver,
    block: usize,
) -> [(Vec3, f32); LANES] {
    let l = lanes_of_block(simd, lights, receiver.falloff, receiver.position, block);
    let n = receiver.n;
    let e = (l.dx * n.x + l.dy * n.y + l.dz * n.z).max(f32x16::splat(simd, 0.0)) * l.f;
    std::array::from_fn(|i| (Vec3::new(l.dx[i], l.dy[i], l.dz[i]), e[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Light;
    use crate::scene::emitters::LightSample;

    fn lights() -> LightSamples {
        let light = |i: i32| Light::Point {
            position: Vec3::new(i as f32 * 0.7 - 9.0, 2.0 - 0.3 * (i % 11) as f32, 1.0),
            intensity_cd: Vec3::new(1.0, 2.0, 0.5) * (1 + i % 5) as f32,
            range: (i % 4 == 0).then_some(30.0),
        };
        LightSamples::new(&(0..45).map(|i| LightSample::Punctual(light(i))).collect::<Vec<_>>())
    }

    /// Weights of one give the plain sum; weights of nothing plus the terms of all lanes too; masses are what is not asked for.
    #[test]
    fn parts_make_the_whole() {
        let (lights, level) = (lights(), Level::new());
        let receiver = Receiver {
            position: Vec3::new(0.1, -0.2, 0.3),
            n: Vec3::new(0.6, 0.8, 0.0),
            ng: Vec3::new(0.6, 0.8, 0.0),
            doubt: Vec3::ZERO,
            falloff: Falloff::InverseSquare,
        };
        let mut plain = Vec::new();
        lights.irradiance(level, receiver.falloff, [(receiver.position, receiver.n)].into_iter(), &mut plain);
        let (mut terms, mut sums) = (Vec::new(), Vec::new());
        let ones = vec![1.0; lights.lanes()];
        assert_eq!(lights.weighted_irradiance(level, &receiver, &ones, &[], &mut terms, &mut sums), plain[0]);

        let all: Vec<u32> = (0..lights.lanes() as u32).collect();
        let zeros = vec![0.0; lights.lanes()];
        let nothing = lights.weighted_irradiance(level, &receiver, &zeros, &all, &mut terms, &mut sums);
        let sum: Vec3 = terms.iter().map(|t| lights.intensity(t.lane as usize) * t.factor).sum();
        assert!(nothing == Vec3::ZERO && (sum - plain[0]).length() < 1e-5 * sum.length());

        lights.weighted_irradiance(level, &receiver, &ones, &all[..20], &mut terms, &mut sums);
        let asked: f32 = terms.iter().map(|t| (lights.intensity(t.lane as usize) * t.factor).element_sum() / 3.0).sum();
        let (rest, whole) = (sums.iter().map(|s: &BlockSum| s.mass).sum::<f32>(), plain[0].element_sum() / 3.0);
        assert!((asked + rest - whole).abs() < 1e-5 * whole);
    }

    #[test]
    fn a_block_alone_is_the_block_in_the_sum() {
        let (lights, level) = (lights(), Level::new());
        let receiver = Receiver {
            position: Vec3::ZERO,
            n: Vec3::Y,
            ng: Vec3::Y,
            doubt: Vec3::ZERO,
            falloff: Falloff::InverseSquare,
        };
        let all: Vec<u32> = (0..lights.lanes() as u32).collect();
        let (mut terms, mut sums, zeros) = (Vec::new(), Vec::new(), vec![0.0; lights.lanes()]);
        lights.weighted_irradiance(level, &receiver, &zeros, &all, &mut terms, &mut sums);
        for term in &terms {
            let alone = lights.block_terms(level, &receiver, term.lane as usize / LANES)[term.lane as usize % LANES];
            assert_eq!(alone, (term.direction, term.factor));
        }
    }
}
