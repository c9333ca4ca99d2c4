//! Waves: camera rays → hits → light → film, and mirrored, refracted and passed-through rays as the next wave.

use std::time::Instant;

use rayon::prelude::*;

use super::adaptive::distance_levels::refine_by_distance;
use super::adaptive::error_bound::choose_plan;
use super::adaptive::refine::refine;
use super::block::{BLOCK, RayBlock, ShadedPoint, WaveRay};
use crate::direct::{DirectLighting, Indirect, LightingPlan, ShadingBatch};
use crate::film::{Film, RenderClock, SumOrder, WAVE, take_samples};
use crate::indirect::{GatherPaths, IndirectField};
use crate::interaction::ShadingPoint;
use crate::light_mesh::{LightMarks, LightMesh};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::{Error, RenderOptions, RenderStats, Scene, Stage};

/// Blocks per wave: work for many threads, and buffers (about 250 B a ray) that stay near the cache.
pub(super) const BLOCKS_PER_WAVE: usize = 128;

/// Rays that go on, per wave; as many as camera rays.
pub(super) const RAYS: usize = BLOCK * BLOCKS_PER_WAVE;
const _: () = assert!(RAYS as u64 == WAVE);

/// Where the light at a wave's hits comes from.
#[derive(Debug)]
pub(crate) enum Lighting<'a> {
    /// A shadow ray to every light sample.
    Exact,
    /// The mesh, filled as far as the hits ask for it.
    Mesh(&'a mut LightMesh),
}

/// What waves are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Light on the film.
    Light,
    /// Marks on the mesh points that the hits read and that are empty.
    Demand,
}

/// What a picture is made with.
pub(crate) struct WaveFrame<'a> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a RenderOptions,
    pub(super) lighting: Lighting<'a>,
    pub(crate) marks: Option<LightMarks>,
    blocks: Vec<RayBlock>,
    pub(crate) plan: LightingPlan,
    pub(crate) purpose: Purpose,
    /// Hits and their light, where somebody asks.
    pub(super) shaded_points: Option<Vec<ShadedPoint>>,
}

/// Renders the picture with exact or mesh light.
pub(crate) fn render_waves(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    lighting: Lighting<'_>,
    watch: &mut RenderClock<'_>,
) -> Result<RenderStats, Error> {
    let mut frame = WaveFrame::new(scene, options, lighting);
    let mut stats = RenderStats::default();
    frame.prepare(film, watch, &mut stats)?;
    let lamps = scene.has_lamps();
    if lamps {
        film.watch_lamps();
    }
    take_samples(film, options, SumOrder::Waves, watch, |film, watch, reporter| {
        frame.render_pass(film, watch, reporter, &mut stats)
    })?;
    if lamps && film.whole_passes() == options.picture.spp && film.turn_to_outlines(watch.samples_left()) {
        let reporter = Reporter::new(watch.progress, Stage::Outlines, film.sample_count());
        frame.render_pass(film, watch, &reporter, &mut stats)?;
    }
    Ok(stats)
}

impl<'a> WaveFrame<'a> {
    /// A frame that is lit as the method says.
    pub(crate) fn new(scene: &'a Scene, options: &'a RenderOptions, lighting: Lighting<'a>) -> Self {
        let marks = match &lighting {
            Lighting::Exact => None,
            Lighting::Mesh(mesh) => Some(mesh.marks()),
        };
        let blocks = (0..BLOCKS_PER_WAVE).map(|_| RayBlock::default()).collect();
        let (plan, purpose) = (LightingPlan::of(options), Purpose::Light);
        Self { scene, options, lighting, marks, blocks, plan, purpose, shaded_points: None }
    }

    /// Looks at the picture on the film, as far as the options want it: where meshes are to be finer, and how light is taken so that the
    /// error keeps to its bound.
    pub(crate) fn prepare(
        &mut self,
        film: &Film,
        watch: &mut RenderClock<'_>,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        if let Lighting::Mesh(mesh) = &mut self.lighting {
            mesh.reset_refinement();
        }
        refine_by_distance(self, film, stats);
        refine(self, film, watch, stats)?;
        if let Some(bound) = self.options.method.error() {
            stats.estimated_error = Some(choose_plan(self, film, bound, watch, stats)?);
        }
        Ok(())
    }

    /// Whether there is no indirect light in the picture.
    pub(super) fn is_direct(&self) -> bool {
        match &self.lighting {
            Lighting::Exact => true,
            Lighting::Mesh(mesh) => mesh.indirect.is_none(),
        }
    }

    /// Takes the samples of the film's pass.
    pub(crate) fn render_pass(
        &mut self,
        film: &mut Film,
        watch: &mut RenderClock<'_>,
        reporter: &Reporter<'_>,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        // Rays that go on from earlier waves. The youngest are taken first, so that there are never more than a few waves of
        // them for each mirror and refraction event.
        let mut queue: Vec<WaveRay> = Vec::new();
        while let Some(count) = watch.next_wave(film) {
            // Camera rays.
            let started = Instant::now();
            let (scene, options) = (self.scene, self.options);
            let used = count.div_ceil(BLOCK as u64) as usize;
            let (camera, first) = (&*film, film.done());
            self.blocks[..used].par_iter_mut().enumerate().for_each(|(i, block)| {
                let begin = first + (i * BLOCK) as u64;
                block.take_camera_rays(camera, begin..(begin + BLOCK as u64).min(first + count));
                block.trace(scene, options);
            });
            stats.rays.primary += count;
            stats.seconds.primary += started.elapsed().as_secs_f64();
            self.finish_wave(used, film, &mut queue, reporter, stats)?;

            // Those that go on.
            while !queue.is_empty() {
                let started = Instant::now();
                let rest = queue.len().saturating_sub(RAYS);
                let wave = &queue[rest..];
                let used = wave.len().div_ceil(BLOCK);
                stats.rays.secondary += wave.len() as u64;
                self.blocks[..used].par_iter_mut().zip(wave.par_chunks(BLOCK)).for_each(|(block, rays)| {
                    block.input.clear();
                    block.input.extend_from_slice(rays);
                    block.trace(scene, options);
                });
                queue.truncate(rest);
                stats.seconds.shade += started.elapsed().as_secs_f64();
                self.finish_wave(used, film, &mut queue, reporter, stats)?;
            }
            watch.wave_done(film, count);
        }
        Ok(())
    }

    /// Lights what the first `used` blocks have hit; light goes to the film and rays that go on to the queue, in order.
    fn finish_wave(
        &mut self,
        used: usize,
        film: &mut Film,
        queue: &mut Vec<WaveRay>,
        reporter: &Reporter<'_>,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        let blocks = &mut self.blocks[..used];
        if self.purpose == Purpose::Demand {
            let started = Instant::now();
            if let (Lighting::Mesh(mesh), Some(marks)) = (&self.lighting, &self.marks) {
                let mesh = &**mesh;
                blocks.par_iter_mut().for_each(|block| block.demand((self.scene, self.plan), mesh, marks));
            }
            blocks.iter().for_each(|block| block.report(reporter));
            blocks.iter_mut().for_each(|block| queue.append(&mut block.next));
            stats.seconds.demand += started.elapsed().as_secs_f64();
            return if reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) };
        }
        light((self.scene, self.options, self.plan), blocks, &mut self.lighting, self.marks.as_mut(), reporter, stats)?;
        let started = Instant::now();
        for block in blocks {
            if let Some(hits) = &mut self.shaded_points {
                hits.extend(block.shaded_points());
            }
            block.add_to(film);
            queue.append(&mut block.next);
            block.lit.take_counts(stats);
            stats.rays.secondary += std::mem::take(&mut block.visibility_rays);
        }
        stats.seconds.shade += started.elapsed().as_secs_f64();
        Ok(())
    }
}

/// Computes the irradiance at every vertex of the blocks.
pub(crate) fn light(
    (scene, options, plan): (&Scene, &RenderOptions, LightingPlan),
    blocks: &mut [RayBlock],
    lighting: &mut Lighting<'_>,
    marks: Option<&mut LightMarks>,
    reporter: &Reporter<'_>,
    stats: &mut RenderStats,
) -> Result<(), Error> {
    let cancelled = || if reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) };
    cancelled()?;
    match (lighting, marks) {
        (Lighting::Mesh(mesh), Some(marks)) => {
            let (field, direct_marks) = (&mut mesh.direct, &mut marks.direct);
            let mut direct = DirectLighting { scene, options, plan, field, marks: direct_marks, reporter, stats };
            let mut lists: Vec<&mut ShadingBatch> = blocks.iter_mut().map(|block| &mut block.lit).collect();
            let seconds = direct.light(CornerVisibility::All, &mut lists)?;
            let sum = &mut direct.stats.seconds;
            sum.demand += seconds.demand;
            sum.fill_direct += seconds.fill;
            sum.shade += seconds.shade;
            // A mesh for more bounces may serve none: then there is nothing to read but emission that gather rays find.
            let further = options.transport.bounces > 0 || scene.has_gathered_emitters();
            if let (Some(field), Some(marks), true) = (&mut mesh.indirect, &mut marks.indirect, further) {
                light_indirectly(field, marks, direct, blocks)?;
            }
            if !options.picture.aovs.is_empty() {
                let mesh = (&mesh.direct, &marks.direct);
                blocks.par_iter_mut().for_each(|block| {
                    block.visibility_rays += block.first_hits.read_mesh(scene, options, mesh, &block.lit.vertices);
                });
            }
            blocks.iter().for_each(|block| block.report(reporter));
        }
        _ => {
            let started = Instant::now();
            blocks.par_iter_mut().for_each(|block| {
                if !reporter.cancelled() {
                    block.lit.shade_exactly(scene, scene.emitters().all(), options.transport.falloff);
                }
                block.report(reporter);
            });
            stats.seconds.shade += started.elapsed().as_secs_f64();
        }
    }
    cancelled()
}

/// Adds the indirect irradiance, formula (6), at every vertex of the blocks.
fn light_indirectly(
    field: &mut IndirectField,
    marks: &mut Marks,
    mut direct: DirectLighting<'_, '_>,
    blocks: &mut [RayBlock],
) -> Result<(), Error> {
    let bounces = direct.options.transport.bounces;
    blocks.iter_mut().for_each(RayBlock::await_indirect);
    if direct.plan.indirect != Indirect::Mesh {
        blocks.iter_mut().for_each(RayBlock::gather_all);
    }
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
        field.fill(&mut direct, marks)?;
    }

    // Where nothing could be read, rays are gathered at the surface itself.
    let started = Instant::now();
    let orphans: Vec<ShadingPoint> = blocks.iter().flat_map(RayBlock::unresolved).copied().collect();
    let gathered = match direct.plan.indirect {
        Indirect::Mesh => {
            let seed = direct.options.seed;
            field.gather_at(&mut direct, marks, &orphans, (bounces, seed))?
        }
        Indirect::FinalGather { seed } => {
            let seed = direct.options.seed ^ seed << 32;
            field.gather_at(&mut direct, marks, &orphans, (bounces, seed))?
        }
        Indirect::Unbiased { rays, seed } => {
            field.estimate_at(&mut direct, marks, &orphans, GatherPaths { bounces, rays, seed })?
        }
    };
    if direct.plan.indirect == Indirect::Mesh {
        direct.stats.gather_fallbacks += orphans.len() as u64;
    }
    let mut gathered = gathered.into_iter();
    for block in blocks {
        for &i in &block.unresolved {
            block.indirect[i as usize] = gathered.next().unwrap_or_default();
        }
    }
    direct.stats.seconds.shade += started.elapsed().as_secs_f64();
    Ok(())
}
