//! The film's sums as a picture: so far, and at the end.

use glam::Vec3;

use super::Film;
use super::emitter_edges::EmitterEdges;
use crate::{DisplayData, Image, Layer};

impl Film {
    /// Returns the picture so far: the mean over the samples that each pixel has; where it has none, the coarse
    /// preview; where there is none either, black. `None` while a coarse preview is being made.
    pub(crate) fn picture(&self) -> Option<Image> {
        let mut scales = vec![0.0; self.sums.len()];
        let pixels = match (&self.pass.pixels, &self.emitter_edges) {
            (Some(list), Some(edges)) => {
                scales.fill(1.0 / edges.spp as f32);
                let [(done, samples), ..] = self.pass.counts(list.len() as u64);
                list[..done.end as usize].iter().for_each(|&pixel| scales[pixel as usize] = 1.0 / samples as f32);
                self.with_emitter_edges(list, edges)
            }
            (Some(_), None) => return None,
            (None, _) => {
                let mut pixels = vec![Vec3::ZERO; self.sums.len()];
                for (numbers, samples) in self.pass.counts(self.sums.len() as u64) {
                    for pixel in self.order.pixels(numbers) {
                        scales[pixel as usize] = if samples > 0 { 1.0 / samples as f32 } else { 0.0 };
                        pixels[pixel as usize] = match samples {
                            0 => self.preview_at(pixel),
                            samples => self.sums[pixel as usize] * (1.0 / samples as f32),
                        };
                    }
                }
                pixels
            }
        };
        let unlit = self.unlit.so_far(|pixel| scales[pixel as usize]);
        let display = DisplayData { unlit, white_cd_m2: self.white_cd_m2 };
        Some(Image { width: self.order.width, height: self.order.height, pixels, display })
    }

    /// Returns the finished pixels; those on emitter edges as they were before, unless they have been sampled anew.
    fn with_emitter_edges(&self, list: &[u32], edges: &EmitterEdges) -> Vec<Vec3> {
        let scale = 1.0 / edges.spp as f32;
        let mut pixels: Vec<Vec3> = self.sums.iter().map(|&sum| sum * scale).collect();
        let [(done, samples), ..] = self.pass.counts(list.len() as u64);
        let (anew, as_before) = list.split_at(done.end as usize);
        for &pixel in anew {
            pixels[pixel as usize] = self.sums[pixel as usize] * (1.0 / samples as f32);
        }
        for (&pixel, &before) in as_before.iter().zip(&edges.before[anew.len()..]) {
            pixels[pixel as usize] = before * scale;
        }
        pixels
    }

    fn preview_at(&self, pixel: u32) -> Vec3 {
        self.coarse_preview
            .as_ref()
            .map_or(Vec3::ZERO, |s| s.color_at(pixel % self.order.width, pixel / self.order.width))
    }

    /// Returns the mean over each pixel's samples, and the layers.
    pub(crate) fn into_image(self) -> (Image, Vec<Layer>) {
        let Self { order, pass, emitter_edges, sums: mut pixels, mut layers, mut unlit, white_cd_m2, .. } = self;
        let all = pixels.len() as u64;
        if let (Some(list), Some(edges)) = (&pass.pixels, &emitter_edges) {
            // All pixels are divided by `spp` below: scale those that have another number of samples.
            let factor = edges.spp as f32 / pass.indices.end as f32;
            list.iter().for_each(|&pixel| pixels[pixel as usize] *= factor);
            layers.scale(list.iter().copied(), factor);
            unlit.scale(list.iter().copied(), factor);
        }
        let whole = emitter_edges.map(|edges| edges.spp).or((pass.left(all) == 0).then_some(pass.indices.end));
        match whole {
            Some(samples) => {
                let scale = 1.0 / samples as f32;
                pixels.iter_mut().for_each(|pixel| *pixel *= scale);
                layers.scale(0..all as u32, scale);
                unlit.scale(0..all as u32, scale);
            }
            // The time was up in the middle of a pass: some pixels have more samples than others.
            None => {
                for (numbers, samples) in pass.counts(all) {
                    let scale = 1.0 / samples as f32;
                    order.pixels(numbers.clone()).for_each(|pixel| pixels[pixel as usize] *= scale);
                    layers.scale(order.pixels(numbers.clone()), scale);
                    unlit.scale(order.pixels(numbers), scale);
                }
            }
        }
        let display = DisplayData { unlit: unlit.finish(), white_cd_m2 };
        (Image { width: order.width, height: order.height, pixels, display }, layers.finish())
    }
}
