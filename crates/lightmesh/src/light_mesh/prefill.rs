//! Filling the meshes ahead of use: all points of a box, or all that meters at some positions may read. No picture
//! depends on it: it only takes less time afterwards.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::LightMesh;
use crate::direct::{DirectLighting, LightingPlan};
use crate::geometry::Aabb;
use crate::indirect::Marked;
use crate::mesh::{Address, Marks, PointBlock, Points};
use crate::progress::Reporter;
use crate::{Error, Progress, RenderOptions, RenderStats, Scene, Stage};

/// Direct and indirect points that are evaluated between two checks of whether the work was cancelled.
const DIRECT_AT_ONCE: usize = 1 << 14;
const INDIRECT_AT_ONCE: usize = 1 << 11;

impl LightMesh {
    /// Evaluates every point of both meshes, before any refinement, that lies in a box (metres, clipped to the
    /// lattices), and all points that the indirect ones depend on. Points that have been evaluated before are left as
    /// they are. Surfaces in a box read points up to a spacing beyond it.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for options out of range, a method without a mesh or options that the mesh was not made
    /// for, [`Error::OutOfMemory`] before anything is evaluated if the points would not fit, and later if those that
    /// the indirect points depend on would not fit, [`Error::Cancelled`] soon after `progress` cancels. Points that
    /// have been evaluated stay.
    pub fn prefill_box(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        bounds: &Aabb,
        progress: &dyn Progress,
    ) -> Result<RenderStats, Error> {
        self.prefill(scene, options, progress, |points, marks| {
            if let Some(block) = points.level(points.base()).lattice.points_in(bounds) {
                mark_block(points, marks, block);
            }
        })
    }

    /// Evaluates every point that meters at these positions (metres) read, whichever way they face, and all points that
    /// the indirect ones depend on. Positions outside the scene's box are skipped.
    ///
    /// # Errors
    /// As [`LightMesh::prefill_box`].
    pub fn prefill_meters(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        positions: &[Vec3],
        progress: &dyn Progress,
    ) -> Result<RenderStats, Error> {
        let spacing = self.direct.points().spacing();
        self.prefill(scene, options, progress, |points, marks| {
            positions.par_iter().filter(|&&p| covers(scene, spacing, p)).for_each(|&p| {
                mark_block(points, marks, points.interpolator.range_around(&points.level(points.base()).lattice, p));
            });
        })
    }

    /// Evaluates the points that `mark` marks in both meshes.
    fn prefill(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        progress: &dyn Progress,
        mark: impl Fn(&Points, &Marks),
    ) -> Result<RenderStats, Error> {
        options.validate()?;
        if !options.method.has_mesh() {
            return Err(Error::InvalidOption { option: "method", what: "has no mesh to fill".into() });
        }
        self.check_compatible(options)?;
        let started = std::time::Instant::now();
        let mut marks = self.marks();
        let mut stats = RenderStats::default();

        // List the points, and refuse more than fit into memory.
        mark(self.direct.points(), &marks.direct);
        let direct = self.direct.points().take_marked(&mut marks.direct, self.direct.costs(), &self.direct.memory)?;
        let indirect = match (&self.indirect, &mut marks.indirect) {
            (Some(field), Some(marks)) => {
                mark(field.points(), marks);
                field.points().take_marked(marks, field.costs(), &field.memory)?
            }
            _ => Vec::new(),
        };
        let reporter = Reporter::new(progress, Stage::Fill, (direct.len() + indirect.len()) as u64);
        let cancelled = || if reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) };

        // Evaluate. Points may come with others that depend on them.
        for requested in direct.chunks(DIRECT_AT_ONCE) {
            cancelled()?;
            mark_empty(self.direct.points(), &marks.direct, requested);
            let rays = self.direct.fill(scene, &mut marks.direct, &reporter)?;
            stats.rays += rays;
            stats.fill_shadow_rays += rays.shadow;
            reporter.add(requested.len() as u64, 0);
        }
        stats.seconds.fill_direct = started.elapsed().as_secs_f64();
        if let (Some(field), Some(indirect_marks)) = (&mut self.indirect, &mut marks.indirect) {
            for requested in indirect.chunks(INDIRECT_AT_ONCE) {
                cancelled()?;
                mark_empty(field.points(), indirect_marks, requested);
                let mut direct = DirectLighting {
                    scene,
                    options,
                    plan: LightingPlan::of(options),
                    field: &mut self.direct,
                    marks: &mut marks.direct,
                    reporter: &reporter,
                    stats: &mut stats,
                };
                field.fill(&mut direct, indirect_marks, Marked::Needed)?;
                reporter.add(requested.len() as u64, 0);
            }
        }
        stats.seconds.render = started.elapsed().as_secs_f64();
        self.report(options, &mut stats);
        Ok(stats)
    }
}

/// Returns whether mesh points of this spacing lie all around a position: it is in the scene's box, but for rounding.
pub(super) fn covers(scene: &Scene, spacing: f32, position: Vec3) -> bool {
    let (bounds, slack) = (scene.bounds(), 0.01 * spacing);
    position.cmpge(bounds.min - slack).all() && position.cmple(bounds.max + slack).all()
}

/// Marks the points of a block of the base that are empty.
fn mark_block(points: &Points, marks: &Marks, PointBlock { low, high }: PointBlock) {
    (low.z..=high.z).into_par_iter().for_each(|z| {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                mark_empty(points, marks, &[Address { level: points.base(), coordinate: IVec3::new(x, y, z) }]);
            }
        }
    });
}

/// Marks those of some points that have no values yet.
fn mark_empty(points: &Points, marks: &Marks, addresses: &[Address]) {
    for &address in addresses {
        if !points.slot(address).is_complete() {
            points.mark(address, marks);
        }
    }
}
