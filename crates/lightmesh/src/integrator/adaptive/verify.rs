//! Verification: the light of a plan against paths, which share none of its assumptions.
//!
//! What the mesh, its light samples and its gather rays leave out or get wrong is invisible to a truth that is made of
//! the same parts. Paths sample lamps at random, go on through glass and mirrors and read no mesh. Their noise is taken
//! off by having two truths: with T + a and T + b, whose errors a and b are independent, the mean of
//! (p − T − a)(p − T − b) over pixels is the mean of (p − T)². The spread of that product over the pixels tells how far
//! the mean can be trusted; paths are added until it can.
//!
//! The pixels are others than those by which the plan was chosen.

use glam::Vec3;

use super::error_bound::MOST_SAMPLES;
use super::pilot::Pilot;
use crate::Error;
use crate::Stage;
use crate::direct::{Indirect, LightingPlan};
use crate::film::{BRIGHTEST, Film};
use crate::integrator::path_pixels::{PathSums, trace_pixels};
use crate::progress::Reporter;
use crate::sampling::hash;

/// Pixels that are verified, at most; one in so many of small pictures.
const PIXELS: u64 = 512;
const PIXELS_PER_CHECK: u64 = 8;

/// Rays of all paths after which no more are followed: so many, or so many for each sample of the picture if that is
/// more. Judgements: a quarter of a second of two cores, and less than the picture itself.
const MOST_RAYS: u64 = 1 << 19;
const RAYS_PER_SAMPLE: u64 = 3;

/// Paths end where the standard deviation of the mean square is below this part of the squared bound, or of the mean
/// square itself.
const RESOLVED: f64 = 0.15;

/// Paths of each sample in each truth, at most: the sampler's sets have 2¹⁶ points, and a pixel up to 16 samples.
const MOST_PATHS_PER_SAMPLE: u32 = 1 << 11;

/// Some pixels with their path-traced light.
pub(super) struct Verification {
    pixels: Vec<u32>,
    /// Samples of each pixel.
    spp: u32,
    film: Film,
    /// Two by pixel, of independent paths.
    truths: [Vec<PathSums>; 2],
    /// Paths of each sample, in each truth.
    paths: u32,
    round: u32,
    /// Of all paths so far.
    rays: u64,
}

/// How far the light of a plan is from the truth.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Comparison {
    /// Mean square of the error, relative to the squared mean of the truth; below 0 by chance where the error is less
    /// than what the noise of the paths lets see.
    pub square: f64,
    /// The standard deviation of `square`.
    pub deviation: f64,
    /// The part of `deviation` that is more than paths were to leave.
    pub unresolved: f64,
    /// Mean square of the error of direct light and emission alone.
    pub direct: f64,
    /// Mean of the plan's light over that of the truth, less 1.
    pub bias: f64,
    /// Mean square of the noise of all paths together, relative: what a path-traced picture of so many paths has.
    pub noise: f64,
    /// The part of the light that arrives by way of mirrors and glass.
    pub caustics: f64,
}

impl Comparison {
    /// Returns the estimated error: with the noise of the estimate on top as far as paths did not resolve it, and not less
    /// than what that noise lets see.
    pub(super) fn error(&self) -> f64 {
        (self.square.max(self.deviation) + self.unresolved).sqrt()
    }

    /// Returns by how much the estimated error may be off: one standard deviation.
    pub(super) fn uncertainty(&self) -> f64 {
        (self.square.max(0.0) + self.deviation).sqrt() - self.square.max(0.0).sqrt()
    }

    /// Returns the mean square error of what is not direct light.
    pub(super) fn rest(&self) -> f64 {
        (self.square - self.direct.max(0.0)).max(0.0)
    }
}

impl Verification {
    /// Draws pixels; no path is traced yet.
    pub(super) fn new(pilot: &Pilot<'_, '_, '_>) -> Self {
        let options = pilot.frame.options;
        let count = (pilot.film.pixel_count() / PIXELS_PER_CHECK).clamp(PIXELS.min(512), PIXELS);
        let pixels = pilot.film.draw(options.seed, 4, count);
        let spp = options.picture.spp.min(MOST_SAMPLES);
        let film = pilot.film.of_pixels(pixels.clone(), spp);
        let truths = [(); 2].map(|()| vec![PathSums::default(); pixels.len()]);
        Self { pixels, spp, film, truths, paths: 0, round: 0, rays: 0 }
    }

    /// Lights the pixels as the plan says and compares them with paths: as many as it takes to know whether the error is
    /// within `bound`, if that many are allowed.
    pub(super) fn compare(
        &mut self,
        pilot: &mut Pilot<'_, '_, '_>,
        plan: LightingPlan,
        bound: f64,
    ) -> Result<Comparison, Error> {
        let all = pilot.light_pixels(&self.pixels, self.spp, plan)?.sums_of(&self.pixels);
        let direct = LightingPlan { indirect: Indirect::None, ..plan };
        let direct = match pilot.frame.lighting.has_indirect() {
            true => pilot.light_pixels(&self.pixels, self.spp, direct)?.sums_of(&self.pixels),
            false => all.clone(),
        };
        let most_rays = MOST_RAYS.max(RAYS_PER_SAMPLE * pilot.film.sample_count());
        loop {
            if self.paths > 0 {
                let found = self.difference(&all, &direct);
                // More paths are not worth it where they would not change what is said.
                let square = bound * bound;
                let unresolved = found.deviation - RESOLVED * square.max(found.square);
                let is_beyond = found.square - 3.0 * found.deviation > square;
                let is_within = found.square + 3.0 * found.deviation < square;
                let is_spent = 2 * self.rays > most_rays || self.paths >= MOST_PATHS_PER_SAMPLE;
                if unresolved <= 0.0 || is_beyond || is_within || is_spent {
                    return Ok(Comparison { unresolved: unresolved.max(0.0), ..found });
                }
            }
            self.add_paths(pilot)?;
        }
    }

    /// Returns how many rays a plan takes for each sample, where the mesh is filled.
    pub(super) fn rays_per_sample(&self, pilot: &mut Pilot<'_, '_, '_>, plan: LightingPlan) -> Result<f64, Error> {
        let before = pilot.stats.rays.total();
        pilot.light_pixels(&self.pixels, self.spp, plan)?;
        Ok((pilot.stats.rays.total() - before) as f64 / self.film.sample_count() as f64)
    }

    /// Doubles the number of paths.
    fn add_paths(&mut self, pilot: &mut Pilot<'_, '_, '_>) -> Result<(), Error> {
        let count = self.paths.max(1);
        let (scene, options) = (pilot.frame.scene, pilot.frame.options);
        let reporter = Reporter::new(pilot.clock.progress, Stage::Check, 2 * self.film.sample_count());
        for (i, truth) in self.truths.iter_mut().enumerate() {
            let seed = options.seed ^ u64::from(hash(0x7a11 + 2 * self.round + i as u32)) << 20;
            let (sums, rays) = trace_pixels(scene, options, &self.film, count, seed, &reporter);
            if reporter.cancelled() {
                return Err(Error::Cancelled);
            }
            truth.iter_mut().zip(sums).for_each(|(sum, more)| *sum += more);
            pilot.stats.rays += rays;
            self.rays += rays.total();
        }
        self.paths += count;
        self.round += 1;
        Ok(())
    }

    /// Returns how many samples per pixel keep a path-traced picture within `bound`, by the noise of the paths.
    pub(super) fn path_spp(&self, found: &Comparison, bound: f64) -> u64 {
        let paths = 2.0 * f64::from(self.paths) * f64::from(self.spp);
        (found.noise * paths / (bound * bound)).ceil() as u64
    }

    /// Compares the sums of the pixels' samples, of all light and of direct light, with the truth.
    fn difference(&self, all: &[Vec3], direct: &[Vec3]) -> Comparison {
        let n = all.len() as f64;
        let scale = 1.0 / self.paths as f32;
        let [first, second] = &self.truths;
        let mean = |sum: Vec3| f64::from(sum.element_sum()) / (3.0 * n);
        let mean_of = |part: fn(&PathSums) -> Vec3| {
            let sum: f64 = first.iter().zip(second).map(|(a, b)| mean(part(a) + part(b))).sum();
            sum * f64::from(0.5 * scale)
        };
        let lit: f64 = all.iter().map(|&p| mean(p)).sum();
        let truth = mean_of(|sums| sums.all);
        if truth <= 0.0 {
            // Without any light, a picture is right if it is black.
            let square = if lit > 0.0 { 1.0 } else { 0.0 };
            return Comparison { square, ..Comparison::default() };
        }

        // Mean and variance of the products over the pixels, and the noise of the paths.
        let (mut sum, mut squares, mut of_direct, mut noise) = (0.0, 0.0, 0.0, 0.0);
        // What is far brighter than the picture is white on a display, whatever it is: a single path may be such.
        let most = Vec3::splat(BRIGHTEST * truth as f32);
        for (i, (a, b)) in first.iter().zip(second).enumerate() {
            let product = |p: Vec3, a: Vec3, b: Vec3| {
                let (p, a, b) = (p.min(most), (a * scale).min(most), (b * scale).min(most));
                f64::from((p - a).dot(p - b)) / 3.0
            };
            let square = product(all[i], a.all, b.all);
            sum += square;
            squares += square * square;
            of_direct += product(direct[i], a.direct, b.direct);
            let difference = (a.all * scale).min(most) - (b.all * scale).min(most);
            noise += f64::from(difference.length_squared()) / 12.0;
        }
        let variance = (squares / n - (sum / n).powi(2)).max(0.0) / n;
        // Few pixels may agree by chance, but not better than the noise of the paths lets see.
        let deviation = variance.sqrt().max(2.0 * noise / n / n.sqrt());
        let relative = 1.0 / (truth * truth);
        Comparison {
            square: sum / n * relative,
            deviation: deviation * relative,
            unresolved: 0.0,
            direct: of_direct / n * relative,
            bias: lit / truth - 1.0,
            noise: noise / n * relative,
            caustics: mean_of(|sums| sums.caustics) / truth,
        }
    }
}
