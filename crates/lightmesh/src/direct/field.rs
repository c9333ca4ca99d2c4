//! The direct field: formula (1) at mesh points and formula (3g) over them.

use glam::Vec3;

use super::encoding::{DirectEncoding, LightRuns};
use super::region_cuts::RegionCuts;
use super::sky_views::SkyViews;
use crate::interaction::ShadingPoint;
use crate::mesh::{Costs, Interpolator, Levels, Points};
use crate::world::FieldMemory;
use crate::{Error, MeshStats, RenderOptions, Scene};

/// Direct light at points of its mesh.
#[derive(Debug)]
pub(crate) struct DirectField {
    pub(crate) points: Points,
    /// The values of the points, under the same indices.
    pub(crate) encoding: DirectEncoding,
    pub(super) lights: RegionCuts,
    pub(super) sky: SkyViews,
    pub(crate) memory: FieldMemory,
}

impl DirectField {
    /// An empty field.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated.
    pub(crate) fn new(
        scene: &Scene,
        levels: Levels,
        interpolator: Interpolator,
        options: &RenderOptions,
        memory: FieldMemory,
    ) -> Result<Self, Error> {
        let lights = RegionCuts::new(scene, levels.focus, options, memory.left())?;
        let encoding = DirectEncoding::new(scene, lights.has_clusters().then(|| lights.leaf_count()), options);
        let points = Points::new(levels, interpolator);
        let sky = SkyViews::new(scene, memory.left());
        Ok(Self { points, encoding, lights, sky, memory })
    }

    /// Returns a number that positions share which are shaded with the same points or lights.
    pub(crate) fn place(&self, p: Vec3) -> u64 {
        if self.lights.has_clusters() { self.lights.region(p) } else { self.points.place(p) }
    }

    /// Whether parts of the lights are kept for themselves.
    pub(super) fn has_parts(&self) -> bool {
        self.encoding.has_parts()
    }

    /// Returns the number of points, and their memory.
    pub(crate) fn stats(&self) -> MeshStats {
        self.points.stats(self.encoding.bytes() + self.lights.bytes() + self.sky.bytes())
    }

    /// Returns what filling points takes. The memory of runs is not in it: [`Self::check_memory_of_runs`]
    /// checks that when they have been evaluated.
    pub(crate) fn costs(&self) -> Costs {
        Costs::kept(self.encoding.bytes_per_point())
    }

    /// Returns the memory of a point, bytes; an estimate where points differ.
    pub(crate) fn bytes_per_point(&self) -> u64 {
        let runs = self.encoding.runs().map_or(0, |_| LightRuns::BYTES_PER_POINT);
        self.encoding.bytes_per_point() + runs + Points::BYTES_PER_POINT
    }

    /// Refuses `points` new points with `runs` runs in all if they would not fit into the memory of the field.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub(crate) fn check_memory_of_runs(&self, points: usize, runs: usize) -> Result<(), Error> {
        let Some(own) = self.encoding.runs() else { return Ok(()) };
        // A growing vector may hold twice its contents for a moment.
        let needed_bytes = self.points.stats(2 * own.bytes_with(points, runs) + self.lights.bytes()).bytes;
        self.memory.reserve(needed_bytes, "choose a larger --spacing or --light-error")
    }

    /// Returns its points, to be refined.
    pub(crate) fn points_mut(&mut self) -> &mut Points {
        &mut self.points
    }

    /// Returns the lights of its scene.
    pub(crate) fn lights(&self) -> &RegionCuts {
        &self.lights
    }

    /// Returns the lights of its scene, to make further cuts.
    pub(crate) fn lights_mut(&mut self) -> &mut RegionCuts {
        &mut self.lights
    }

    /// Returns its points.
    pub(crate) fn points(&self) -> &Points {
        &self.points
    }

    /// Returns how often the cell that a vertex reads has been refined.
    pub(crate) fn level_at(&self, vertex: &ShadingPoint) -> u32 {
        self.points.cell(vertex).0.saturating_sub(self.points.base())
    }
}
