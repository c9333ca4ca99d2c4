//! Keeping all light within a bound: plans from the cheapest to the most expensive, verified by paths until one of them
//! is good enough.
//!
//! The first has direct light by the cheapest policy within the bound (`error_bound.rs`), or the mean visibility of the mesh
//! where its points do not know single lights, and indirect light from the mesh.
//! While the bound is not kept, what is wrong is made better:
//!
//! | what is wrong | then |
//! |---|---|
//! | indirect light | two, then four times as many short rays; then gather rays at every surface; then gather rays that go on as paths, with the mesh as control variate |
//! | direct light | a policy with more shadow rays, as far as the rest leaves room for it; then a ray to each light sample |
//! | direct light by a ray to each sample of a sky | the policy of *hybrid*, which shoots more rays to where a window is |
//!
//! A plan is taken if its verified error is within the bound, or is so much less than that of the plan before that it
//! is worth its rays. If none keeps the bound, the estimate says so.

use super::error_bound::choose_plan;
use super::pilot::Pilot;
use super::verify::{Comparison, Verification};
use crate::direct::{Indirect, LightingPlan, SamplingPolicy, Shading};
use crate::{Error, ErrorEstimate};

/// The part of the bound that direct light gets first. Measured on Sponza at 5%: with all of it 4.5% error, with half 4.1% in
/// 1.05 times the time.
const DIRECT_SHARE: f64 = 0.5;

/// A more expensive plan that does not keep the bound either is taken where its mean square error is below this part of
/// what it was. Empirical.
const WORTH: f64 = 0.7;

/// The part of the squared bound above which indirect light is made better first: direct light alone would have to be too
/// good. A judgement.
const MUCH: f64 = 0.5;

/// The part of what is left of the bound that direct light aims at, and the least part of the bound that is worth a
/// policy of its own. Judgements, not varied.
const LEFT: f64 = 0.9;
const LEAST_TARGET: f64 = 0.2;

/// As many light samples may get a ray each where the mesh's mean visibility is not good enough. A judgement.
const MOST_EXACT: usize = 512;

/// An error below this is rounding: the light is exact.
const ROUNDING: f64 = 1e-5;

/// How many times as many short rays are tried. Living room at 5%: 5.5% error with twice, 5.4% for a quarter more time with four
/// times as many.
const MORE_NEAR_RAYS: [u32; 2] = [2, 4];

/// Gather rays with which paths are tried, and the most that are taken. Judgements, not varied.
const TRIED_RAYS: u32 = 16;
const MOST_RAYS: u32 = 64;

/// A plan, and how far its light is from that of paths.
#[derive(Clone, Copy)]
struct Verified {
    plan: LightingPlan,
    found: Comparison,
}

/// The search for a plan within a bound.
struct Search {
    verification: Verification,
    /// The best so far.
    best: Verified,
    bound: f64,
}

/// Chooses the cheapest plan whose picture is within `bound` of the truth, starting from what the method says, or the
/// best that there is. Returns it with its error.
pub(super) fn keep_bound(
    pilot: &mut Pilot<'_, '_, '_>,
    plan: LightingPlan,
    bound: f64,
) -> Result<(LightingPlan, ErrorEstimate), Error> {
    let (first, chosen_error) = match (plan.primary, pilot.frame.lighting.has_indirect()) {
        (Shading::MeanVisibility, _) => (plan, 0.0),
        (_, true) => choose_plan(pilot, plan, DIRECT_SHARE * bound)?,
        (_, false) => choose_plan(pilot, plan, bound)?,
    };
    let mut verification = Verification::new(pilot);
    let found = verification.compare(pilot, first, bound)?;
    let mut search = Search { verification, best: Verified { plan: first, found }, bound };
    let mut is_shaded_again = false;
    // Each step makes one of the two lights better; those that are left undone are more expensive.
    for make_better in
        [Search::trace_short_rays, Search::shade_better, Search::trace_sky, Search::gather, Search::follow]
    {
        if search.is_kept() {
            break;
        }
        make_better(&mut search, pilot)?;
        // Direct light may have room now that the rest is better.
        if !is_shaded_again && !search.is_kept() && search.rest() < MUCH * bound * bound {
            is_shaded_again = true;
            search.shade_better(pilot)?;
        }
    }

    // Report what the plan has.
    let Search { verification, best: Verified { plan, found }, .. } = search;
    let all = if plan == first { found.error().max(chosen_error) } else { found.error() };
    let is_exact = plan.primary == Shading::Exact && !pilot.frame.lighting.has_indirect() && all < ROUNDING;
    let estimate = ErrorEstimate {
        all: if is_exact { 0.0 } else { all },
        direct: found.direct.max(0.0).sqrt(),
        uncertainty: found.uncertainty(),
        bias: found.bias,
        caustics: found.caustics,
        path_spp: verification.path_spp(&found, bound),
    };
    Ok((plan, estimate))
}

impl Search {
    /// Whether the best plan keeps the bound.
    fn is_kept(&self) -> bool {
        self.best.found.square <= self.bound * self.bound
    }

    /// The mean square error of what is not direct light.
    fn rest(&self) -> f64 {
        self.best.found.rest()
    }

    /// Whether indirect light is what is wrong.
    fn needs_indirect(&self, pilot: &Pilot<'_, '_, '_>) -> bool {
        pilot.frame.lighting.has_indirect() && self.rest() > MUCH * self.bound * self.bound
    }

    /// Verifies a more expensive plan, and takes it if it is better by enough. Returns how good it is.
    fn try_plan(&mut self, pilot: &mut Pilot<'_, '_, '_>, plan: LightingPlan) -> Result<Comparison, Error> {
        if plan == self.best.plan {
            return Ok(self.best.found);
        }
        let found = self.verification.compare(pilot, plan, self.bound)?;
        let is_kept = found.square <= self.bound * self.bound;
        if is_kept || found.square < self.worth(pilot, plan)? * self.best.found.square {
            self.best = Verified { plan, found };
        }
        Ok(found)
    }

    /// The part of the best plan's mean square error below which another one is worth its rays, where neither keeps the
    /// bound: error falls as the root of the rays that are spent on it. Measured on a cove lit by panels: gathering
    /// everywhere had 26% error instead of 39% for 25 times the time.
    fn worth(&self, pilot: &mut Pilot<'_, '_, '_>, plan: LightingPlan) -> Result<f64, Error> {
        let samples = pilot.film.sample_count() as f64;
        let so_far = pilot.stats.rays.total() as f64;
        let mut rays = |plan| Ok::<_, Error>(so_far + samples * self.verification.rays_per_sample(pilot, plan)?);
        Ok((rays(self.best.plan)? / rays(plan)?).sqrt().min(WORTH))
    }

    /// Shoots more short rays, where indirect light is wrong.
    fn trace_short_rays(&mut self, pilot: &mut Pilot<'_, '_, '_>) -> Result<(), Error> {
        let plan = self.best.plan;
        let Indirect::Mesh { near_rays: near_rays @ 1.. } = plan.indirect else { return Ok(()) };
        for times in MORE_NEAR_RAYS {
            if !self.is_kept() && self.needs_indirect(pilot) {
                let indirect = Indirect::Mesh { near_rays: times * near_rays };
                self.try_plan(pilot, LightingPlan { indirect, ..plan })?;
            }
        }
        Ok(())
    }

    /// Traces more shadow rays, where the rest leaves room for direct light.
    fn shade_better(&mut self, pilot: &mut Pilot<'_, '_, '_>) -> Result<(), Error> {
        let (square, plan) = (self.bound * self.bound, self.best.plan);
        if plan.primary == Shading::Exact || self.rest() >= square {
            return Ok(());
        }
        if plan.primary == Shading::MeanVisibility {
            // A ray to each of many lights at each surface is no way out.
            if pilot.frame.scene.lights().len() <= MOST_EXACT {
                self.try_plan(pilot, LightingPlan { primary: Shading::Exact, ..plan })?;
            }
            return Ok(());
        }
        let target = LEFT * (square - self.rest()).sqrt();
        let primary = match target > LEAST_TARGET * self.bound {
            true => choose_plan(pilot, plan, target)?.0.primary,
            false => Shading::Exact,
        };
        self.try_plan(pilot, LightingPlan { primary, ..plan })?;
        Ok(())
    }

    /// A ray to each part of the sky is not many behind a window: *hybrid* shoots more to the parts that show there.
    fn trace_sky(&mut self, pilot: &mut Pilot<'_, '_, '_>) -> Result<(), Error> {
        let has_noise =
            pilot.frame.scene.lights().has_strata() && self.best.found.direct > 0.5 * self.bound * self.bound;
        if self.best.plan.primary == Shading::Exact && has_noise {
            let primary = Shading::per_light(SamplingPolicy::HYBRID, pilot.frame.options);
            self.try_plan(pilot, LightingPlan { primary, ..self.best.plan })?;
        }
        Ok(())
    }

    /// Gathers at every surface, where indirect light is wrong.
    fn gather(&mut self, pilot: &mut Pilot<'_, '_, '_>) -> Result<(), Error> {
        if self.needs_indirect(pilot) {
            let rays = LightingPlan::gather_rays(pilot.frame.options.picture.spp);
            let plan = LightingPlan { indirect: Indirect::FinalGather { rays, seed: 3 }, ..self.best.plan };
            self.try_plan(pilot, plan)?;
        }
        Ok(())
    }

    /// Lets gather rays go on as paths.
    fn follow(&mut self, pilot: &mut Pilot<'_, '_, '_>) -> Result<(), Error> {
        if !self.needs_indirect(pilot) {
            return Ok(());
        }
        let seed = pilot.frame.options.seed;
        let by = |rays, plan| LightingPlan { indirect: Indirect::Unbiased { rays, seed }, ..plan };
        let plan = self.best.plan;
        let tried = self.try_plan(pilot, by(TRIED_RAYS, plan))?.square;
        let (square, expected) = (self.bound * self.bound, tried * f64::from(TRIED_RAYS) / f64::from(MOST_RAYS));
        if tried > square && expected < square {
            self.try_plan(pilot, by(MOST_RAYS, plan))?;
        }
        Ok(())
    }
}
