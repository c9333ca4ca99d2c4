//! Refining the meshes where their light is not good enough.
//!
//! Some samples, spread over the picture, are lit by the meshes and by the truth (see `error_bound.rs`). The error of
//! each is charged to the cell that its hit reads. The cells with the largest errors are refined, the worst first,
//! until what is left of the error is small enough: level by level, as errors are smaller on the next. Refinement
//! belongs to the picture: the points that it adds stay, and their values do not depend on it.
//!
//! Gather hits read the first level alone. What they read goes into the values of points, which must not depend on
//! what a picture needs.

use std::collections::BTreeMap;

use glam::Vec3;

use super::pilot::Pilot;
use super::{cells_that_fit, refinement_memory};
use crate::Error;
use crate::direct::{Indirect, LightingPlan, Shading};
use crate::integrator::lighting::Lighting;
use crate::integrator::point_block::ShadedPoint;
use crate::interaction::ShadingPoint;
use crate::mesh::Points;

/// One pixel in so many is lit, within limits.
const PIXELS_PER_SAMPLE: u64 = 24;
const SAMPLES: std::ops::RangeInclusive<u64> = 2048..=32768;

/// Gather rays of the truth, at each sample.
const RAYS: u32 = 64;

/// The error that refining is for where no bound is given: a twentieth of the picture's mean.
const DEFAULT_BOUND: f64 = 0.05;

/// The part of the bound that each mesh may use up. Empirical: the rest is for noise and for direct light.
const SHARE: f64 = 0.35;

/// Refines the meshes of the frame for a picture that is drawn with this plan.
pub(super) fn refine(pilot: &mut Pilot<'_, '_, '_>, plan: LightingPlan) -> Result<(), Error> {
    let options = pilot.frame.options;
    let has_indirect = pilot.frame.lighting.has_indirect();
    // Exact light has no mesh to refine, and paths go on from the first level.
    let refines_direct = plan.primary != Shading::Exact;
    let refines_indirect = has_indirect && !matches!(plan.indirect, Indirect::Unbiased { .. });
    if options.resolved().refinements == 0 || !(refines_direct || refines_indirect) {
        return Ok(());
    }

    // Find the true light of some pixels, twice where it has noise.
    let count = pilot.film.pixel_count() / PIXELS_PER_SAMPLE;
    let pixels = pilot.film.draw(options.seed, 2, count.clamp(*SAMPLES.start(), *SAMPLES.end()));
    let exact =
        |seed| LightingPlan { primary: Shading::Exact, indirect: Indirect::FinalGather { rays: RAYS, seed }, ..plan };
    let first = pilot.light_points(&pixels, exact(1))?;
    let second = if has_indirect { pilot.light_points(&pixels, exact(2))? } else { first.clone() };
    let radiance = |p: &ShadedPoint| f64::from((p.point.weight * (p.direct + p.indirect)).element_sum());
    let mean = first.iter().map(radiance).sum::<f64>() / (3 * pixels.len()) as f64;
    let bound = SHARE * options.method.error().map_or(DEFAULT_BOUND, f64::from) * mean;
    let most = bound * bound * pixels.len() as f64;

    for _ in 0..options.resolved().refinements {
        // Light the same pixels from the meshes as they are.
        let points = pilot.light_points(&pixels, plan.reseeded())?;
        let Lighting::Mesh { mesh, .. } = &mut pilot.frame.lighting else { break };
        let errors = |light: fn(&ShadedPoint) -> Vec3| {
            let truths = first.iter().zip(&second);
            let error = move |(p, (a, b)): (&ShadedPoint, (&ShadedPoint, &ShadedPoint))| {
                let w = p.point.weight;
                let square = (w * (light(p) - light(a))).dot(w * (light(p) - light(b)));
                (p.point, f64::from(square) / 3.0)
            };
            points.iter().zip(truths).map(error).collect::<Vec<_>>()
        };

        // Refine the worst cells of each mesh, as far as memory allows.
        let budget = refinement_memory(pilot.frame.scene, options);
        let mut refined = 0;
        if refines_direct {
            let left = budget.saturating_sub(mesh.direct.stats().bytes);
            let fit = cells_that_fit(left, mesh.direct.bytes_per_point());
            refined += refine_worst(mesh.direct.points_mut(), &errors(|p| p.direct), most, fit);
        }
        if let Some(field) = mesh.indirect.as_mut().filter(|_| refines_indirect) {
            let fit = cells_that_fit(budget.saturating_sub(field.stats().bytes), field.bytes_per_point());
            refined += refine_worst(field.points_mut(), &errors(|p| p.indirect), most, fit);
        }
        if refined == 0 {
            break;
        }
    }
    Ok(())
}

/// Refines the cells with the largest sums of squared errors, at most `fit` cells, until the sum of the others is at
/// most `most`. Returns how many cells it refined.
fn refine_worst(points: &mut Points, errors: &[(ShadingPoint, f64)], most: f64, fit: u64) -> usize {
    let mut cells: BTreeMap<(u32, [i32; 3]), f64> = BTreeMap::new();
    for (point, square) in errors {
        let (level, cell) = points.cell(point);
        *cells.entry((level, cell.to_array())).or_default() += square;
    }
    let mut rest: f64 = cells.values().sum();
    let mut worst: Vec<_> = cells.into_iter().filter(|((level, _), _)| level + 1 < points.level_count()).collect();
    // Stable: equal cells keep their order.
    worst.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut refined = 0;
    for ((level, cell), error) in worst {
        if rest <= most || error <= 0.0 || refined as u64 >= fit {
            break;
        }
        points.refine(level, cell.into());
        rest -= error;
        refined += 1;
    }
    refined
}
