//! Waves: camera rays → hits → light → sink, and mirrored, refracted and passed-through rays as the next wave.

use std::time::Instant;

use rayon::prelude::*;

use super::block::{BLOCK, RayBlock, WaveRay};
use super::lighting::{Lighting, LightingContext};
use super::point_block::{PointBlock, ShadedPoint};
use crate::direct::LightingPlan;
use crate::film::{Film, NoiseBound, RenderClock, SumOrder, WAVE, take_more_samples, take_samples};
use crate::light_mesh::LightMarks;
use crate::progress::Reporter;
use crate::{Error, RenderOptions, RenderStats, Scene, Stage};

/// Blocks per wave: work for many threads, and buffers (about 250 B a ray) that stay near the cache.
pub(super) const BLOCKS_PER_WAVE: usize = 128;

/// Rays that go on, per wave; as many as camera rays.
pub(super) const RAYS: usize = BLOCK * BLOCKS_PER_WAVE;
const _: () = assert!(RAYS as u64 == WAVE);

/// The error by noise that is enough: what the rest of the error leaves of the bound, but not less and not more than these
/// parts of it. Measured: docs/near-light.md.
const NOISE_SHARES: (f64, f64) = (0.4, 0.6);

/// The error by noise where no bound is given, and how many times the first samples may then be added to. A judgement: noise that
/// is everywhere takes a better way to find light, not a picture that takes an hour.
const DEFAULT_NOISE: f64 = 0.025;
const MOST_MORE: u64 = 3;

/// What becomes of a wave.
pub(crate) enum WaveSink<'a> {
    /// Its surface points are lit, and their light is added to the film.
    Film,
    /// Its surface points are lit and appended to a list; the film gets no light.
    ShadedPoints(&'a mut Vec<ShadedPoint>),
    /// Its surface points mark the mesh points that they read and that are empty; nothing is lit.
    Requests(&'a LightMarks),
}

/// A scene with its lighting, from which pictures are drawn wave by wave.
pub(crate) struct WaveFrame<'a> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a RenderOptions,
    pub(super) lighting: Lighting<'a>,
    blocks: Vec<RayBlock>,
}

impl<'a> WaveFrame<'a> {
    /// A frame without any picture yet.
    pub(crate) fn new(scene: &'a Scene, options: &'a RenderOptions, lighting: Lighting<'a>) -> Self {
        let blocks = (0..BLOCKS_PER_WAVE).map(|_| RayBlock::default()).collect();
        Self { scene, options, lighting, blocks }
    }

    /// Draws the whole picture: every sample of every pixel, then the edges of emitters once more, more finely.
    ///
    /// # Errors
    /// As [`WaveFrame::draw`].
    pub(crate) fn draw_picture(
        &mut self,
        film: &mut Film,
        plan: LightingPlan,
        clock: &mut RenderClock<'_>,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        let (options, sees_emitters) = (self.options, self.scene.has_visible_emitters());
        if sees_emitters {
            film.watch_emitters();
        }
        take_samples(film, options, SumOrder::Waves, clock, |film, clock, reporter| {
            self.draw(film, plan, WaveSink::Film, clock, reporter, stats)
        })?;
        let complete = film.whole_passes() == options.picture.spp;
        if sees_emitters && complete && film.begin_emitter_edges(clock.samples_left()) {
            let reporter = Reporter::new(clock.progress, Stage::EmitterEdges, film.sample_count());
            self.draw(film, plan, WaveSink::Film, clock, &reporter, stats)?;
        }
        if let Some(most_spp) = options.most_spp() {
            let bound = noise_bound(most_spp, film, options, stats.estimated_error);
            let error = take_more_samples(film, bound, clock, |film, clock, reporter| {
                let plan = plan.with_samples(options, film.samples_of_pixel());
                self.draw(film, plan, WaveSink::Film, clock, reporter, stats)
            })?;
            stats.sampling_error = Some(error);
            if let Some(all) = &mut stats.estimated_error {
                *all = all.hypot(error);
            }
            if let Some(estimate) = &mut stats.error_estimate {
                estimate.all = estimate.all.hypot(error);
            }
        }
        Ok(())
    }

    /// Takes the samples of the film's pass, lit as the plan says; what becomes of them is up to the sink.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(crate) fn draw(
        &mut self,
        film: &mut Film,
        plan: LightingPlan,
        mut sink: WaveSink<'_>,
        clock: &mut RenderClock<'_>,
        reporter: &Reporter<'_>,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        let (scene, options) = (self.scene, self.options);
        let context = LightingContext { scene, options, plan, reporter };
        // Rays that go on from earlier waves. The youngest are taken first, so that there are never more than a few
        // waves of them for each mirror and refraction event.
        let mut queue: Vec<WaveRay> = Vec::new();
        while let Some(count) = clock.next_wave(film) {
            // Trace camera rays.
            let started = Instant::now();
            let used = count.div_ceil(BLOCK as u64) as usize;
            let (camera, first) = (&*film, film.done());
            self.blocks[..used].par_iter_mut().enumerate().for_each(|(i, block)| {
                let begin = first + (i * BLOCK) as u64;
                block.take_camera_rays(camera, begin..(begin + BLOCK as u64).min(first + count));
                block.trace(scene, options);
            });
            stats.rays.primary += count;
            stats.seconds.primary += started.elapsed().as_secs_f64();
            self.finish_wave(context, used, film, &mut sink, &mut queue, stats)?;

            // Trace the rays that go on, wave by wave, until none is left.
            while !queue.is_empty() {
                let started = Instant::now();
                let rest = queue.len().saturating_sub(RAYS);
                let wave = &queue[rest..];
                let used = wave.len().div_ceil(BLOCK);
                stats.rays.secondary += wave.len() as u64;
                self.blocks[..used].par_iter_mut().zip(wave.par_chunks(BLOCK)).for_each(|(block, rays)| {
                    block.take_rays(rays);
                    block.trace(scene, options);
                });
                queue.truncate(rest);
                stats.seconds.shade += started.elapsed().as_secs_f64();
                self.finish_wave(context, used, film, &mut sink, &mut queue, stats)?;
            }
            clock.wave_done(film, count);
        }
        Ok(())
    }

    /// Hands what the first `used` blocks have hit to the sink, and appends the rays that go on to the queue, both in
    /// the order of the blocks.
    fn finish_wave(
        &mut self,
        context: LightingContext<'_>,
        used: usize,
        film: &mut Film,
        sink: &mut WaveSink<'_>,
        queue: &mut Vec<WaveRay>,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        match sink {
            WaveSink::Requests(marks) => self.request_points(context, used, marks, stats)?,
            WaveSink::Film => {
                self.shade(context, used, stats)?;
                let started = Instant::now();
                self.blocks[..used].iter().for_each(|block| block.add_to(film));
                stats.seconds.shade += started.elapsed().as_secs_f64();
            }
            WaveSink::ShadedPoints(list) => {
                self.shade(context, used, stats)?;
                self.blocks[..used].iter().for_each(|block| list.extend(block.points.shaded_points()));
            }
        }
        for block in &mut self.blocks[..used] {
            queue.append(&mut block.next);
            block.points.take_counts(stats);
        }
        Ok(())
    }

    /// Lights the points of the first `used` blocks, and looks up what the picture's layers show of the mesh.
    fn shade(&mut self, context: LightingContext<'_>, used: usize, stats: &mut RenderStats) -> Result<(), Error> {
        let blocks = &mut self.blocks[..used];
        let mut points: Vec<&mut PointBlock> = blocks.iter_mut().map(|block| &mut block.points).collect();
        self.lighting.shade(context, &mut points, stats)?;
        if let (Lighting::Mesh { mesh, marks }, false) = (&self.lighting, context.options.picture.aovs.is_empty()) {
            let (field, marks) = (&mesh.direct, &marks.direct);
            blocks.par_iter_mut().for_each(|block| {
                let points = &mut block.points;
                points.visibility_rays +=
                    block.first_hits.read_mesh(context.scene, context.options, field, marks, &points.batch.vertices);
            });
        }
        Ok(())
    }

    /// Marks the mesh points that the first `used` blocks read and that are empty.
    fn request_points(
        &self,
        context: LightingContext<'_>,
        used: usize,
        marks: &LightMarks,
        stats: &mut RenderStats,
    ) -> Result<(), Error> {
        let started = Instant::now();
        let LightingContext { scene, plan, reporter, .. } = context;
        if let Lighting::Mesh { mesh, .. } = &self.lighting {
            let mesh = &**mesh;
            self.blocks[..used].par_iter().for_each(|block| block.points.request_points(scene, plan, mesh, marks));
        }
        self.blocks[..used].iter().for_each(|block| block.points.report(reporter));
        stats.seconds.demand += started.elapsed().as_secs_f64();
        if reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }
}

/// How much noise a picture may have whose other error is `rest`.
fn noise_bound(most_spp: u32, film: &Film, options: &RenderOptions, rest: Option<f64>) -> NoiseBound {
    let Some(bound) = options.method.error().map(f64::from) else {
        let most = MOST_MORE * film.pixel_count() * u64::from(options.picture.spp);
        return NoiseBound { most_spp, error: DEFAULT_NOISE, most };
    };
    let left = (bound * bound - rest.map_or(0.0, |rest| rest * rest)).max(0.0).sqrt();
    let (least, most) = (NOISE_SHARES.0 * bound, NOISE_SHARES.1 * bound);
    NoiseBound { most_spp, error: left.clamp(least, most), most: u64::MAX }
}
