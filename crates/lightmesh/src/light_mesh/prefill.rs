//! Filling ahead of who reads: all points of a box, or all that meters at some places may ask for. Nothing of what is read later
//! depends on it.

use glam::{UVec3, Vec3};
use rayon::prelude::*;

use super::LightMesh;
use crate::direct::{DirectLighting, LightingPlan};
use crate::geometry::Aabb;
use crate::mesh::{Address, Coordinate, Marks, Points, Slot};
use crate::progress::Reporter;
use crate::{Error, Progress, RenderOptions, RenderStats, Scene, Stage};

/// Points that are evaluated between two looks at whether the work should stop: direct and indirect ones.
const DIRECT_AT_ONCE: usize = 1 << 14;
const INDIRECT_AT_ONCE: usize = 1 << 11;

impl LightMesh {
    /// Evaluates every point of both meshes, on their first level, that lies in a box (metres, clipped to the lattices), and all that
    /// indirect points depend on. Those that are known already are left as they are. Surfaces in a box read points up to a spacing
    /// beyond it.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for options out of range, a method without a mesh or options that the mesh was not made for,
    /// [`Error::OutOfMemory`] before anything is evaluated if the points would not fit, and later if those would not that the indirect
    /// points depend on, [`Error::Cancelled`] soon after `progress` says so. What has been evaluated stays.
    pub fn prefill_box(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        bounds: &Aabb,
        progress: &dyn Progress,
    ) -> Result<RenderStats, Error> {
        self.prefill(scene, options, progress, |points, marks| {
            if let Some(block) = points.level(0).lattice.points_in(bounds) {
                mark_block(points, marks, block);
            }
        })
    }

    /// Evaluates every point that meters at these places (metres) read, whichever way they face, and all that indirect points
    /// depend on. Places outside the scene's box have no points to read.
    ///
    /// # Errors
    /// As [`LightMesh::prefill_box`].
    pub fn prefill_meters(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        places: &[Vec3],
        progress: &dyn Progress,
    ) -> Result<RenderStats, Error> {
        let spacing = self.direct.points().spacing();
        self.prefill(scene, options, progress, |points, marks| {
            places.par_iter().filter(|&&p| reaches(scene, spacing, p)).for_each(|&p| {
                mark_block(points, marks, points.neighbourhood.around(&points.level(0).lattice, p));
            });
        })
    }

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

        // Find out what there is to do, and whether there is room for it.
        mark(self.direct.points(), &marks.direct);
        let direct = self.direct.points().take(&mut marks.direct, self.direct.costs(), self.direct.max_memory())?;
        let indirect = match (&self.indirect, &mut marks.indirect) {
            (Some(field), Some(marks)) => {
                mark(field.points(), marks);
                field.points().take(marks, field.costs(), field.max_memory)?
            }
            _ => Vec::new(),
        };
        let reporter = Reporter::new(progress, Stage::Fill, (direct.len() + indirect.len()) as u64);
        let cancelled = || if reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) };

        // Evaluate. Points may come with others that depend on them.
        for wanted in direct.chunks(DIRECT_AT_ONCE) {
            cancelled()?;
            mark_empty(self.direct.points(), &marks.direct, wanted);
            let rays = self.direct.fill(scene, &mut marks.direct)?;
            stats.rays += rays;
            stats.fill_shadow_rays += rays.shadow;
            reporter.add(wanted.len() as u64, rays.total());
        }
        stats.seconds.fill_direct = started.elapsed().as_secs_f64();
        if let (Some(field), Some(indirect_marks)) = (&mut self.indirect, &mut marks.indirect) {
            for wanted in indirect.chunks(INDIRECT_AT_ONCE) {
                cancelled()?;
                mark_empty(field.points(), indirect_marks, wanted);
                let mut direct = DirectLighting {
                    scene,
                    options,
                    plan: LightingPlan::of(options),
                    field: &mut self.direct,
                    marks: &mut marks.direct,
                    reporter: &reporter,
                    stats: &mut stats,
                };
                field.fill(&mut direct, indirect_marks)?;
                reporter.add(wanted.len() as u64, 0);
            }
        }
        stats.seconds.render = started.elapsed().as_secs_f64();
        self.report(options, &mut stats);
        Ok(stats)
    }
}

/// Whether points lie all around a place, in meshes of this spacing: it is in the scene's box, but for rounding.
pub(super) fn reaches(scene: &Scene, spacing: f32, place: Vec3) -> bool {
    let (bounds, slack) = (scene.bounds(), 0.01 * spacing);
    place.cmpge(bounds.min - slack).all() && place.cmple(bounds.max + slack).all()
}

/// Marks the points of a block on the first level that are empty.
fn mark_block(points: &Points, marks: &Marks, (low, high): (Coordinate, Coordinate)) {
    (low.z..=high.z).into_par_iter().for_each(|z| {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                mark_empty(points, marks, &[Address { level: 0, coordinate: UVec3::new(x, y, z) }]);
            }
        }
    });
}

/// Marks those of some points that are still empty.
fn mark_empty(points: &Points, marks: &Marks, wanted: &[Address]) {
    for &address in wanted {
        if points.level(address.level).slot(address.coordinate) == Slot::Empty {
            points.mark(address, marks);
        }
    }
}
