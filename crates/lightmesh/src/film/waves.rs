//! Some waves of a pass: their light, copied from one film to another.

use std::ops::Range;

use super::Film;

impl Film {
    /// How many waves the pass has.
    pub(crate) fn wave_count(&self) -> u64 {
        self.sample_count().div_ceil(self.samples_per_wave())
    }

    /// Restricts the pass to some of its waves.
    pub(crate) fn begin_waves(&mut self, waves: Range<u64>) {
        let (wave, all) = (self.samples_per_wave(), self.sample_count());
        self.pass.done = (waves.start * wave).min(all);
        self.pass.end = Some((waves.end * wave).min(all));
    }

    /// The pixels of some waves of the pass, in the order in which they are sampled.
    pub(crate) fn wave_pixels(&self, waves: Range<u64>) -> Vec<u32> {
        let wave = self.samples_per_wave() / self.pass.samples_per_pixel();
        let all = self.pass_pixels();
        let numbers = (waves.start * wave).min(all)..(waves.end * wave).min(all);
        match &self.pass.pixels {
            Some(list) => list[numbers.start as usize..numbers.end as usize].to_vec(),
            None => self.order.pixels(numbers).collect(),
        }
    }

    /// How many values a pixel has: three of light and those of the layers and of unlit surfaces.
    pub(crate) fn channels(&self) -> usize {
        3 + self.layers.channels() + self.unlit.channels()
    }

    /// Returns the sums of some pixels, [`Film::channels`] of each.
    pub(crate) fn copy_pixels(&self, pixels: &[u32]) -> Vec<f32> {
        let mut values = Vec::with_capacity(pixels.len() * self.channels());
        for &pixel in pixels {
            values.extend_from_slice(self.sums[pixel as usize].as_ref());
            self.layers.copy_to(pixel, &mut values);
            self.unlit.copy_to(pixel, &mut values);
        }
        values
    }

    /// Sets the sums of some pixels to those that [`Film::copy_pixels`] gave.
    pub(crate) fn set_pixels(&mut self, pixels: &[u32], values: &[f32]) {
        for (&pixel, values) in pixels.iter().zip(values.chunks_exact(self.channels())) {
            self.sums[pixel as usize] = glam::Vec3::from_slice(values);
            let (layers, unlit) = values[3..].split_at(self.layers.channels());
            self.layers.copy_from(pixel, layers);
            self.unlit.copy_from(pixel, unlit);
        }
    }

    /// Marks the whole pass as done.
    pub(crate) fn end_pass(&mut self) {
        self.pass.end = None;
        self.add_done(self.sample_count() - self.pass.done);
    }

    /// Whether samples of some pixels met emitters; empty where the film does not collect that.
    pub(crate) fn copy_seen(&self, pixels: &[u32]) -> Vec<u8> {
        if self.seen.is_empty() { Vec::new() } else { pixels.iter().map(|&pixel| self.seen[pixel as usize]).collect() }
    }

    /// Takes whether samples of all pixels met emitters, row by row; from that follow the pixels on edges of emitters.
    pub(crate) fn set_seen(&mut self, seen: &[u8]) {
        self.seen = seen.to_vec();
    }
}
