//! Lighting surface points, by exact shadow rays or from the mesh, which is filled as far as they read it.

use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use super::point_block::PointBlock;
use crate::direct::{DirectLighting, Indirect, LightingPlan, ShadingBatch};
use crate::indirect::{GatherPaths, GoOn, IndirectField, Marked, NearPoints, NearRays};
use crate::interaction::ShadingPoint;
use crate::light_mesh::{LightMarks, LightMesh};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::{Error, RenderOptions, RenderStats, Scene};

/// Where the light at surface points comes from.
pub(crate) enum Lighting<'a> {
    /// A shadow ray to every light sample.
    Exact,
    /// The mesh, filled as far as surface points read it.
    Mesh {
        mesh: &'a mut LightMesh,
        /// Its points that are to be filled next.
        marks: LightMarks,
    },
}

/// What does not change while points are lit.
#[derive(Clone, Copy)]
pub(super) struct LightingContext<'a> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a RenderOptions,
    pub(super) plan: LightingPlan,
    pub(super) reporter: &'a Reporter<'a>,
}

impl<'a> Lighting<'a> {
    /// Light from a mesh.
    pub(crate) fn from_mesh(mesh: &'a mut LightMesh) -> Self {
        let marks = mesh.marks();
        Self::Mesh { mesh, marks }
    }

    /// Whether surfaces get indirect light.
    pub(super) fn has_indirect(&self) -> bool {
        match self {
            Self::Exact => false,
            Self::Mesh { mesh, .. } => mesh.indirect.is_some(),
        }
    }

    /// Computes direct and indirect irradiance at every point of the blocks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(super) fn shade(
        &mut self,
        context: LightingContext<'_>,
        blocks: &mut [&mut PointBlock],
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        context.check_cancelled()?;
        match self {
            Self::Exact => shade_exactly(context, blocks, stats),
            Self::Mesh { mesh, marks } => shade_from_mesh(context, mesh, marks, blocks, stats)?,
        }
        context.check_cancelled()
    }
}

impl LightingContext<'_> {
    fn check_cancelled(&self) -> Result<(), Error> {
        if self.reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }
}

/// Computes the direct light of every point with a shadow ray to each light sample; there is no indirect light.
fn shade_exactly(context: LightingContext<'_>, blocks: &mut [&mut PointBlock], stats: &mut RenderStats) {
    let started = Instant::now();
    let LightingContext { scene, options, reporter, .. } = context;
    blocks.par_iter_mut().for_each(|block| {
        if !reporter.cancelled() {
            let falloff = options.transport.falloff;
            block.batch.shade_exactly(scene, scene.emitters().all(), falloff, options.seed);
            block.batch.add_mirrored(scene, falloff, CornerVisibility::All);
        }
        block.report(reporter);
    });
    stats.seconds.shade += started.elapsed().as_secs_f64();
}

/// Lights every point as the plan says, from meshes that are filled on the way.
fn shade_from_mesh(
    context: LightingContext<'_>,
    mesh: &mut LightMesh,
    marks: &mut LightMarks,
    blocks: &mut [&mut PointBlock],
    stats: &mut RenderStats,
) -> Result<(), Error> {
    let LightingContext { scene, options, plan, reporter } = context;
    let (field, direct_marks) = (&mut mesh.direct, &mut marks.direct);
    let mut direct = DirectLighting { scene, options, plan, field, marks: direct_marks, reporter, stats };

    // Direct light.
    let mut batches: Vec<&mut ShadingBatch> = blocks.iter_mut().map(|block| &mut block.batch).collect();
    let seconds = direct.shade(CornerVisibility::All, &mut batches)?;
    let sum = &mut direct.stats.seconds;
    sum.demand += seconds.demand;
    sum.fill_direct += seconds.fill;
    sum.shade += seconds.shade;

    // Indirect light. A mesh for more bounces may serve none: what is left to read then is emission that gather rays
    // find.
    let has_indirect =
        plan.indirect != Indirect::None && (options.transport.bounces > 0 || scene.has_unsampled_emitters());
    if let (Some(field), Some(marks), true) = (&mut mesh.indirect, &mut marks.indirect, has_indirect) {
        add_indirect(field, marks, direct, blocks)?;
    }
    blocks.iter().for_each(|block| block.report(reporter));
    Ok(())
}

/// Computes the indirect irradiance, formula (6), at every point of the blocks.
fn add_indirect(
    field: &mut IndirectField,
    marks: &mut Marks,
    mut direct: DirectLighting<'_, '_>,
    blocks: &mut [&mut PointBlock],
) -> Result<(), Error> {
    let (bounces, seed) = (direct.options.transport.bounces, direct.options.seed);
    blocks.iter_mut().for_each(|block| block.await_indirect());
    if !matches!(direct.plan.indirect, Indirect::Mesh { .. }) {
        blocks.iter_mut().for_each(|block| block.gather_all());
    }

    // Read the mesh and fill it, until no point waits.
    loop {
        let started = Instant::now();
        let (scene, readable) = (direct.scene, &*field);
        blocks.par_iter_mut().for_each(|block| block.read_indirect(scene, readable, bounces, marks));
        let waiting = blocks.iter().any(|block| !block.waiting.is_empty());
        let seconds = &mut direct.stats.seconds;
        let step = if waiting { &mut seconds.demand } else { &mut seconds.shade };
        *step += started.elapsed().as_secs_f64();
        if !waiting {
            break;
        }
        field.fill(&mut direct, marks, Marked::ToRead)?;
    }

    // Correct what was read where surfaces are near.
    if let Indirect::Mesh { near_rays: count @ 1.. } = direct.plan.indirect {
        let started = Instant::now();
        let mut near = NearPoints::default();
        blocks.iter_mut().for_each(|block| block.list_read_points(&mut near));
        field.correct_near(&mut direct, marks, near, NearRays { count, bounces })?;
        direct.stats.seconds.shade += started.elapsed().as_secs_f64();
    }

    // Gather rays at the surface itself, where the plan wants that or nothing could be read.
    let started = Instant::now();
    let unresolved: Vec<ShadingPoint> = blocks.iter().flat_map(|block| block.unresolved()).copied().collect();
    let irradiance = match direct.plan.indirect {
        Indirect::None | Indirect::Mesh { .. } => {
            direct.stats.gather_fallbacks += unresolved.len() as u64;
            field.gather_without_mesh(&mut direct, marks, &unresolved, bounces, seed)?
        }
        Indirect::FinalGather { rays, seed: other } => {
            let paths = GatherPaths { bounces, rays, seed: seed ^ other << 32, go_on: GoOn::WithoutMesh };
            field.estimate_unbiased(&mut direct, marks, &unresolved, paths)?
        }
        Indirect::Unbiased { rays, seed } => {
            let paths = GatherPaths { bounces, rays, seed, go_on: GoOn::Everywhere };
            field.estimate_unbiased(&mut direct, marks, &unresolved, paths)?
        }
    };
    // What a ray corrects may be more than is there: that is noise, and the expectation needs it.
    let is_unbiased = matches!(direct.plan.indirect, Indirect::Unbiased { .. });
    let least = if is_unbiased { Vec3::NEG_INFINITY } else { Vec3::ZERO };
    let mut irradiance = irradiance.into_iter();
    for block in blocks {
        for &i in &block.unresolved {
            block.indirect[i as usize] = irradiance.next().unwrap_or_default().max(least);
        }
    }
    direct.stats.seconds.shade += started.elapsed().as_secs_f64();
    Ok(())
}
