//! A pass: which samples are being taken, and how many of them are done.

use std::ops::Range;

/// Some samples of each of some pixels; those of one pixel follow each other.
#[derive(Clone, Debug)]
pub(super) struct Pass {
    /// The pixels; `None`: all, in tile order.
    pub(super) pixels: Option<Vec<u32>>,
    /// Which samples of each.
    pub(super) indices: Range<u32>,
    /// How many samples have all their light in the film.
    pub(super) done: u64,
    /// The sample at which it ends early, as a part of a distributed picture does.
    pub(super) end: Option<u64>,
}

impl Pass {
    /// How many samples are left if the pass has `pixels` pixels.
    pub(super) fn left(&self, pixels: u64) -> u64 {
        pixels * self.samples_per_pixel() - self.done
    }

    /// Samples of each pixel.
    pub(super) fn samples_per_pixel(&self) -> u64 {
        u64::from(self.indices.end - self.indices.start)
    }

    /// Returns runs of pixels, by number, that have equally many samples, and how many samples, those of earlier passes
    /// included: the pixels that are done, the one that is begun, the rest. Runs may be empty.
    pub(crate) fn counts(&self, pixels: u64) -> [(Range<u64>, u32); 3] {
        let each = self.samples_per_pixel();
        let (done, begun) = (self.done / each, (self.done % each) as u32);
        let rest = (done + u64::from(begun > 0)).min(pixels);
        let start = self.indices.start;
        [(0..done, self.indices.end), (done..rest, start + begun), (rest..pixels, start)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The runs cover the pixels in order and count what earlier passes took and what was taken since.
    #[test]
    fn counts_add_up() {
        for done in 0..=15 {
            let pass = Pass { pixels: None, indices: 2..5, done, end: None };
            let runs = pass.counts(5);
            assert!(runs.iter().flat_map(|(numbers, _)| numbers.clone()).eq(0..5), "{runs:?}");
            let samples: u64 = runs.iter().map(|(run, count)| (run.end - run.start) * u64::from(*count)).sum();
            assert_eq!(samples, 5 * 2 + done, "{runs:?}");
        }
    }
}
