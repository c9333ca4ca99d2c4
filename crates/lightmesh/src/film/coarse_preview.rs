//! A coarse preview of a picture: the first sample of every few pixels, shown as blocks.

use glam::Vec3;

use super::order::TileOrder;

/// The picture in blocks of `stride` × `stride` pixels, each as its upper left pixel was sampled.
#[derive(Debug)]
pub(super) struct CoarsePreview {
    stride: u32,
    /// Blocks per row.
    columns: u32,
    blocks: Vec<Vec3>,
}

impl CoarsePreview {
    /// Returns the pixels that a preview of this stride samples. Those that a coarser one has, whose stride is a
    /// multiple, are not sampled again.
    pub(super) fn pixels(order: TileOrder, stride: u32, coarser: Option<&Self>) -> Vec<u32> {
        let grid = (0..order.height).step_by(stride as usize).flat_map(|y| {
            let row = (0..order.width).step_by(stride as usize);
            row.map(move |x| (x, y))
        });
        grid.filter(|&(x, y)| !coarser.is_some_and(|c| c.samples(x, y))).map(|(x, y)| y * order.width + x).collect()
    }

    /// Makes the preview of the sums of its pixels, which it clears, and of the coarser one.
    pub(crate) fn take(order: TileOrder, stride: u32, coarser: Option<&Self>, sums: &mut [Vec3]) -> Self {
        let mut blocks = Vec::new();
        for y in (0..order.height).step_by(stride as usize) {
            for x in (0..order.width).step_by(stride as usize) {
                blocks.push(match coarser {
                    Some(coarser) if coarser.samples(x, y) => coarser.color_at(x, y),
                    _ => std::mem::take(&mut sums[(y * order.width + x) as usize]),
                });
            }
        }
        Self { stride, columns: order.width.div_ceil(stride), blocks }
    }

    /// The colour that it shows at a pixel.
    pub(super) fn color_at(&self, x: u32, y: u32) -> Vec3 {
        self.blocks[(y / self.stride * self.columns + x / self.stride) as usize]
    }

    /// Whether it has a sample of this pixel.
    fn samples(&self, x: u32, y: u32) -> bool {
        x.is_multiple_of(self.stride) && y.is_multiple_of(self.stride)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two previews sample each pixel of the finer grid once; the finer one shows them all and leaves the sums empty.
    #[test]
    fn a_finer_preview_goes_on_from_a_coarser_one() {
        let order = TileOrder { width: 21, height: 10 };
        let mut sums = vec![Vec3::ZERO; order.len()];
        let mut taken = Vec::new();
        let mut preview = None;
        for stride in [8, 4] {
            let pixels = CoarsePreview::pixels(order, stride, preview.as_ref());
            pixels.iter().for_each(|&p| sums[p as usize] = Vec3::splat(1.0 + p as f32));
            taken.extend(pixels);
            preview = Some(CoarsePreview::take(order, stride, preview.as_ref(), &mut sums));
        }
        let preview = preview.expect("a preview");
        taken.sort_unstable();
        let grid = (0..10).step_by(4).flat_map(|y| (0..21).step_by(4).map(move |x| y * 21 + x));
        assert!(taken.into_iter().eq(grid));
        assert!(sums.iter().all(|&sum| sum == Vec3::ZERO));
        assert_eq!(preview.color_at(20, 9), Vec3::splat(1.0 + (8 * 21 + 20) as f32));
        assert_eq!(preview.color_at(3, 7), Vec3::splat(1.0 + (4 * 21) as f32));
    }
}
