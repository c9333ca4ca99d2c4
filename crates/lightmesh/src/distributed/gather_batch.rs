//! Filling some points of the indirect mesh step by step, so that several processes can fill a mesh together: what
//! [`IndirectField::fill`] does for all points at once, with exchanges between processes in between.
//!
//! | step | here | needs from the others |
//! |---|---|---|
//! | gather | rays from the points, and which points their hits read ([`GatherBatch::requests`]) | nothing |
//! | light | the direct light where the rays end | the points of the direct mesh there |
//! | bounce k | T_k, for k = 0 … N | T_{k−1} of the points that the hits read |
//!
//! Points that hits read are requested in their turn, until there are no new ones. The values are those of a mesh that
//! one process fills, bit for bit: they depend on the points alone.

use glam::Vec4;
use rayon::prelude::*;

use crate::direct::{DirectLighting, LightingPlan};
use crate::indirect::{GatherRays, IndirectField, Marked, POINTS_AT_ONCE, PendingLight, sphere_directions};
use crate::light_mesh::{IndirectSnapshot, LightMesh, PointCursor, Snapshot};
use crate::mesh::{Address, BrickMask, Coordinate, CornerVisibility, Marks, PointRequests, requests};
use crate::progress::Reporter;
use crate::{Error, Progress, RayCounts, RenderOptions, RenderStats, Scene, Stage};

/// Points of the indirect mesh that are being filled.
#[derive(Debug)]
pub struct GatherBatch {
    /// A mesh of these points alone, which come first, and of those that their hits read.
    field: IndirectField,
    /// How many points are its own.
    own: usize,
    /// How many of the requested points are inside solids.
    own_invalid: usize,
    /// The rays, until their hits are lit.
    gathers: Vec<GatherRays>,
    pending: PendingLight,
    /// Rays traced so far.
    pub rays: RayCounts,
}

/// The light T_k of some points after k reflections or fewer, without that which light samples stand for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BounceValues {
    /// Level and lattice coordinates of each point, ascending; negative coordinates as their two's complement.
    pub points: Vec<[u32; 4]>,
    /// By point: red, green and blue irradiance, lux, on planes that face +x, −x, +y, −y, +z, −z; with
    /// [`Method::Paper`](crate::options::Method::PAPER) formula (4), one colour.
    pub values: Vec<f32>,
}

impl BounceValues {
    /// Merges the values of several batches, which have no point in common.
    pub fn merge<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all: Vec<([u32; 4], &[f32])> = Vec::new();
        for part in parts.into_iter().filter(|part| !part.points.is_empty()) {
            let per_point = part.values.len() / part.points.len();
            all.extend(part.points.iter().copied().zip(part.values.chunks(per_point.max(1))));
        }
        all.sort_unstable_by_key(|&(point, _)| point);
        Self {
            points: all.iter().map(|&(point, _)| point).collect(),
            values: all.iter().flat_map(|&(_, values)| values).copied().collect(),
        }
    }
}

impl GatherBatch {
    /// Gathers for some points of the mesh: finds out which of them are inside solids, shoots the rays of the others
    /// and finds the points that their hits read. `mesh` only gives lattices and settings; it need not have any
    /// points.
    ///
    /// # Errors
    /// [`Error::InvalidBricks`] for bricks that the indirect mesh does not have, [`Error::OutOfMemory`],
    /// [`Error::Cancelled`].
    pub fn new(
        scene: &Scene,
        options: &RenderOptions,
        mesh: &LightMesh,
        bricks: &[BrickMask],
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        options.validate()?;
        mesh.check_compatible(options)?;
        let Some(field) = &mesh.indirect else {
            let what = "there is no indirect mesh without bounces".into();
            return Err(Error::InvalidReflection { what });
        };
        // Find out which points are inside solids.
        let mut field = field.without_points();
        let mut marks = Marks::default();
        requests::mark(field.points(), bricks, &marks)?;
        let mut rays =
            RayCounts { secondary: field.probe(scene, &mut marks, Marked::Needed, 0)?, ..RayCounts::default() };
        let (own, own_invalid) = (field.points().len(), field.points().invalid_addresses().len());
        let reporter = Reporter::new(progress, Stage::Fill, own as u64);

        // Shoot the rays of the others, and find the points that their hits read.
        let directions = sphere_directions(field.gather_rays);
        let mut gathers: Vec<GatherRays> = Vec::new();
        let mut pending = PendingLight::default();
        gathers.resize_with(own, GatherRays::default);
        for (batch, first) in gathers.chunks_mut(POINTS_AT_ONCE).zip((0..).step_by(POINTS_AT_ONCE)) {
            field.shoot_rays(scene, options, first, &directions, batch);
            let hits = field.place_hits(batch, |p| field.points().place(p));
            let secondary = field.find_transfers(scene, &mut marks, (batch, &hits), 0, &mut pending)?;
            let shot: u64 = batch.iter_mut().map(|gather| std::mem::take(&mut gather.rays)).sum();
            (rays.secondary, rays.gather) = (rays.secondary + secondary, rays.gather + shot);
            reporter.add(batch.len() as u64, shot + secondary);
            if reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(Self { field, own, own_invalid, gathers, pending, rays })
    }

    /// Returns how many points it fills, without those inside solids.
    pub fn len(&self) -> usize {
        self.own
    }

    /// Whether all of its points are inside solids.
    pub fn is_empty(&self) -> bool {
        self.own == 0
    }

    /// Returns its memory, bytes: some 12 KiB a point with 256 rays, five times that until its hits are lit.
    pub fn bytes(&self) -> u64 {
        let rays: usize = self.gathers.iter().map(GatherRays::bytes).sum();
        rays as u64 + self.pending.bytes() + self.field.stats().bytes
    }

    /// Returns the points of both meshes that the hits read.
    pub fn requests(&self, scene: &Scene, mesh: &LightMesh) -> PointRequests {
        // Points of the direct mesh that serve the hits.
        let mut direct = Marks::default();
        if self.field.reflects_light() {
            let points = mesh.direct.points();
            let mark = |gather: &GatherRays| {
                points.demand(scene, &gather.hits.vertices, &direct, CornerVisibility::Stochastic)
            };
            self.gathers.par_iter().for_each(mark);
        }

        // Points of the indirect mesh that joined after its own.
        let mut indirect = Marks::default();
        for index in self.own..self.field.points().len() {
            self.field.points().mark(self.field.points().address(index), &indirect);
        }
        PointRequests { direct: requests::take(&mut direct), indirect: requests::take(&mut indirect) }
    }

    /// Lights the hits of the rays from the direct mesh, which is filled where points are missing, and drops the rays.
    /// Called again, it does nothing.
    ///
    /// # Errors
    /// [`Error::IncompatibleMesh`] for another mesh than it was made with, [`Error::OutOfMemory`],
    /// [`Error::Cancelled`].
    pub fn light(
        &mut self,
        scene: &Scene,
        options: &RenderOptions,
        mesh: &mut LightMesh,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        mesh.check_compatible(options)?;
        let reporter = Reporter::new(progress, Stage::Fill, self.own as u64);
        let mut stats = RenderStats::default();
        let mut marks = Marks::default();
        let (field, marks, plan) = (&mut mesh.direct, &mut marks, LightingPlan::of(options));
        let mut direct = DirectLighting { scene, options, plan, field, marks, reporter: &reporter, stats: &mut stats };
        for batch in std::mem::take(&mut self.gathers).chunks_mut(POINTS_AT_ONCE) {
            let mut hits = self.field.place_hits(batch, |p| direct.field.place(p));
            self.field.sum_hits(&mut direct, batch, &mut hits, &mut self.pending)?;
            reporter.add(batch.len() as u64, 0);
        }
        self.rays += stats.rays;
        Ok(())
    }

    /// Computes T_k of its points. `below` has T_{k−1} of all the points that hits read; it is not used where k is 0.
    /// Ask for one bounce after the other; one that is computed already is returned again.
    ///
    /// # Errors
    /// [`Error::InvalidReflection`] where a point is missing below, or the bounce is not the next.
    pub fn bounce(&mut self, scene: &Scene, k: u32, below: &BounceValues) -> Result<BounceValues, Error> {
        let bad = |what: String| Err(Error::InvalidReflection { what });
        let (k, faces) = (k as usize, self.field.faces.count());
        if k >= self.field.bounce_values.len() || (k > 0 && self.field.bounce_values[k - 1].is_empty() && self.own > 0)
        {
            return bad(format!("reflection {k} is not the next of {}", self.field.bounce_values.len() - 1));
        }
        if self.field.bounce_values[k].is_empty() {
            if k > 0 && self.pending.reads_points() {
                self.take_below(k - 1, below)?;
            }
            self.field.bounce_values[k] = self.field.bounce(scene, k, &self.pending);
        }

        // Copy the values of its own points.
        let own = &self.field.bounce_values[k][..self.own * faces];
        let values = own.iter().flat_map(|value| value.truncate().to_array()).collect();
        let points = (0..self.own).map(|i| numbers(self.field.points().address(i))).collect();
        Ok(BounceValues::merge([&BounceValues { points, values }]))
    }

    /// Puts T_k of the points that other batches fill behind that of its own.
    fn take_below(&mut self, k: usize, below: &BounceValues) -> Result<(), Error> {
        let faces = self.field.faces.count();
        let bad = |what: String| Err(Error::InvalidReflection { what });
        if below.values.len() != below.points.len() * faces * 3 {
            return bad(format!("{} numbers are not {} colours a point", below.values.len(), faces));
        }
        let values = &mut self.field.bounce_values[k];
        values.truncate(self.own * faces);
        for index in self.own..self.field.points.len() {
            let point = numbers(self.field.points.address(index));
            let Ok(below_index) = below.points.binary_search(&point) else {
                return bad(format!("point {point:?} is missing, or points are not in order"));
            };
            let colours = below.values[below_index * faces * 3..][..faces * 3].chunks_exact(3);
            values.extend(colours.map(|c| Vec4::new(c[0], c[1], c[2], 0.0)));
        }
        Ok(())
    }
}

/// An address as four numbers; negative coordinates as their two's complement.
fn numbers(Address { level, coordinate: Coordinate { x, y, z } }: Address) -> [u32; 4] {
    [level, x as u32, y as u32, z as u32]
}

impl IndirectField {
    /// An empty field of the same lattices and settings.
    fn without_points(&self) -> Self {
        Self {
            points: self.points.without_points(),
            faces: self.faces,
            gather_rays: self.gather_rays,
            depth: self.depth,
            seed: self.seed,
            bounce_values: vec![Vec::new(); self.bounce_values.len()],
            gather_hit_irradiance: (0.0, 0),
            memory: self.memory.detached(),
            spots: self.spots.clone(),
        }
    }
}

impl GatherBatch {
    /// Copies its points, once they have all bounces, for [`LightMesh::merge`].
    ///
    /// # Errors
    /// [`Error::InvalidReflection`] before that.
    pub fn snapshot(&self, mesh: &LightMesh) -> Result<Snapshot, Error> {
        let own: Vec<u32> = (0..self.len() as u32).collect();
        if self.field.bounce_values.iter().any(|values| values.len() < own.len() * self.field.faces.count()) {
            let what = "the last reflection is still to come".into();
            return Err(Error::InvalidReflection { what });
        }

        // Copy its own points, and leave out those that other batches fill.
        let (hit_irradiance, hit_count) = self.field.gather_hit_irradiance;
        let mut points = self.field.points.snapshot_since(PointCursor::default());
        points.addresses.truncate(own.len());
        points.clearances.truncate(own.len());
        points.invalid.truncate(self.own_invalid);
        let indirect = IndirectSnapshot { hit_irradiance, hit_count, ..self.field.snapshot(points, &own) };
        let nothing = mesh.direct.points.snapshot_since(mesh.direct.points.cursor());
        let direct = mesh.direct.snapshot(nothing, std::iter::empty());
        Ok(Snapshot { direct, indirect: Some(indirect) })
    }
}
