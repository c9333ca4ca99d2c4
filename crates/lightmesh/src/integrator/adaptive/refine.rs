//! Refining the meshes where their light is not good enough.
//!
//! Some samples, spread over the picture, are lit by the meshes and by the truth (see `accuracy.rs`). The error of each is put down to
//! the cell that its hit reads, and the cells that have most of it are refined, the worst first, until what is left of it is
//! small enough: level by level, as errors are smaller on the next. Refinement is the frame's: the points that it asks for
//! stay, and their values do not depend on it.
//!
//! Gather hits read the first level alone. What they read goes into the values of points, which must not depend on what a picture needs.

use std::collections::BTreeMap;

use super::super::block::ShadedPoint;
use super::super::wave::{Lighting, WaveFrame};
use super::pilot::light_pixels;
use crate::direct::{Indirect, LightingPlan, Shading};
use crate::film::{Film, RenderClock};
use crate::interaction::ShadingPoint;
use crate::mesh::Points;
use crate::{Error, RenderStats};

/// One pixel in so many is looked at, within limits.
const PIXELS_PER_HIT: u64 = 24;
const HITS: std::ops::RangeInclusive<u64> = 2048..=32768;

/// The error that refining is for where no bound says so: a twentieth of the picture's mean.
const DEFAULT_BOUND: f64 = 0.05;

/// The part of the bound that each mesh may use up. Empirical: the rest is for noise and for direct light.
const SHARE: f64 = 0.35;

/// The part of the memory limit at which refining ends.
pub(super) const MEMORY_SHARE: f64 = 0.5;

/// Points that a cell asks for when it is refined, at most: 3³ of its own and those of the cells around it that blend.
pub(super) const POINTS_PER_CELL: u64 = 64;

/// Refines the meshes of the frame for the picture on the film.
pub(crate) fn refine(
    frame: &mut WaveFrame<'_>,
    film: &Film,
    watch: &mut RenderClock<'_>,
    stats: &mut RenderStats,
) -> Result<(), Error> {
    let rounds = frame.options.resolved().refinements;
    let is_direct = frame.is_direct();
    // Exact light has no mesh to refine.
    let refines_direct = frame.plan.primary != Shading::Exact;
    // Paths go on from the first level.
    let refines_indirect = !is_direct && !matches!(frame.plan.indirect, Indirect::Unbiased { .. });
    if rounds == 0 || !(refines_direct || refines_indirect) {
        return Ok(());
    }
    let pixels =
        film.draw(frame.options.seed, 2, (film.pixel_count() / PIXELS_PER_HIT).clamp(*HITS.start(), *HITS.end()));
    let plan = frame.plan;
    let mut look = |frame: &mut WaveFrame<'_>, plan: LightingPlan, stats: &mut RenderStats| {
        frame.shaded_points = Some(Vec::new());
        light_pixels(frame, film, (&pixels, 1), plan, watch, stats)?;
        Ok::<_, Error>(frame.shaded_points.take().unwrap_or_default())
    };
    let exact = |seed| LightingPlan { primary: Shading::Exact, indirect: Indirect::FinalGather { seed }, ..plan };
    let first = look(frame, exact(1), stats)?;
    let second = if is_direct { first.clone() } else { look(frame, exact(2), stats)? };
    let radiance = |hit: &ShadedPoint| f64::from((hit.vertex.weight * (hit.direct + hit.indirect)).element_sum());
    let mean = first.iter().map(radiance).sum::<f64>() / (3 * pixels.len()) as f64;
    let bound = SHARE * frame.options.method.error().map_or(DEFAULT_BOUND, f64::from) * mean;

    for _ in 0..rounds {
        let hits = look(frame, plan.reseeded(), stats)?;
        let Lighting::Mesh(mesh) = &mut frame.lighting else { break };
        let errors = |of: fn(&ShadedPoint) -> glam::Vec3| {
            let truths = first.iter().zip(&second);
            let error = move |(hit, (a, b)): (&ShadedPoint, (&ShadedPoint, &ShadedPoint))| {
                let w = hit.vertex.weight;
                let square = (w * (of(hit) - of(a))).dot(w * (of(hit) - of(b)));
                (hit.vertex, f64::from(square) / 3.0)
            };
            hits.iter().zip(truths).map(error).collect::<Vec<_>>()
        };
        let budget = (MEMORY_SHARE * frame.options.limits.max_memory as f64) as u64;
        let most = bound * bound * pixels.len() as f64;
        let mut refined = 0;
        if refines_direct {
            let fit =
                budget.saturating_sub(mesh.direct.stats().bytes) / (POINTS_PER_CELL * mesh.direct.bytes_per_point());
            refined += refine_worst(mesh.direct.points_mut(), &errors(|hit| hit.direct), most, fit);
        }
        if let Some(field) = mesh.indirect.as_mut().filter(|_| refines_indirect) {
            let fit = budget.saturating_sub(field.stats().bytes) / (POINTS_PER_CELL * field.bytes_per_point());
            refined += refine_worst(field.points_mut(), &errors(|hit| hit.indirect), most, fit);
        }
        if refined == 0 {
            break;
        }
    }
    Ok(())
}

/// Refines the cells with the largest sums of squared errors, until the sum of the others is at most `most`, `fit` cells at most; how
/// many these are.
fn refine_worst(points: &mut Points, errors: &[(ShadingPoint, f64)], most: f64, fit: u64) -> usize {
    let mut cells: BTreeMap<(u32, [u32; 3]), f64> = BTreeMap::new();
    for (vertex, square) in errors {
        let (level, cell) = points.cell(vertex);
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
