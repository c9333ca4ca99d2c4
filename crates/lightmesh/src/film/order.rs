//! In which order the pixels of a picture are sampled: square tiles, so that neighbouring rays hit neighbouring
//! surfaces.

use std::ops::Range;

/// Edge of the tiles, in pixels.
const TILE: u32 = 32;

/// The pixels of a picture, tile by tile, row by row within a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileOrder {
    pub(super) width: u32,
    pub(super) height: u32,
}

impl TileOrder {
    /// How many pixels there are.
    pub(crate) fn len(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The indices, row by row in the picture, of the pixels with these numbers in tile order.
    pub(super) fn pixels(self, numbers: Range<u64>) -> impl Iterator<Item = u32> + Clone {
        let (mut x, mut y) = if numbers.is_empty() { (0, 0) } else { self.coordinates(numbers.start) };
        numbers.map(move |_| {
            let pixel = y * self.width + x;
            (x, y) = self.next(x, y);
            pixel
        })
    }

    /// Pixel coordinates of the n-th pixel in tile order.
    pub(crate) fn coordinates(self, n: u64) -> (u32, u32) {
        let band = u64::from(self.width) * u64::from(TILE);
        let top = (n / band) as u32 * TILE;
        let rows = TILE.min(self.height - top);
        let (n, tile) = ((n % band) as u32, TILE * rows);
        let left = n / tile * TILE;
        let columns = TILE.min(self.width - left);
        let n = n % tile;
        (left + n % columns, top + n / columns)
    }

    /// The pixel after (x, y) in tile order.
    pub(super) fn next(self, x: u32, y: u32) -> (u32, u32) {
        let (left, top) = (x & !(TILE - 1), y & !(TILE - 1));
        let (right, bottom) = ((left + TILE).min(self.width), (top + TILE).min(self.height));
        if x + 1 < right {
            (x + 1, y)
        } else if y + 1 < bottom {
            (left, y + 1)
        } else if right < self.width {
            (right, top)
        } else {
            (0, bottom)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pixel once, and an order that starts anywhere goes on as the whole one does.
    #[test]
    fn every_pixel_comes_once() {
        for (width, height) in [(70, 45), (32, 64), (5, 3), (33, 1), (64, 1)] {
            let order = TileOrder { width, height };
            let n = order.len() as u64;
            let all: Vec<u32> = order.pixels(0..n).collect();
            for start in [1, n / 3, n / 2, n - 1, n] {
                assert!(order.pixels(start..n).eq(all[start as usize..].iter().copied()), "{width}x{height} {start}");
            }
            let mut sorted = all;
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..n as u32), "{width}x{height}");
        }
    }
}
