//! The film: which samples belong to which pixel, and their sum.

use std::ops::Range;

use glam::{Vec2, Vec3};

use crate::geometry::Ray;
use crate::integrator::{film_samples, hash};
use crate::scene::FilmRays;
use crate::{Camera, Image, RenderOptions};

/// Edge of the square tiles, in pixels, in whose order samples are taken: their rays hit neighbouring surfaces.
const TILE: u32 = 32;

/// Accumulates radiance with a box filter of one pixel.
#[derive(Debug)]
pub(crate) struct Film {
    rays: FilmRays,
    width: u32,
    height: u32,
    seed: u64,
    /// Where in [0, 1)² a pixel's samples lie, in units of 2⁻³², before the pixel's own scramble.
    offsets: Vec<[u32; 2]>,
    pixels: Vec<Vec3>,
}

/// One sample of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sample {
    /// Index of the pixel, row by row.
    pub pixel: u32,
    /// Which of its samples.
    pub index: u32,
    x: u32,
    y: u32,
}

impl Film {
    pub(crate) fn new(camera: &Camera, options: &RenderOptions) -> Self {
        let (width, height) = (options.width, options.height);
        Self {
            rays: camera.film(width, height),
            width,
            height,
            seed: options.seed,
            offsets: film_samples(options.spp),
            pixels: vec![Vec3::ZERO; width as usize * height as usize],
        }
    }

    /// Samples of the whole picture.
    pub(crate) fn sample_count(&self) -> u64 {
        self.pixels.len() as u64 * self.offsets.len() as u64
    }

    /// The samples of a range of numbers below [`Film::sample_count`]: pixel by pixel within a tile, tile by tile.
    pub(crate) fn samples(&self, range: Range<u64>) -> impl Iterator<Item = Sample> {
        let spp = self.offsets.len() as u64;
        let (mut x, mut y) = self.place(range.start / spp);
        let mut index = (range.start % spp) as u32;
        range.map(move |_| {
            let sample = Sample { pixel: y * self.width + x, index, x, y };
            index += 1;
            if u64::from(index) == spp {
                index = 0;
                (x, y) = self.next_place(x, y);
            }
            sample
        })
    }

    /// Pixel coordinates of the n-th pixel in tile order.
    fn place(&self, n: u64) -> (u32, u32) {
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
    fn next_place(&self, x: u32, y: u32) -> (u32, u32) {
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

    /// The camera ray of a sample. A single sample goes through the pixel's centre; more are the points of one Sobol set,
    /// whose digits are scrambled by the pixel's own bits (Kollig and Keller, "Efficient Multidimensional Sampling", 2002):
    /// strata stay strata.
    pub(crate) fn ray(&self, sample: Sample) -> Ray {
        let mut offset = Vec2::splat(0.5);
        if self.offsets.len() > 1 {
            let bits = hash(hash(self.seed as u32 ^ hash((self.seed >> 32) as u32)) ^ sample.pixel);
            let [x, y] = self.offsets[sample.index as usize];
            // 24 bits: what f32 holds below 1.
            let unit = |digits: u32| (digits >> 8) as f32 * (1.0 / (1 << 24) as f32);
            offset = Vec2::new(unit(x ^ bits), unit(y ^ hash(bits)));
        }
        self.rays.ray(sample.x as f32 + offset.x, sample.y as f32 + offset.y)
    }

    /// Adds one sample's radiance, or a part of it.
    pub(crate) fn add(&mut self, pixel: u32, radiance: Vec3) {
        self.pixels[pixel as usize] += radiance;
    }

    /// The mean over each pixel's samples.
    pub(crate) fn into_image(self) -> Image {
        let scale = 1.0 / self.offsets.len() as f32;
        let pixels = self.pixels.into_iter().map(|p| p * scale).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(width: u32, height: u32, spp: u32) -> Film {
        let options = RenderOptions { width, height, spp, ..RenderOptions::default() };
        Film::new(&Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0), &options)
    }

    /// Every sample of every pixel once, and a range that starts anywhere goes on as the whole one does.
    #[test]
    fn tiles_cover_the_film_once() {
        for (width, height, spp) in [(70, 45, 3), (32, 64, 1), (5, 3, 2), (33, 1, 1)] {
            let film = film(width, height, spp);
            let n = film.sample_count();
            let all: Vec<Sample> = film.samples(0..n).collect();
            let mut sorted: Vec<(u32, u32)> = all.iter().map(|s| (s.pixel, s.index)).collect();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len() as u64, n);
            for start in [1, n / 3, n / 2, n - 1] {
                assert!(
                    film.samples(start..n).eq(all[start as usize..].iter().copied()),
                    "{width}x{height} from {start}"
                );
            }
        }
    }

    /// Sixteen samples fill the 4 × 4 strata of their pixel, one each.
    #[test]
    fn samples_are_stratified() {
        let film = film(40, 40, 16);
        for pixel in [0, 777] {
            let mut strata: Vec<(u32, u32)> = film
                .samples(pixel * 16..pixel * 16 + 16)
                .map(|s| {
                    let p = film.rays.position(&film.ray(s)) - Vec2::new(s.x as f32, s.y as f32);
                    ((p.x * 4.0) as u32, (p.y * 4.0) as u32)
                })
                .collect();
            strata.sort_unstable();
            strata.dedup();
            assert_eq!(strata.len(), 16);
        }
    }

    #[test]
    fn one_sample_is_the_centre_and_more_stay_in_their_pixel() {
        let centre = film(9, 7, 1);
        let sample = centre.samples(0..1).next().expect("a sample");
        assert_eq!(centre.ray(sample), centre.rays.ray(0.5, 0.5));
        let film = film(1, 1, 64);
        let mean: Vec3 = film.samples(0..64).map(|s| film.ray(s).direction).sum::<Vec3>() / 64.0;
        assert!((mean.x.abs() < 0.01) && (mean.y.abs() < 0.01), "{mean}");
    }
}
