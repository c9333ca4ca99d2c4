//! The surface points of one block, and the direct and indirect light that they get.

use glam::Vec3;

use crate::direct::{Indirect, LightingPlan, Shading, ShadingBatch};
use crate::indirect::{IndirectField, IndirectReading, NearPoints};
use crate::interaction::ShadingPoint;
use crate::light_mesh::{LightMarks, LightMesh};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::{RenderStats, Scene};

/// Surface points that are lit together, found by a block's rays or given as meters; buffers are kept from use to use.
#[derive(Debug, Default)]
pub(super) struct PointBlock {
    /// The points and their direct light.
    pub(super) batch: ShadingBatch,
    /// Indirect irradiance of each point, lux; empty where there is none.
    pub(super) indirect: Vec<Vec3>,
    /// Points whose indirect light has still to be read from the mesh.
    pub(super) waiting: Vec<u32>,
    /// Points that no point of the indirect mesh can serve: they gather their light themselves.
    pub(super) unresolved: Vec<u32>,
    /// Rays that found out which mesh points are in sight.
    pub(super) visibility_rays: u64,
    /// Camera samples or meters that progress counts as done once these points have their light.
    pub(super) completes: u64,
    /// Rays that led to these points, for progress.
    pub(super) traced: u64,
}

/// A surface point with its irradiance, lux.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadedPoint {
    pub(super) point: ShadingPoint,
    pub(super) direct: Vec3,
    pub(super) indirect: Vec3,
}

impl PointBlock {
    /// Forgets all points and their indirect light.
    pub(super) fn clear(&mut self) {
        self.batch.vertices.clear();
        self.indirect.clear();
    }

    /// Tells progress how many samples or meters are done, and the rays that they took.
    pub(super) fn report(&self, reporter: &Reporter<'_>) {
        reporter.add(self.completes, self.traced + self.batch.rays());
    }

    /// Moves the counts of rays and fallbacks into the frame's.
    pub(super) fn take_counts(&mut self, stats: &mut RenderStats) {
        self.batch.take_counts(stats);
        stats.rays.secondary += std::mem::take(&mut self.visibility_rays);
    }

    /// The points with their light.
    pub(super) fn shaded_points(&self) -> impl Iterator<Item = ShadedPoint> {
        let direct = self.batch.vertices.iter().zip(&self.batch.direct);
        direct.enumerate().map(|(i, (&point, &direct))| {
            let indirect = self.indirect.get(i).copied().unwrap_or_default();
            ShadedPoint { point, direct, indirect }
        })
    }

    /// Marks the mesh points that the plan reads for these surface points and that are empty.
    pub(super) fn request_points(&self, scene: &Scene, plan: LightingPlan, mesh: &LightMesh, marks: &LightMarks) {
        let points = &self.batch.vertices;
        if plan.primary != Shading::Exact {
            mesh.direct.points().demand(scene, points, &marks.direct, CornerVisibility::All);
        }
        if let (Some(field), Some(marks), Indirect::Mesh { .. }) = (&mesh.indirect, &marks.indirect, plan.indirect) {
            field.points().demand(scene, points, marks, CornerVisibility::All);
        }
    }

    /// Lets every point wait for indirect light.
    pub(super) fn await_indirect(&mut self) {
        self.indirect.clear();
        self.indirect.resize(self.batch.vertices.len(), Vec3::ZERO);
        self.unresolved.clear();
        self.waiting.clear();
        self.waiting.extend(0..self.batch.vertices.len() as u32);
    }

    /// Lets every waiting point gather its indirect light itself.
    pub(super) fn gather_all(&mut self) {
        std::mem::swap(&mut self.unresolved, &mut self.waiting);
    }

    /// Reads the mesh for the points that wait; those whose mesh points are empty mark them and go on waiting.
    pub(super) fn read_indirect(&mut self, scene: &Scene, field: &IndirectField, bounces: u32, marks: &Marks) {
        let mut reader = field.reader(scene, bounces, CornerVisibility::All);
        let Self { waiting, batch, indirect, unresolved, .. } = self;
        waiting.retain(|&i| {
            match reader.read(&batch.vertices[i as usize], marks) {
                IndirectReading::Irradiance(irradiance) => indirect[i as usize] = irradiance,
                IndirectReading::Unavailable => unresolved.push(i),
                IndirectReading::Pending => return true,
            }
            false
        });
        self.visibility_rays += reader.visibility_rays();
    }

    /// Adds the points that have read the indirect mesh, once none waits, to those whose irradiance is to be corrected.
    pub(super) fn list_read_points<'a>(&'a mut self, near: &mut NearPoints<'a>) {
        let Self { batch, indirect, unresolved, .. } = self;
        let mut is_read = vec![true; indirect.len()];
        unresolved.iter().for_each(|&i| is_read[i as usize] = false);
        for ((point, irradiance), is_read) in batch.vertices.iter().zip(indirect).zip(is_read) {
            if is_read {
                near.points.push(*point);
                near.irradiance.push(irradiance);
            }
        }
    }

    /// The points that no point of the indirect mesh can serve.
    pub(super) fn unresolved(&self) -> impl Iterator<Item = &ShadingPoint> {
        self.unresolved.iter().map(|&i| &self.batch.vertices[i as usize])
    }
}
