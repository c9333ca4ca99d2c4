//! Keeping all light within a bound: plans from the cheapest to the most expensive, verified by paths until one of them
//! is good enough.
//!
//! 1. direct light by the cheapest policy within the bound (`error_bound.rs`), indirect light from the mesh;
//! 2. more shadow rays, where direct light leaves too little of the bound to the rest, and if a ray to each light sample is
//!    still too noisy, those of *hybrid*, which go where a window is;
//! 3. gather rays at every surface, where it is the indirect light that is wrong;
//! 4. gather rays that go on as paths, with the mesh as control variate, where reading it at the ends of gather rays is
//!    what is wrong.
//!
//! A plan is taken if its verified error is within the bound, or is so much less than that of the plan before that it
//! is worth its rays. If none keeps the bound, the estimate says so.

use super::error_bound::choose_plan;
use super::pilot::Pilot;
use super::verify::{Comparison, Verification};
use crate::direct::{Indirect, LightingPlan, SamplingPolicy, Shading};
use crate::{Error, ErrorEstimate};

/// A more expensive plan that does not keep the bound either is taken where its mean square error is below this part of
/// what it was. Empirical.
const WORTH: f64 = 0.7;

/// The part of what is left of the bound that direct light aims at, and the least part of the bound that is worth a
/// policy of its own. Judgements, not varied.
const LEFT: f64 = 0.9;
const LEAST_TARGET: f64 = 0.2;

/// An error below this is rounding: the light is exact.
const ROUNDING: f64 = 1e-5;

/// Gather rays with which paths are tried, and the most that are taken. Judgements, not varied.
const TRIED_RAYS: u32 = 16;
const MOST_RAYS: u32 = 64;

/// A plan, and how far its light is from that of paths.
#[derive(Clone, Copy)]
struct Verified {
    plan: LightingPlan,
    found: Comparison,
}

impl Verified {
    /// Returns whether a more expensive plan should take its place.
    fn gives_way_to(&self, other: &Self, bound: f64) -> bool {
        other.found.error() <= bound || other.found.square < WORTH * self.found.square
    }
}

/// Chooses the cheapest plan whose picture is within `bound` of the truth, starting from what the method says, or the
/// best that there is. Returns it with its error.
pub(super) fn keep_bound(
    pilot: &mut Pilot<'_, '_, '_>,
    plan: LightingPlan,
    bound: f64,
) -> Result<(LightingPlan, ErrorEstimate), Error> {
    let (first, chosen_error) = choose_plan(pilot, plan, bound)?;
    let mut verification = Verification::new(pilot);
    let mut verify = |pilot: &mut Pilot<'_, '_, '_>, plan| -> Result<Verified, Error> {
        Ok(Verified { plan, found: verification.compare(pilot, plan, bound)? })
    };
    let mut best = verify(pilot, first)?;
    let mut try_plan = |pilot: &mut Pilot<'_, '_, '_>, best: &mut Verified, plan| -> Result<Verified, Error> {
        let next = verify(pilot, plan)?;
        if best.gives_way_to(&next, bound) {
            *best = next;
        }
        Ok(next)
    };

    // Trace more shadow rays, where the rest leaves room for direct light.
    let square = bound * bound;
    if best.found.error() > bound && best.plan.primary != Shading::Exact && best.found.rest() < square {
        let target = LEFT * (square - best.found.rest()).sqrt();
        let primary = match target > LEAST_TARGET * bound {
            true => choose_plan(pilot, best.plan, target)?.0.primary,
            false => Shading::Exact,
        };
        try_plan(pilot, &mut best, LightingPlan { primary, ..first })?;
    }

    // A ray to each part of the sky is not many behind a window: *hybrid* shoots more to the parts that show there.
    let has_noise = pilot.frame.scene.lights().has_strata() && best.found.direct > 0.5 * square;
    if best.found.error() > bound && best.plan.primary == Shading::Exact && has_noise {
        let primary = Shading::per_light(SamplingPolicy::HYBRID, pilot.frame.options);
        let plan = LightingPlan { primary, ..best.plan };
        try_plan(pilot, &mut best, plan)?;
    }

    // Gather at every surface, where more than the direct light is wrong.
    if best.found.error() > bound && pilot.frame.lighting.has_indirect() && best.found.rest() > 0.5 * square {
        let plan = LightingPlan { indirect: Indirect::FinalGather { seed: 3 }, ..best.plan };
        try_plan(pilot, &mut best, plan)?;
    }

    // Let gather rays go on as paths.
    if best.found.error() > bound && pilot.frame.lighting.has_indirect() && best.found.rest() > 0.5 * square {
        let paths = |rays| Indirect::Unbiased { rays, seed: pilot.frame.options.seed };
        let (few, many) = (paths(TRIED_RAYS), paths(MOST_RAYS));
        let plan = LightingPlan { indirect: few, ..best.plan };
        let tried = try_plan(pilot, &mut best, plan)?;
        let expected = tried.found.square * f64::from(TRIED_RAYS) / f64::from(MOST_RAYS);
        if tried.found.error() > bound && expected < square {
            let plan = LightingPlan { indirect: many, ..tried.plan };
            try_plan(pilot, &mut best, plan)?;
        }
    }

    // Report what the plan has.
    let found = best.found;
    let all = if best.plan == first { found.error().max(chosen_error) } else { found.error() };
    let is_exact = best.plan.primary == Shading::Exact && !pilot.frame.lighting.has_indirect() && all < ROUNDING;
    let estimate = ErrorEstimate {
        all: if is_exact { 0.0 } else { all },
        direct: found.direct.max(0.0).sqrt(),
        uncertainty: found.uncertainty(),
        bias: found.bias,
        caustics: found.caustics,
        path_spp: verification.path_spp(&found, bound),
    };
    Ok((best.plan, estimate))
}
