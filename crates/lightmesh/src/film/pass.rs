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
    /// None of these samples are done.
    pub(super) fn new(pixels: Option<Vec<u32>>, indices: Range<u32>) -> Self {
        Self { pixels, indices, done: 0, end: None }
    }

    /// Samples of each pixel.
    pub(super) fn samples_per_pixel(&self) -> u64 {
        u64::from(self.indices.end - self.indices.start)
    }
}
