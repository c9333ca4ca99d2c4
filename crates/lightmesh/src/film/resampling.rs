//! More samples for the pixels that need them: on outlines, in small shadows, where few rays make noise.

use super::pass::Pass;
use super::sample_noise::PartMean;
use super::{BRIGHTEST, Film, WAVE};

impl Film {
    /// Keeps the sums so far, the first part of every pixel's samples: from how the rest differs follows the noise.
    pub(super) fn keep_first_part(&mut self) {
        self.noise.first = self.sums.clone();
    }

    /// Finds the noise of every pixel from the `first` samples, whose sums have been kept, and the rest of them. Pixels that
    /// have been sampled anew since have none. Returns the picture's error by it, relative to its mean.
    pub(super) fn find_noise(&mut self, first: u32) -> f64 {
        let (spp, mean) = (self.spp, self.mean());
        let sums = std::mem::take(&mut self.noise.first);
        let parts = sums.iter().zip(&self.sums).map(|(&part, &sum)| {
            let of = |sum: glam::Vec3, count: u32| PartMean { mean: sum / count.max(1) as f32, count };
            [of(part, first), of(sum - part, spp - first)]
        });
        self.noise.set_all(mean, parts);
        for (pixel, &taken) in (0..).zip(&self.taken) {
            if taken != spp {
                self.noise.forget(pixel);
            }
        }
        self.noise.error()
    }

    /// Begins a pass over the pixels with most noise that have `count` samples, as many as it takes that the picture's
    /// error by noise is `error`, but no more samples than `most`. They go on to four times as many samples each, at most
    /// `samples`. Returns false if there is none.
    pub(super) fn begin_resampling(&mut self, count: u32, samples: u32, error: f64, most: u64) -> bool {
        let each = u64::from(samples.saturating_sub(count)).clamp(1, WAVE);
        let may_have = |pixel: u32| self.taken[pixel as usize] == count;
        let chosen = self.noise.choose(self.order.width, error, (most / each) as usize, may_have);
        if chosen.is_empty() || samples <= count {
            return false;
        }
        // In tile order neighbours are sampled together.
        let mut is_chosen = vec![false; self.sums.len()];
        chosen.iter().for_each(|&pixel| is_chosen[pixel as usize] = true);
        let pixels: Vec<u32> =
            self.order.pixels(0..self.order.len() as u64).filter(|&pixel| is_chosen[pixel as usize]).collect();
        self.noise.first = self.sums_of(&pixels);
        self.set_samples(samples);
        self.pass = Pass::new(Some(pixels), count..samples);
        true
    }

    /// Ends it: finds the noise that its pixels have now. Returns the picture's error by noise.
    pub(super) fn end_resampling(&mut self) -> f64 {
        let mean = self.mean();
        let before = std::mem::take(&mut self.noise.first);
        let (count, more) = (self.pass.indices.start, self.pass.samples_per_pixel() as u32);
        for (&pixel, sum) in self.pass.pixels.iter().flatten().zip(before) {
            let rest = (self.sums[pixel as usize] - sum) / more.max(1) as f32;
            let parts = [PartMean { mean: sum / count as f32, count }, PartMean { mean: rest, count: more }];
            self.noise.set(pixel, mean, parts);
        }
        self.noise.error()
    }

    /// The mean of the picture so far, over pixels and channels; what is brighter than [`BRIGHTEST`] times what it would be
    /// without that counts as so much.
    fn mean(&self) -> f32 {
        let of = |most: f32| {
            let means = self.sums.iter().zip(&self.taken).map(|(sum, &taken)| *sum / taken.max(1) as f32);
            means.map(|mean| f64::from(mean.min(glam::Vec3::splat(most)).element_sum())).sum::<f64>()
                / (3 * self.sums.len().max(1)) as f64
        };
        of(BRIGHTEST * of(f32::INFINITY) as f32) as f32
    }
}
