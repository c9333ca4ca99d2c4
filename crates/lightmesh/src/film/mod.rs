//! The film: which samples belong to which pixel, and their sum.

mod clock;
mod coarse_preview;
mod display;
mod emitter_edges;
mod finite;
mod layers;
mod order;
mod pass;
mod passes;
mod picture;
mod resampling;
mod sample_noise;
mod waves;

use std::ops::Range;

pub(crate) use clock::RenderClock;
use coarse_preview::CoarsePreview;
pub(crate) use display::UnlitSample;
use display::UnlitSums;
use emitter_edges::EmitterEdges;
pub(crate) use finite::{blacken_non_finite, cut_noise_below_black};
use glam::{Vec2, Vec3};
pub(crate) use layers::Layers;
use order::TileOrder;
use pass::Pass;
pub(crate) use passes::{NoiseBound, SumOrder, WAVE, take_more_samples, take_samples};
pub(crate) use sample_noise::BRIGHTEST;
use sample_noise::SampleNoise;

use crate::geometry::{Cone, Ray};
use crate::sampling::{film_samples, fold_seed, hash};
use crate::scene::FilmRays;
use crate::{Aovs, Camera, PictureOptions, RenderOptions, Scene};

/// Accumulates radiance with a box filter of one pixel.
#[derive(Debug)]
pub(crate) struct Film {
    rays: FilmRays,
    order: TileOrder,
    seed: u64,
    /// Samples that every pixel is to have at least.
    spp: u32,
    /// Positions of a pixel's samples in [0, 1)², in units of 2⁻³², before the pixel's own scramble.
    offsets: Vec<[u32; 2]>,
    /// Cells of a pixel in each direction, and how wide the square of a cell's area is, in pixels.
    cells: (Vec2, f32),
    /// Whether rays have cones.
    cones: bool,
    /// The samples that are being taken.
    pass: Pass,
    /// By pixel: the sum of its samples' radiance.
    sums: Vec<Vec3>,
    /// By pixel: how many samples have all their light in the sum.
    taken: Vec<u32>,
    aovs: Aovs,
    layers: Layers,
    /// Whether the scene has unlit surfaces.
    has_unlit: bool,
    unlit: UnlitSums,
    /// See [`DisplayData::white_cd_m2`](crate::DisplayData::white_cd_m2).
    white_cd_m2: Option<f32>,
    /// Whether the samples of each pixel saw an emitter, and something else; empty where emitter edges are not
    /// supersampled.
    seen: Vec<u8>,
    /// What is shown of pixels without samples.
    coarse_preview: Option<CoarsePreview>,
    /// Whether its sums are no picture to be shown: a coarse preview that is being made, or some pixels alone.
    is_hidden: bool,
    /// The first samples of the pass's pixels, where these are sampled anew.
    emitter_edges: Option<EmitterEdges>,
    /// How much noise each pixel has, where that decides which get more samples.
    noise: SampleNoise,
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
    /// An empty film on which all samples of all pixels are one pass.
    pub(crate) fn new(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Self {
        let PictureOptions { width, height, .. } = options.picture;
        let mut film = Self::of_rays(camera.film_in(scene.data().origin, &scene.bounds(), width, height), options);
        film.has_unlit = scene.has_unlit();
        film.unlit = film.no_unlit();
        film
    }

    /// [`Film::new`] with the camera's rays.
    fn of_rays(rays: FilmRays, options: &RenderOptions) -> Self {
        let order = TileOrder { width: options.picture.width, height: options.picture.height };
        Self {
            rays,
            order,
            seed: options.seed,
            spp: options.picture.spp,
            offsets: film_samples(options.picture.spp),
            cells: cells_of_pixel(options.picture.spp as usize),
            cones: true,
            pass: Pass::new(None, 0..options.picture.spp),
            sums: vec![Vec3::ZERO; order.len()],
            taken: vec![0; order.len()],
            aovs: options.picture.aovs,
            layers: Layers::new(options.picture.aovs, order.len()),
            has_unlit: false,
            unlit: UnlitSums::default(),
            white_cd_m2: None,
            seen: Vec::new(),
            coarse_preview: None,
            is_hidden: false,
            emitter_edges: None,
            noise: SampleNoise::default(),
        }
    }

    /// Gives rays no cones: no texture is averaged over a footprint.
    pub(crate) fn drop_cones(&mut self) {
        self.cones = false;
    }

    /// Says how bright a white surface is in the light about the camera, cd/m².
    pub(crate) fn set_white(&mut self, white_cd_m2: Option<f32>) {
        self.white_cd_m2 = white_cd_m2;
    }

    /// Begins a pass over some of the samples of every pixel, which follow those that it has.
    pub(crate) fn begin_pass(&mut self, indices: Range<u32>) {
        self.pass = Pass::new(None, indices);
    }

    /// Begins a coarse preview: the first sample of every `stride`-th pixel of every `stride`-th row. Previews come
    /// before any pass, the coarsest first. Layers are not collected.
    pub(crate) fn begin_coarse_preview(&mut self, stride: u32) {
        let pixels = CoarsePreview::pixels(self.order, stride, self.coarse_preview.as_ref());
        self.pass = Pass::new(Some(pixels), 0..1);
        self.is_hidden = true;
        self.layers = Layers::default();
        self.unlit = UnlitSums::default();
    }

    /// Keeps the coarse preview, to be shown where pixels have no samples, and empties the film.
    pub(crate) fn finish_coarse_preview(&mut self, stride: u32) {
        self.coarse_preview =
            Some(CoarsePreview::take(self.order, stride, self.coarse_preview.as_ref(), &mut self.sums));
        self.is_hidden = false;
        self.taken.fill(0);
        self.layers = Layers::new(self.aovs, self.order.len());
        self.unlit = self.no_unlit();
        self.begin_pass(0..self.offsets.len() as u32);
    }

    /// Sets how many samples the pixels of the next passes have in all.
    fn set_samples(&mut self, samples: u32) {
        self.offsets = film_samples(samples);
        self.cells = cells_of_pixel(samples as usize);
    }

    /// An empty film on which the first `spp` samples of some pixels are one pass; without layers.
    pub(crate) fn of_pixels(&self, pixels: Vec<u32>, spp: u32) -> Self {
        Self {
            rays: self.rays,
            order: self.order,
            seed: self.seed,
            spp,
            offsets: self.offsets.clone(),
            cells: self.cells,
            cones: self.cones,
            pass: Pass::new(Some(pixels), 0..spp),
            sums: vec![Vec3::ZERO; self.sums.len()],
            taken: vec![0; self.sums.len()],
            aovs: Aovs::default(),
            layers: Layers::default(),
            has_unlit: self.has_unlit,
            unlit: UnlitSums::default(),
            white_cd_m2: None,
            seen: Vec::new(),
            coarse_preview: None,
            is_hidden: true,
            emitter_edges: None,
            noise: SampleNoise::default(),
        }
    }

    /// Empty sums of unlit colours.
    fn no_unlit(&self) -> UnlitSums {
        UnlitSums::new(if self.has_unlit { self.order.len() } else { 0 })
    }

    /// The sums of some pixels.
    pub(crate) fn sums_of(&self, pixels: &[u32]) -> Vec<Vec3> {
        pixels.iter().map(|&pixel| self.sums[pixel as usize]).collect()
    }

    /// Returns random pixels, one in each of `count` equal parts of the picture, in the order in which they are
    /// sampled. Other numbers of a `set` give other pixels.
    pub(crate) fn draw(&self, seed: u64, set: u32, count: u64) -> Vec<u32> {
        let all = self.pixel_count();
        let count = count.min(all);
        let seed = hash(fold_seed(seed) ^ hash(set.wrapping_add(0x51ed)));
        let pixel = |i: u64| {
            let (from, to) = (i * all / count, (i + 1) * all / count);
            let (x, y) = self.order.coordinates(from + u64::from(hash(seed ^ hash(i as u32))) % (to - from));
            y * self.order.width + x
        };
        (0..count).map(pixel).collect()
    }

    /// Samples of the pass, up to its end.
    pub(crate) fn sample_count(&self) -> u64 {
        self.pass.end.unwrap_or(self.pass_pixels() * self.pass.samples_per_pixel())
    }

    /// Samples of a wave: all that the pass has of as many pixels as fit in.
    pub(crate) fn samples_per_wave(&self) -> u64 {
        WAVE - WAVE % self.pass.samples_per_pixel().clamp(1, WAVE)
    }

    /// Pixels of the picture.
    pub(crate) fn pixel_count(&self) -> u64 {
        self.sums.len() as u64
    }

    /// How many samples of the pass have all their light on the film.
    pub(crate) fn done(&self) -> u64 {
        self.pass.done
    }

    /// Counts samples as done, in order.
    pub(crate) fn add_done(&mut self, samples: u64) {
        let mut taken = std::mem::take(&mut self.taken);
        let range = self.pass.done..self.pass.done + samples;
        self.samples(range).for_each(|sample| taken[sample.pixel as usize] += 1);
        self.taken = taken;
        self.pass.done += samples;
    }

    /// How many samples every pixel has.
    pub(crate) fn whole_passes(&self) -> u32 {
        self.taken.iter().copied().min().unwrap_or(0)
    }

    /// Whether the time limit may end the picture here: every pixel has a sample, and none is being sampled anew.
    pub(crate) fn may_end(&self) -> bool {
        self.pass.pixels.is_none() && self.pass.indices.start > 0
    }

    /// How many samples the pixels of the pass are to have in all.
    pub(crate) fn samples_of_pixel(&self) -> u32 {
        self.offsets.len() as u32
    }

    fn pass_pixels(&self) -> u64 {
        self.pass.pixels.as_ref().map_or(self.sums.len(), Vec::len) as u64
    }

    /// The samples of a range of numbers below [`Film::sample_count`]: pixel by pixel within a tile, tile by tile, or
    /// along the pass's list.
    pub(crate) fn samples(&self, range: Range<u64>) -> impl Iterator<Item = Sample> {
        let spp = self.pass.samples_per_pixel();
        let first = self.pass.indices.start;
        let list = self.pass.pixels.as_deref();
        let (mut x, mut y) = if list.is_some() { (0, 0) } else { self.order.coordinates(range.start / spp) };
        let mut index = (range.start % spp) as u32;
        range.map(move |n| {
            if let Some(pixels) = list {
                let (pixel, width) = (pixels[(n / spp) as usize], self.order.width);
                return Sample { pixel, index: first + (n % spp) as u32, x: pixel % width, y: pixel / width };
            }
            let sample = Sample { pixel: y * self.order.width + x, index: first + index, x, y };
            index += 1;
            if u64::from(index) == spp {
                index = 0;
                (x, y) = self.order.next(x, y);
            }
            sample
        })
    }

    /// The camera ray of a sample, and the cone about the cell of the pixel that it stands for. A single sample goes
    /// through the pixel's centre; more are the points of one Sobol set, whose digits are scrambled by the pixel's own
    /// bits (Kollig and Keller, "Efficient Multidimensional Sampling", 2002): strata stay strata. Of as many digits as
    /// there are strata along an axis; a point is in the middle of its own, which halves the squared error of an edge
    /// that runs along an axis: ∫ f(1 − f) df = 1/6 becomes ∫ min(f, 1 − f)² df = 1/12.
    pub(crate) fn ray(&self, sample: Sample) -> (Ray, Cone) {
        let mut offset = Vec2::splat(0.5);
        if self.offsets.len() > 1 {
            let bits = hash(fold_seed(self.seed) ^ sample.pixel);
            let [x, y] = self.offsets[sample.index as usize];
            // At most 2²³ strata: f32 holds their middles.
            let digits = self.offsets.len().next_power_of_two().ilog2().min(23);
            let middle = |number: u32| ((number >> (32 - digits)) as f32 + 0.5) / (1 << digits) as f32;
            offset = Vec2::new(middle(x ^ bits), middle(y ^ hash(bits)));
        }
        let ray = self.rays.ray(sample.x as f32 + offset.x, sample.y as f32 + offset.y);
        if !self.cones {
            return (ray, Cone::POINT);
        }
        let (cells, width) = self.cells;
        let middle = ((offset * cells).floor() + 0.5) / cells;
        (ray, self.rays.cone(&ray, width, middle - offset))
    }

    /// Adds one sample's radiance, or a part of it.
    pub(crate) fn add(&mut self, pixel: u32, radiance: Vec3) {
        self.sums[pixel as usize] += radiance;
    }

    /// Notes that a part of a sample, whose radiance is added by itself, shows an unlit surface.
    pub(crate) fn add_unlit(&mut self, sample: UnlitSample) {
        self.unlit.add(sample);
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

    /// The camera's rays and the picture's size.
    pub(crate) fn view(&self) -> View {
        View { rays: self.rays, width: self.order.width, height: self.order.height }
    }
}

/// What a picture's camera sees.
#[derive(Clone, Copy)]
pub(crate) struct View {
    pub(crate) rays: FilmRays,
    /// Pixels.
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl View {
    /// The ray through the middle of a pixel, which is numbered row by row.
    pub(crate) fn pixel_ray(&self, pixel: u32) -> Ray {
        self.rays.ray((pixel % self.width) as f32 + 0.5, (pixel / self.width) as f32 + 0.5)
    }
}

/// The cells of a pixel with so many samples, in each direction, and the width of a square of a cell's area, in pixels.
/// 2^⌈k/2⌉ × 2^⌊k/2⌋ of them, k = ⌊log₂ spp⌋. 10 samples: 4 × 2.
///
/// Textures are averaged over the cell in which a sample lies, not about the sample. As each of the first 2ᵏ points of
/// a (0, 2)-sequence has a cell of its own, the cells' means make the pixel's, and where in its cell a sample lies
/// makes no noise. Error against 256 point samples of the staircase (wallpaper of a pattern a few pixels wide, direct
/// light), four samples: 16.1% with point samples, 12.7% with the same area about the sample, 11.3% with the whole
/// pixel, 9.9% with cells; most of that is on outlines of surfaces.
fn cells_of_pixel(spp: usize) -> (Vec2, f32) {
    let k = spp.ilog2();
    let cells = Vec2::new((1_u32 << k.div_ceil(2)) as f32, (1_u32 << (k / 2)) as f32);
    (cells, 1.0 / (cells.x * cells.y).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(width: u32, height: u32, spp: u32) -> Film {
        let options = RenderOptions::default().with(|o| {
            o.picture.width = width;
            o.picture.height = height;
            o.picture.spp = spp;
        });
        Film::of_rays(Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).film(width, height), &options)
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
                    let p = film.rays.position(&film.ray(s).0) - Vec2::new(s.x as f32, s.y as f32);
                    ((p.x * 4.0) as u32, (p.y * 4.0) as u32)
                })
                .collect();
            strata.sort_unstable();
            strata.dedup();
            assert_eq!(strata.len(), 16);
        }
    }

    /// An edge along a row of pixels covers the part f of them. Four samples say one of five parts, the nearest: the
    /// mean of the squared errors over f is 1/12 of a stratum's square, where samples anywhere in their strata would
    /// have 1/6.
    #[test]
    fn edges_along_rows_are_as_exact_as_strata_let_them_be() {
        let film = film(64, 1, 4);
        let heights: Vec<Vec<f32>> = (0..64)
            .map(|pixel| film.samples(4 * pixel..4 * pixel + 4).map(|s| film.rays.position(&film.ray(s).0).y).collect())
            .collect();
        let error = |i: usize| {
            let f = (i as f32 + 0.5) / 640.0;
            let covered = heights[i % 64].iter().filter(|&&y| y < f).count();
            (covered as f32 / 4.0 - f).powi(2)
        };
        let mean = (0..640).map(error).sum::<f32>() / 640.0;
        assert!((mean * 16.0 - 1.0 / 12.0).abs() < 0.005, "{mean}");
    }

    #[test]
    fn one_sample_is_the_centre_and_more_stay_in_their_pixel() {
        let centre = film(9, 7, 1);
        let sample = centre.samples(0..1).next().expect("a sample");
        assert_eq!(centre.ray(sample).0, centre.rays.ray(0.5, 0.5));
        let film = film(1, 1, 64);
        let mean: Vec3 = film.samples(0..64).map(|s| film.ray(s).0.direction).sum::<Vec3>() / 64.0;
        assert!((mean.x.abs() < 0.01) && (mean.y.abs() < 0.01), "{mean}");
    }
}
