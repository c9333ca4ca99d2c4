//! Direct light to a given error: the renderer lights some pixels exactly, compares cheaper plans with that, and takes
//! the cheapest one within the bound.
//!
//! Two sets of pixels are drawn, each spread over the picture. On the first, the *pilot*, all samples of each pixel
//! are lit exactly, and then by one plan after the other, from the cheapest to the most expensive, until one of them
//! is within the bound. On the second set, which had no part in the choice, that plan must be within the bound too; if
//! it is not, the next plan is tried. A pixel looks the same in the picture as it does here, as random numbers are
//! seeded by the position of what is lit.
//!
//! The truth is a shadow ray to every light sample, and indirect light is left out: `verify.rs` compares all light, and
//! the light samples themselves, with paths.

use glam::Vec3;

use super::pilot::Pilot;
use crate::direct::{Indirect, LightingPlan, SamplingPolicy, Shading, TrustAgreement};
use crate::{Error, RenderStats};

/// Pixels in each set: one in so many, within limits. Judgements: once, in a test's hall of forty lamps of which few
/// pixels are wrong, the error of 1024 pixels was a third too low; `verify.rs` has the last word.
const PIXELS_PER_CHECK: u64 = 200;
const CHECKS: std::ops::RangeInclusive<u64> = 1024..=4096;

/// The part of the bound that a plan must keep to on the pilot, so that it keeps the bound on the other set too.
/// Empirical.
const MARGIN: f64 = 0.7;

/// What reading the mesh light by light costs, in shadow rays per hit, and more for each light: for fewer rays than
/// that it is not worth while. Empirical: in the living room, 2 rays per hit and five lights, it took 1.6 times as
/// long as 4.3 rays and no mesh.
const READING: f64 = 5.0;
const READING_PER_LIGHT: f64 = 0.05;

/// Step and `always_above` of the cheapest plan's policy, in units of the bound. The others have the parts t and t^0.6
/// of them: empirical.
const STEP: f32 = 4.0;
const ALWAYS_ABOVE: f32 = 16.0;

/// The least t: the most expensive policy.
const LEAST_PART: f32 = 0.01;

/// From plan to plan t falls as the square of the error must, as that of noise does: by this factor less than what
/// seems enough, and within limits.
const SAFETY: f32 = 0.9;
const PART_FACTORS: (f32, f32) = (0.3, 0.8);

/// `always_above` is never more than this part of the light.
const MOST_ABOVE: f32 = 0.8;

/// Samples of a pixel that are lit, at most: where there are more, the error of the picture is less than the estimate.
pub(super) const MOST_SAMPLES: u32 = 16;

/// How good a plan is, and what it costs.
#[derive(Clone, Copy, Debug)]
struct PlanCost {
    /// Error of the pixels, relative to the mean of the truth.
    error: f64,
    /// Shadow rays per sample.
    rays: f64,
}

/// Pixels with their exact direct light.
struct Truth {
    pixels: Vec<u32>,
    /// By pixel.
    sums: Vec<Vec3>,
    /// Of all light, over pixels and channels.
    mean: f64,
    /// Shadow rays per sample.
    rays: f64,
}

/// The light of some pixels.
struct PixelLight {
    /// By pixel, the sum of its samples.
    sums: Vec<Vec3>,
    /// Shadow rays per sample, without those that filled the mesh.
    rays: f64,
}

/// Chooses the cheapest plan whose direct light is within `bound` of that at every light sample, starting from what the
/// method says. Returns it with its estimated error, relative to the picture's mean.
pub(super) fn choose_plan(
    pilot: &mut Pilot<'_, '_, '_>,
    plan: LightingPlan,
    bound: f64,
) -> Result<(LightingPlan, f64), Error> {
    let options = pilot.frame.options;
    let truth = Truth::find(pilot, plan, 0, None)?;
    let reading = READING + READING_PER_LIGHT * pilot.frame.scene.lights().len() as f64;
    let mut held_out: Option<Truth> = None;
    let mut part = 1.0_f32;
    // Few lights are traced.
    while part >= LEAST_PART && truth.rays > reading {
        // Try a policy on the pilot pixels.
        let policy = SamplingPolicy {
            step: STEP * part * bound as f32,
            always_above: [(ALWAYS_ABOVE * libm::powf(part, 0.6) * bound as f32).min(MOST_ABOVE); 2],
            agreement: TrustAgreement::Unbiased,
        };
        let plan = LightingPlan { primary: Shading::per_light(policy, options), ..plan };
        let cost = truth.compare(pilot, plan)?;
        if cost.rays + reading >= truth.rays {
            break;
        }

        // Make the next policy better, as far as this one's error asks for.
        let enough = (MARGIN * bound / cost.error.max(f64::MIN_POSITIVE)).powi(2) as f32;
        part *= (SAFETY * enough).clamp(PART_FACTORS.0, PART_FACTORS.1);
        if enough < 1.0 {
            continue;
        }

        // Take the plan if it keeps the bound on the other pixels too.
        let other = match &held_out {
            Some(other) => other,
            None => held_out.insert(Truth::find(pilot, plan, 1, Some(truth.mean))?),
        };
        let check = other.compare(pilot, plan)?;
        let error = (0.5 * (cost.error.powi(2) + check.error.powi(2))).sqrt();
        if error <= bound && check.error <= bound {
            return Ok((plan, error));
        }
    }

    // Trace every light where no policy is cheaper.
    Ok((LightingPlan { primary: Shading::Exact, ..plan }, 0.0))
}

impl Truth {
    /// Draws a set of pixels and lights them exactly. `mean`: that of all light, where it is known.
    fn find(pilot: &mut Pilot<'_, '_, '_>, plan: LightingPlan, set: u32, mean: Option<f64>) -> Result<Self, Error> {
        let count = (pilot.film.pixel_count() / PIXELS_PER_CHECK).clamp(*CHECKS.start(), *CHECKS.end());
        let pixels = pilot.film.draw(pilot.frame.options.seed, set, count);
        let exact = LightingPlan { primary: Shading::Exact, indirect: Indirect::None, ..plan };
        let PixelLight { sums, rays } = light(pilot, &pixels, exact)?;
        let mean_of = |sums: &[Vec3]| {
            sums.iter().map(|sum| f64::from(sum.element_sum())).sum::<f64>() / (3 * pixels.len()) as f64
        };
        let mean = match mean {
            Some(mean) => mean,
            None if !pilot.frame.lighting.has_indirect() => mean_of(&sums),
            None => {
                let all = LightingPlan { indirect: Indirect::Mesh { near_rays: 0 }, ..exact };
                mean_of(&light(pilot, &pixels, all)?.sums)
            }
        };
        Ok(Self { pixels, sums, mean, rays })
    }

    /// Lights the pixels as the plan says, and compares.
    fn compare(&self, pilot: &mut Pilot<'_, '_, '_>, plan: LightingPlan) -> Result<PlanCost, Error> {
        let PixelLight { sums, rays } = light(pilot, &self.pixels, LightingPlan { indirect: Indirect::None, ..plan })?;
        let squares = sums.iter().zip(&self.sums).map(|(&p, &t)| f64::from((p - t).length_squared()));
        let square = squares.sum::<f64>() / (3 * self.pixels.len()) as f64;
        let error = if self.mean > 0.0 { square.sqrt() / self.mean } else { 0.0 };
        Ok(PlanCost { error, rays })
    }
}

/// Lights all samples of some pixels as the plan says.
fn light(pilot: &mut Pilot<'_, '_, '_>, pixels: &[u32], plan: LightingPlan) -> Result<PixelLight, Error> {
    let rays_of = |stats: &RenderStats| stats.rays.shadow - stats.fill_shadow_rays;
    let before = (rays_of(pilot.stats), pilot.stats.rays.primary);
    let spp = pilot.frame.options.picture.spp.min(MOST_SAMPLES);
    let film = pilot.light_pixels(pixels, spp, plan)?;
    let (rays, samples) = (rays_of(pilot.stats) - before.0, pilot.stats.rays.primary - before.1);
    Ok(PixelLight { sums: film.sums_of(pixels), rays: rays as f64 / samples.max(1) as f64 })
}
