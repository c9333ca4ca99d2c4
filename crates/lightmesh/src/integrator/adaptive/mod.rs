//! Decisions before a picture is drawn: where the meshes are refined, and how many shadow rays keep the error within
//! its bound.

mod distance_levels;
mod error_bound;
mod keep_bound;
mod pilot;
mod refine;
mod verify;

use self::pilot::Pilot;
use super::lighting::Lighting;
use super::wave::WaveFrame;
use crate::direct::LightingPlan;
use crate::film::{Film, RenderClock};
use crate::{Error, RenderOptions, RenderStats, Scene};

/// The part of the memory limit beside the scene at which refinement ends.
const MEMORY_SHARE: f64 = 0.5;

/// The most memory at which refinement ends: by default a picture must not depend on how much a machine has.
const MOST_MEMORY: f64 = (2_u64 << 30) as f64;

/// Points that a cell has to fill when it is refined, at most: 3³ of its own and those of the cells around it that
/// blend.
const POINTS_PER_CELL: u64 = 64;

/// Adapts the frame to the picture on the film, as far as the options want it: refines its meshes and chooses how
/// surfaces are lit. Returns the plan to draw the picture with; its error, if it is bounded, is in `stats`.
///
/// # Errors
/// As [`WaveFrame::draw`].
pub(crate) fn adapt(
    frame: &mut WaveFrame<'_>,
    film: &Film,
    clock: &mut RenderClock<'_>,
    stats: &mut RenderStats,
) -> Result<LightingPlan, Error> {
    let plan = LightingPlan::of(frame.options);
    // Take back what was refined for another picture.
    if let Lighting::Mesh { mesh, .. } = &mut frame.lighting {
        mesh.reset_refinement();
    }

    // Refine the meshes near the eye, then where they are most wrong.
    distance_levels::refine_by_distance(frame, film, stats);
    let mut pilot = Pilot { frame, film, clock, stats };
    refine::refine(&mut pilot, plan)?;

    // Choose the cheapest plan that keeps the bound.
    let Some(bound) = pilot.frame.options.method.error() else { return Ok(plan) };
    let (plan, estimate) = keep_bound::keep_bound(&mut pilot, plan, f64::from(bound))?;
    pilot.stats.estimated_error = Some(estimate.all);
    pilot.stats.error_estimate = Some(estimate);
    Ok(plan)
}

/// The memory of meshes at which refinement ends, bytes. A part of the whole limit, not of what is left of it: a frame
/// must not depend on what came before.
fn refinement_memory(scene: &Scene, options: &RenderOptions) -> u64 {
    let left = options.limits.max_memory.saturating_sub(scene.bytes());
    (MEMORY_SHARE * left as f64).min(MOST_MEMORY) as u64
}

/// The cells that may be refined in a mesh with points of this size: as many as fit into a part of the memory limit.
fn cells_that_fit(budget: u64, bytes_per_point: u64) -> u64 {
    budget / (POINTS_PER_CELL * bytes_per_point)
}
