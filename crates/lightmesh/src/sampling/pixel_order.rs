//! Which point of a Sobol sequence each sample of a picture takes.
//!
//! The pixels of a square tile share one sequence, and take its points in blocks along a Z-order curve: the samples of a
//! pixel are stratified, and so are those of each 2 × 2, 4 × 4, … pixels together. Noise averages out over a few pixels,
//! for the eye and for a denoiser (Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
//! Hierarchical Ordering of Pixels", SIGGRAPH Asia 2020).

use super::{Sampler, fold_seed, hash};

/// Bits of the numbers of a tile's samples: those of a sequence, less one as each path splits in two.
const BITS: u32 = 15;

/// The order of a picture's samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelOrder {
    width: u32,
    /// Bits of a sample's number in its pixel, and of a pixel's coordinates in its tile.
    sample_bits: u32,
    tile_bits: u32,
}

impl PixelOrder {
    /// Of a picture with so many pixels in a row, and samples in a pixel.
    pub(crate) fn new(width: u32, spp: u32) -> Self {
        let sample_bits = spp.max(1).next_power_of_two().ilog2();
        Self { width: width.max(1), sample_bits, tile_bits: BITS.saturating_sub(sample_bits) / 2 }
    }

    /// Returns the sampler of a sample of a pixel, which is numbered row by row.
    pub(crate) fn sampler(&self, seed: u64, pixel: u32, sample: u32) -> Sampler {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let (tile, inside) = (self.tile_bits, (1 << self.tile_bits) - 1);
        let seed = hash(hash(fold_seed(seed) ^ x >> tile) ^ y >> tile);
        let index = z_order(x & inside, y & inside, tile) << self.sample_bits | sample;
        Sampler::in_sequence(seed, index)
    }
}

/// Interleaves the low bits of two numbers.
fn z_order(x: u32, y: u32, bits: u32) -> u32 {
    (0..bits).map(|bit| (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 16 samples of 2 × 2 pixels: one in each sixty-fourth of both axes, and in each of 8 × 8 squares.
    #[test]
    fn neighbouring_pixels_share_their_strata() {
        let order = PixelOrder::new(100, 16);
        let (mut rows, mut squares) = ([0; 64], [0; 64]);
        for (x, y) in [(4, 6), (5, 6), (4, 7), (5, 7)] {
            for sample in 0..16 {
                let u = order.sampler(3, 100 * y + x, sample).next_pair();
                rows[(u.x * 64.0) as usize] += 1;
                squares[(u.x * 8.0) as usize * 8 + (u.y * 8.0) as usize] += 1;
            }
        }
        assert_eq!((rows, squares), ([1; 64], [1; 64]));
    }

    /// However many samples and pixels there are.
    #[test]
    fn samplers_are_all_different() {
        for (width, spp) in [(3, 1), (200, 4), (7, 100), (2, 65_536)] {
            let order = PixelOrder::new(width, spp);
            let step = (spp / 50).max(1) as usize;
            let samples = (0..200).flat_map(|pixel| (0..spp).step_by(step).map(move |sample| (pixel, sample)));
            let samplers: Vec<_> = samples.map(|(pixel, sample)| order.sampler(9, pixel, sample)).collect();
            let distinct: std::collections::HashSet<_> = samplers.iter().map(|s| (s.seed, s.index)).collect();
            assert_eq!(distinct.len(), samplers.len(), "{width} {spp}");
        }
    }
}
