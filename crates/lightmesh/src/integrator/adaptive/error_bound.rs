//! Light to a given error: the renderer compares itself with the truth where that is affordable, and takes the cheapest way that is
//! good enough.
//!
//! Two sets of pixels are drawn, each spread over the picture. On the first, the *pilot*, all samples of each pixel are lit
//! exactly, and then by one plan after the other, from the cheapest to the most careful, until one of them is within the bound; on
//! the second, which had no part in the choice, that plan must be within it too. If it is not, the next plan is tried. The
//! estimate which is reported is the error on both sets. A pixel comes out of the picture as it does here: what is
//! lit is seeded by its place.
//!
//! The truth of direct light is a shadow ray to every light. That of indirect light is gathered at each hit with rays of its
//! own, twice with other rays: with both truths T + a and T + b, whose errors a and b know nothing of each other, the mean of
//! (p − T − a)(p − T − b) is the mean of (p − T)². The gather rays read the mesh where they end, so that what is
//! measured is the last bounce, which is the largest part of the error.

use glam::Vec3;

use super::super::wave::WaveFrame;
use super::pilot::light_pixels;
use crate::direct::{Indirect, LightingPlan, SamplingPolicy, Shading, TrustAgreement};
use crate::film::{Film, RenderClock};
use crate::{Error, RenderStats};

/// Pixels in each set: one in so many, within limits. Empirical: with 1024 pixels the estimate was a third too low once, where few
/// pixels are wrong (a test's hall of forty lamps).
const PIXELS_PER_CHECK: u64 = 48;
const CHECKS: std::ops::RangeInclusive<u64> = 2048..=8192;

/// The part of the bound that a plan must keep to on the pilot, so that it keeps the bound on the other set too. Empirical.
const MARGIN: f64 = 0.7;

/// What reading the mesh light by light takes, in shadow rays per hit, and more for each light: for fewer rays than that it is not
/// worth while. Empirical: in the living room, 2 rays per hit and five lights, it took 1.6 times as long as 4.3 rays and no mesh.
const READING: f64 = 5.0;
const READING_PER_LIGHT: f64 = 0.05;

/// Quantum and much of the plan that takes the least care, in units of the bound. Others have the parts t and t^0.6 of them: empirical.
const QUANTUM: f32 = 4.0;
const MUCH: f32 = 16.0;

/// The most care: the least t.
const LEAST_PART: f32 = 0.01;

/// From plan to plan t falls as the square of the error must, as that of noise does: by this factor less than what seems enough, and
/// within limits.
const SAFETY: f32 = 0.9;
const STEPS: (f32, f32) = (0.3, 0.8);

/// Much is never more than this part of the light.
const MOST: f32 = 0.8;

/// Samples of a pixel that are looked at, at most: where there are more, the error of the picture is less than the estimate.
const MOST_SAMPLES: u32 = 16;

/// What a check has found.
#[derive(Clone, Copy, Debug)]
struct PlanCost {
    /// Error of the pixels, relative to the mean of the truth.
    error: f64,
    /// Shadow rays per sample.
    rays: f64,
}

/// Pixels with their true light.
struct Truth {
    pixels: Vec<u32>,
    /// Two by pixel, whose errors are independent; the same one twice where light is exact.
    sums: [Vec<Vec3>; 2],
    /// Mean over pixels and channels, of the first.
    mean: f64,
    /// Shadow rays per sample.
    rays: f64,
}

/// Chooses the plan whose picture is within `bound` of the truth, and says what its error is: relative to the mean,
/// estimated.
pub(crate) fn choose_plan(
    frame: &mut WaveFrame<'_>,
    film: &Film,
    bound: f32,
    watch: &mut RenderClock<'_>,
    stats: &mut RenderStats,
) -> Result<f64, Error> {
    let bound = f64::from(bound);
    let pilot = Truth::find(frame, film, 0, watch, stats)?;
    let lights = frame.scene.lights().len() as f64;
    let reading = READING + READING_PER_LIGHT * lights;
    let mut check: Option<Truth> = None;
    let mut part = 1.0_f32;
    // Few lights are traced.
    while part >= LEAST_PART && pilot.rays > reading {
        let much = [(MUCH * libm::powf(part, 0.6) * bound as f32).min(MOST); 2];
        let care = SamplingPolicy {
            step: QUANTUM * part * bound as f32,
            always_above: much,
            agreement: TrustAgreement::Unbiased,
        };
        frame.plan = LightingPlan { primary: Shading::by_light(care, frame.options), ..frame.plan };
        let found = pilot.compare(frame, film, watch, stats)?;
        if found.rays + reading >= pilot.rays {
            break;
        }
        let enough = (MARGIN * bound / found.error.max(f64::MIN_POSITIVE)).powi(2) as f32;
        part *= (SAFETY * enough).clamp(STEPS.0, STEPS.1);
        if enough < 1.0 {
            continue;
        }
        if check.is_none() {
            check = Some(Truth::find(frame, film, 1, watch, stats)?);
        }
        if let Some(check) = &check {
            let held_out = check.compare(frame, film, watch, stats)?;
            let error = (0.5 * (found.error.powi(2) + held_out.error.powi(2))).sqrt();
            if error <= bound && held_out.error <= bound {
                return Ok(error);
            }
        }
    }
    frame.plan = LightingPlan { primary: Shading::Exact, ..frame.plan };
    if frame.is_direct() {
        return Ok(0.0);
    }
    Ok(pilot.compare(frame, film, watch, stats)?.error)
}

impl Truth {
    /// Draws a set of pixels and lights them exactly.
    fn find(
        frame: &mut WaveFrame<'_>,
        film: &Film,
        set: u32,
        watch: &mut RenderClock<'_>,
        stats: &mut RenderStats,
    ) -> Result<Self, Error> {
        let count = (film.pixel_count() / PIXELS_PER_CHECK).clamp(*CHECKS.start(), *CHECKS.end());
        let pixels = film.draw(frame.options.seed, set, count);
        let plan = frame.plan;
        let truth = |seed| LightingPlan { primary: Shading::Exact, indirect: Indirect::FinalGather { seed }, ..plan };
        let (first, rays) = light(frame, film, &pixels, truth(1), watch, stats)?;
        let second = match frame.is_direct() {
            true => first.clone(),
            false => light(frame, film, &pixels, truth(2), watch, stats)?.0,
        };
        let mean = first.iter().map(|sum| f64::from(sum.element_sum())).sum::<f64>() / (3 * pixels.len()) as f64;
        Ok(Self { pixels, sums: [first, second], mean, rays })
    }

    /// Lights the pixels as the frame plans to, and compares.
    fn compare(
        &self,
        frame: &mut WaveFrame<'_>,
        film: &Film,
        watch: &mut RenderClock<'_>,
        stats: &mut RenderStats,
    ) -> Result<PlanCost, Error> {
        let (sums, rays) = light(frame, film, &self.pixels, frame.plan, watch, stats)?;
        let [first, second] = &self.sums;
        let squares = sums.iter().zip(first).zip(second);
        let sum: f64 = squares.map(|((&p, &a), &b)| f64::from(((p - a) * (p - b)).element_sum())).sum();
        let square = sum.max(0.0) / (3 * self.pixels.len()) as f64;
        let error = if self.mean > 0.0 { square.sqrt() / self.mean } else { 0.0 };
        Ok(PlanCost { error, rays })
    }
}

/// Lights all samples of some pixels by a plan; their sums, and shadow rays per sample.
pub(crate) fn light(
    frame: &mut WaveFrame<'_>,
    film: &Film,
    pixels: &[u32],
    plan: LightingPlan,
    watch: &mut RenderClock<'_>,
    stats: &mut RenderStats,
) -> Result<(Vec<Vec3>, f64), Error> {
    let rays_of = |stats: &RenderStats| stats.rays.shadow - stats.fill_shadow_rays;
    let before = (rays_of(stats), stats.rays.primary);
    let spp = frame.options.picture.spp.min(MOST_SAMPLES);
    let film = light_pixels(frame, film, (pixels, spp), plan, watch, stats)?;
    let (rays, samples) = (rays_of(stats) - before.0, stats.rays.primary - before.1);
    Ok((film.sums_of(pixels), rays as f64 / samples.max(1) as f64))
}
