//! The film's sums as a picture: so far, and at the end.

use glam::Vec3;

use super::Film;
use crate::{DisplayData, Image, Layer};

impl Film {
    /// Returns the picture so far: the mean over the samples that each pixel has; where it has none, what it had before it is
    /// sampled anew, or the coarse preview; where there is none either, black. `None` while a coarse preview is being
    /// made.
    pub(crate) fn picture(&self) -> Option<Image> {
        if self.is_hidden {
            return None;
        }
        let mut pixels: Vec<Vec3> = (0..).zip(&self.taken).map(|(pixel, &taken)| self.so_far(pixel, taken)).collect();
        if let (Some(edges), Some(list)) = (&self.emitter_edges, &self.pass.pixels) {
            for (&pixel, &before) in list.iter().zip(&edges.before) {
                if self.taken[pixel as usize] == 0 {
                    pixels[pixel as usize] = before;
                }
            }
        }
        let unlit = self.unlit.means(|pixel| mean_of(self.taken[pixel as usize]));
        let display = DisplayData { unlit, white_cd_m2: self.white_cd_m2 };
        Some(Image { width: self.order.width, height: self.order.height, pixels, display })
    }

    fn so_far(&self, pixel: u32, taken: u32) -> Vec3 {
        match (taken, &self.coarse_preview) {
            (0, Some(preview)) => preview.color_at(pixel % self.order.width, pixel / self.order.width),
            _ => self.sums[pixel as usize] * mean_of(taken),
        }
    }

    /// Returns the mean over each pixel's samples, and the layers.
    pub(crate) fn into_image(self) -> (Image, Vec<Layer>) {
        let Self { order, taken, sums: mut pixels, layers, unlit, white_cd_m2, .. } = self;
        let scale = |pixel: u32| mean_of(taken[pixel as usize]);
        (0..).zip(&mut pixels).for_each(|(pixel, sum)| *sum *= scale(pixel));
        let display = DisplayData { unlit: unlit.means(scale), white_cd_m2 };
        (Image { width: order.width, height: order.height, pixels, display }, layers.finish(scale))
    }
}

/// What the sum over so many samples is multiplied with to be their mean.
fn mean_of(taken: u32) -> f32 {
    1.0 / taken.max(1) as f32
}
