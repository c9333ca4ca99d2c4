//! The film: which samples belong to which pixel, and their sum.

use std::ops::Range;

use glam::{Vec2, Vec3};

use crate::aov::Layers;
use crate::geometry::Ray;
use crate::integrator::{film_samples, hash};
use crate::scene::FilmRays;
use crate::{Camera, Image, Layer, RenderOptions};

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
    layers: Layers,
    /// What samples saw of each pixel: [`SAW_LAMP`], [`SAW_OTHER`]. Empty where nobody asks.
    seen: Vec<u8>,
    /// The pixels that are sampled anew, ascending, and how many samples each of the others has.
    outlines: Option<(Vec<u32>, usize)>,
}

/// Bits of what samples saw: something that shines, something else.
const SAW_LAMP: u8 = 1;
const SAW_OTHER: u8 = 2;

/// Samples of a pixel on the outline of a lamp. Lamps are tens to thousands of times as bright as what is beside them: four samples
/// leave steps that no tone map hides. Measured on the Cornell box with its lamp in view, four samples elsewhere: error of
/// the lamp's rows 6.3% of the picture's mean (clamped at 8 times it), with these 1.0%.
const OUTLINE_SAMPLES: u32 = 64;

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
            layers: Layers::new(options.aovs, width as usize * height as usize),
            seen: Vec::new(),
            outlines: None,
        }
    }

    /// Samples of the whole picture, or of the pixels that are sampled anew.
    pub(crate) fn sample_count(&self) -> u64 {
        let pixels = self.outlines.as_ref().map_or(self.pixels.len(), |(pixels, _)| pixels.len());
        pixels as u64 * self.offsets.len() as u64
    }

    /// Begins to remember which pixels see lamps.
    pub(crate) fn watch_lamps(&mut self) {
        self.seen = vec![0; self.pixels.len()];
    }

    /// Remembers whether a sample saw something that shines.
    pub(crate) fn saw(&mut self, pixel: u32, lamp: bool) {
        if let Some(seen) = self.seen.get_mut(pixel as usize) {
            *seen |= if lamp { SAW_LAMP } else { SAW_OTHER };
        }
    }

    /// Turns to the pixels on the outlines of lamps: those that have both a lamp and something else within a pixel. They are
    /// cleared; the film's samples are now theirs, 64 each, or fewer where that were more than the whole picture had. False
    /// if there is nothing to do: no outline, or samples enough, or one at each pixel's centre.
    pub(crate) fn turn_to_outlines(&mut self) -> bool {
        let spp = self.offsets.len();
        if spp < 2 || self.seen.is_empty() {
            return false;
        }
        let (width, height) = (self.width as usize, self.height as usize);
        let is_outline = |&pixel: &u32| {
            let (x, y) = (pixel as usize % width, pixel as usize / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let seen = rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).map(|i| self.seen[i]);
            seen.fold(0, |all, seen| all | seen) == SAW_LAMP | SAW_OTHER
        };
        let outlines: Vec<u32> = (0..self.pixels.len() as u32).filter(is_outline).collect();
        let most = (self.pixels.len() * spp).checked_div(outlines.len()).unwrap_or(0);
        let samples = OUTLINE_SAMPLES.min(most.min(1 << 16) as u32);
        if samples as usize <= spp {
            return false;
        }
        for &pixel in &outlines {
            self.pixels[pixel as usize] = Vec3::ZERO;
        }
        self.layers.clear(&outlines);
        self.offsets = film_samples(samples);
        self.outlines = Some((outlines, spp));
        self.seen = Vec::new();
        true
    }

    /// The samples of a range of numbers below [`Film::sample_count`]: pixel by pixel within a tile, tile by tile, or along the
    /// outlines.
    pub(crate) fn samples(&self, range: Range<u64>) -> impl Iterator<Item = Sample> {
        let spp = self.offsets.len() as u64;
        let outlines = self.outlines.as_ref().map(|(pixels, _)| pixels.as_slice());
        let (mut x, mut y) = if outlines.is_some() { (0, 0) } else { self.place(range.start / spp) };
        let mut index = (range.start % spp) as u32;
        range.map(move |n| {
            if let Some(pixels) = outlines {
                let pixel = pixels[(n / spp) as usize];
                return Sample { pixel, index: (n % spp) as u32, x: pixel % self.width, y: pixel / self.width };
            }
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

    /// Adds a surface that a sample met first and that covers the part `weight` of it.
    pub(crate) fn add_surface(&mut self, pixel: u32, weight: f32, albedo: Vec3, normal: Vec3, position: Vec3) {
        self.layers.add_surface(pixel, weight, albedo, normal, self.rays.depth(position));
    }

    /// The layers beside the light.
    pub(crate) fn layers(&mut self) -> &mut Layers {
        &mut self.layers
    }

    /// Whether any of them is collected.
    pub(crate) fn has_layers(&self) -> bool {
        self.layers.any()
    }

    /// The camera's rays and the picture's width and height.
    pub(crate) fn frame(&self) -> (FilmRays, u32, u32) {
        (self.rays, self.width, self.height)
    }

    /// The mean over each pixel's samples, and the layers.
    pub(crate) fn into_image(self) -> (Image, Vec<Layer>) {
        let (outlines, spp) = self.outlines.unwrap_or((Vec::new(), self.offsets.len()));
        let (mut pixels, mut layers) = (self.pixels, self.layers);
        let outline_scale = spp as f32 / self.offsets.len() as f32;
        for &pixel in &outlines {
            // The others are divided by `spp` below.
            pixels[pixel as usize] *= outline_scale;
        }
        let scale = 1.0 / spp as f32;
        pixels.iter_mut().for_each(|p| *p *= scale);
        layers.scale(outlines.into_iter(), outline_scale);
        layers.scale(0..pixels.len() as u32, scale);
        (Image { width: self.width, height: self.height, pixels }, layers.finish())
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
