//! Some waves of a pass: what they bring to the film, taken off it and put on another one.

use std::ops::Range;

use super::Film;

impl Film {
    /// How many waves the pass has.
    pub(crate) fn wave_count(&self) -> u64 {
        self.sample_count().div_ceil(self.samples_per_wave())
    }

    /// Lets the pass begin and end with some of its waves.
    pub(crate) fn begin_portion(&mut self, waves: Range<u64>) {
        let (wave, all) = (self.samples_per_wave(), self.sample_count());
        self.pass.done = (waves.start * wave).min(all);
        self.pass.end = Some((waves.end * wave).min(all));
    }

    /// The pixels of some waves of the pass, in the order in which they are sampled.
    pub(crate) fn portion_pixels(&self, waves: Range<u64>) -> Vec<u32> {
        let wave = self.samples_per_wave() / self.pass.samples_per_pixel();
        let all = self.pass_pixels();
        let numbers = (waves.start * wave).min(all)..(waves.end * wave).min(all);
        match &self.pass.pixels {
            Some(list) => list[numbers.start as usize..numbers.end as usize].to_vec(),
            None => self.order.pixels(numbers).collect(),
        }
    }

    /// Values that a pixel has: three of light and those of the layers.
    pub(crate) fn channels(&self) -> usize {
        3 + self.layers.channels()
    }

    /// The sums of some pixels, [`Film::channels`] of each.
    pub(crate) fn copy_pixels(&self, pixels: &[u32]) -> Vec<f32> {
        let mut values = Vec::with_capacity(pixels.len() * self.channels());
        for &pixel in pixels {
            values.extend_from_slice(self.sums[pixel as usize].as_ref());
            self.layers.copy_to(pixel, &mut values);
        }
        values
    }

    /// Takes sums of some pixels as [`Film::copy_pixels`] gave them.
    pub(crate) fn put_pixels(&mut self, pixels: &[u32], values: &[f32]) {
        for (&pixel, values) in pixels.iter().zip(values.chunks_exact(self.channels())) {
            self.sums[pixel as usize] = glam::Vec3::from_slice(values);
            self.layers.copy_from(pixel, &values[3..]);
        }
    }

    /// Counts the whole pass as done.
    pub(crate) fn end_pass(&mut self) {
        self.pass.end = None;
        self.pass.done = self.sample_count();
    }

    /// What samples of some pixels saw; empty where nobody asks.
    pub(crate) fn copy_seen(&self, pixels: &[u32]) -> Vec<u8> {
        if self.emitter_seen.is_empty() {
            Vec::new()
        } else {
            pixels.iter().map(|&pixel| self.emitter_seen[pixel as usize]).collect()
        }
    }

    /// Takes what samples saw of all pixels, row by row; which of them are lamps' outlines follows from it.
    pub(crate) fn put_seen(&mut self, seen: &[u8]) {
        self.emitter_seen = seen.to_vec();
    }
}
