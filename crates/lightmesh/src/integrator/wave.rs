//! Waves: camera rays → hits → light → film, and mirrored, refracted and passed-through rays as the next wave.

use std::ops::Range;
use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use super::lit::{DirectLighting, LitVertices};
use super::surface::{Surface, Vertex, evaluate};
use crate::bvh::Hit;
use crate::film::{Film, Sample};
use crate::geometry::{Ray, offset_origin};
use crate::light_mesh::{IndirectField, IndirectReading, LightMarks, LightMesh, Marks, Sight};
use crate::progress::Reporter;
use crate::{Error, Progress, RenderOptions, RenderStats, Scene, Stage};

/// Rays per block, the unit of parallel work: large enough for one SIMD dispatch, small enough to cancel quickly.
const BLOCK: usize = 512;

/// Blocks per wave: work for many threads, and buffers (about 250 B a ray) that stay near the cache.
const BLOCKS_PER_WAVE: usize = 128;

/// Rays per wave. A fixed number: the order in which a pixel's light is summed must not depend on the machine.
const WAVE: usize = BLOCK * BLOCKS_PER_WAVE;

/// BLEND and MASK layers that a ray may pass in a row.
pub(crate) const MAX_LAYERS: u8 = 64;

/// Where the light at a wave's hits comes from.
#[derive(Debug)]
pub(crate) enum Lighting<'a> {
    /// A shadow ray to every light sample.
    Exact,
    /// The mesh, filled as far as the hits ask for it.
    Mesh(&'a mut LightMesh),
}

/// A ray with what it carries.
#[derive(Clone, Copy, Debug)]
struct WaveRay {
    ray: Ray,
    /// Throughput: radiance at the film per unit of radiance along the ray.
    beta: Vec3,
    pixel: u32,
    /// Mirror and refraction events so far.
    depth: u32,
    /// Layers passed since the last event.
    layers: u8,
}

/// Up to [`BLOCK`] rays, what they hit and what came of it; buffers are kept from wave to wave.
#[derive(Debug, Default)]
struct Block {
    input: Vec<WaveRay>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    lit: LitVertices,
    /// Indirect irradiance of each vertex, lux; empty where there is none.
    indirect: Vec<Vec3>,
    /// Vertices that the indirect mesh has not answered yet, and those that it has no answer for.
    waiting: Vec<u32>,
    orphans: Vec<u32>,
    sight_rays: u64,
    emitted: Vec<(u32, Vec3)>,
    next: Vec<WaveRay>,
}

/// Renders all samples of the film with exact or mesh light.
pub(crate) fn render_waves(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    mut lighting: Lighting<'_>,
    progress: &dyn Progress,
) -> Result<RenderStats, Error> {
    let mut stats = RenderStats::default();
    let mut blocks: Vec<Block> = (0..BLOCKS_PER_WAVE).map(|_| Block::default()).collect();
    let mut marks = match &lighting {
        Lighting::Exact => None,
        Lighting::Mesh(mesh) => Some(mesh.marks()),
    };
    let total = film.sample_count();
    let reporter = Reporter::new(progress, Stage::Render, total);
    let mut first = 0;
    // Rays that go on from earlier waves. The youngest are taken first, so that there are never more than a few waves of
    // them for each mirror and refraction event.
    let mut queue: Vec<WaveRay> = Vec::new();
    while first < total || !queue.is_empty() {
        // Camera rays, or the next of those that go on.
        let started = Instant::now();
        let used;
        if queue.is_empty() {
            let count = (total - first).min(WAVE as u64);
            used = count.div_ceil(BLOCK as u64) as usize;
            let camera = &*film;
            blocks[..used].par_iter_mut().enumerate().for_each(|(i, block)| {
                let begin = first + (i * BLOCK) as u64;
                block.take_camera_rays(camera, begin..(begin + BLOCK as u64).min(first + count));
                block.trace(scene, options);
            });
            first += count;
            stats.rays.primary += count;
            stats.seconds.primary += started.elapsed().as_secs_f64();
        } else {
            let rest = queue.len().saturating_sub(WAVE);
            let wave = &queue[rest..];
            used = wave.len().div_ceil(BLOCK);
            stats.rays.secondary += wave.len() as u64;
            blocks[..used].par_iter_mut().zip(wave.par_chunks(BLOCK)).for_each(|(block, rays)| {
                block.input.clear();
                block.input.extend_from_slice(rays);
                block.trace(scene, options);
            });
            queue.truncate(rest);
            stats.seconds.shade += started.elapsed().as_secs_f64();
        }

        light(scene, &mut blocks[..used], options, &mut lighting, marks.as_mut(), &reporter, &mut stats)?;

        // To the film and the queue, in order.
        let started = Instant::now();
        for block in &mut blocks[..used] {
            block.add_to(film);
            queue.append(&mut block.next);
            block.lit.take_counts(&mut stats);
            stats.rays.secondary += std::mem::take(&mut block.sight_rays);
        }
        stats.seconds.shade += started.elapsed().as_secs_f64();
    }
    Ok(stats)
}

/// Computes the irradiance at every vertex of the blocks.
fn light(
    scene: &Scene,
    blocks: &mut [Block],
    options: &RenderOptions,
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
            let mut direct = DirectLighting { scene, options, field, marks: direct_marks, reporter, stats };
            let mut lists: Vec<&mut LitVertices> = blocks.iter_mut().map(|block| &mut block.lit).collect();
            let seconds = direct.light(Sight::Every, &mut lists)?;
            let sum = &mut direct.stats.seconds;
            sum.demand += seconds.demand;
            sum.fill_direct += seconds.fill;
            sum.shade += seconds.shade;
            if let (Some(field), Some(marks)) = (&mut mesh.indirect, &mut marks.indirect) {
                light_indirectly(field, marks, direct, blocks)?;
            }
            blocks.iter().for_each(|block| block.report(reporter));
        }
        _ => {
            let started = Instant::now();
            blocks.par_iter_mut().for_each(|block| {
                if !reporter.cancelled() {
                    block.lit.shade_exactly(scene, options.falloff);
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
    blocks: &mut [Block],
) -> Result<(), Error> {
    let bounces = direct.options.bounces;
    blocks.iter_mut().for_each(Block::await_indirect);
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
    let orphans: Vec<Vertex> = blocks.iter().flat_map(Block::orphans).copied().collect();
    let gathered = field.gather_at(&mut direct, marks, &orphans, bounces)?;
    direct.stats.gather_fallbacks += orphans.len() as u64;
    let mut gathered = gathered.into_iter();
    for block in blocks {
        for &i in &block.orphans {
            block.indirect[i as usize] = gathered.next().unwrap_or_default();
        }
    }
    direct.stats.seconds.shade += started.elapsed().as_secs_f64();
    Ok(())
}

impl Block {
    fn take_camera_rays(&mut self, film: &Film, samples: Range<u64>) {
        self.input.clear();
        self.input.extend(film.samples(samples).map(|sample: Sample| {
            let ray = film.ray(sample);
            WaveRay { ray, beta: Vec3::ONE, pixel: sample.pixel, depth: 0, layers: 0 }
        }));
    }

    /// Counts the rays of a finished block, and its samples if they are camera rays.
    fn report(&self, reporter: &Reporter<'_>) {
        let from_camera = self.input.first().is_some_and(|ray| ray.depth == 0 && ray.layers == 0);
        let rays = self.input.len() as u64;
        reporter.add(if from_camera { rays } else { 0 }, rays + self.lit.rays());
    }

    fn add_to(&self, film: &mut Film) {
        for &(pixel, radiance) in &self.emitted {
            film.add(pixel, radiance);
        }
        for (vertex, &irradiance) in self.lit.vertices.iter().zip(&self.lit.direct) {
            film.add(vertex.pixel, vertex.weight * irradiance);
        }
        for (vertex, &irradiance) in self.lit.vertices.iter().zip(&self.indirect) {
            film.add(vertex.pixel, vertex.weight * irradiance);
        }
    }

    /// Traces the input rays and evaluates what they hit.
    fn trace(&mut self, scene: &Scene, options: &RenderOptions) {
        self.rays.clear();
        self.rays.extend(self.input.iter().map(|r| r.ray));
        self.hits.clear();
        self.hits.resize(self.rays.len(), None);
        scene.bvh().closest_batch(&self.rays, &mut self.hits);

        self.lit.vertices.clear();
        self.indirect.clear();
        self.emitted.clear();
        self.next.clear();
        for (from, hit) in self.input.iter().zip(&self.hits) {
            let Some(hit) = hit else {
                let sky = scene.environment(from.ray.direction.normalize());
                if sky != Vec3::ZERO {
                    self.emitted.push((from.pixel, from.beta * sky));
                }
                continue;
            };
            let surface = evaluate(scene, &from.ray, hit);
            let beta = from.beta * surface.coverage;
            if surface.emission != Vec3::ZERO {
                self.emitted.push((from.pixel, beta * surface.emission));
            }
            if surface.diffuse != Vec3::ZERO {
                self.lit.vertices.push(surface.vertex(beta, from.pixel));
            }
            spawn(&mut self.next, from, hit, &surface, options);
        }
    }

    /// Lets every vertex wait for indirect light.
    fn await_indirect(&mut self) {
        self.indirect.clear();
        self.indirect.resize(self.lit.vertices.len(), Vec3::ZERO);
        self.orphans.clear();
        self.waiting.clear();
        self.waiting.extend(0..self.lit.vertices.len() as u32);
    }

    /// Reads the mesh for the vertices that wait; those whose points are empty mark them and go on waiting.
    fn read_indirect(&mut self, scene: &Scene, field: &IndirectField, bounces: u32, marks: &Marks) {
        let mut reader = field.reader(scene, bounces, Sight::Every);
        let Self { waiting, lit, indirect, orphans, .. } = self;
        waiting.retain(|&i| {
            match reader.read(&lit.vertices[i as usize], marks) {
                IndirectReading::Irradiance(irradiance) => indirect[i as usize] = irradiance,
                IndirectReading::Nothing => orphans.push(i),
                IndirectReading::Empty => return true,
            }
            false
        });
        self.sight_rays += reader.sight_rays();
    }

    /// The vertices that the indirect mesh has no answer for.
    fn orphans(&self) -> impl Iterator<Item = &Vertex> {
        self.orphans.iter().map(|&i| &self.lit.vertices[i as usize])
    }
}

/// The rays that go on from a surface: through it, mirrored and refracted.
fn spawn(next: &mut Vec<WaveRay>, from: &WaveRay, hit: &Hit, surface: &Surface, options: &RenderOptions) {
    if surface.coverage < 1.0 && from.layers < MAX_LAYERS {
        let beta = from.beta * (1.0 - surface.coverage);
        if beta.max_element() > options.cutoff {
            let ray = Ray { t_min: hit.t, ..from.ray };
            next.push(WaveRay { ray, beta, layers: from.layers + 1, ..*from });
        }
    }
    if from.depth >= options.depth {
        return;
    }
    let mut follow = |weight: Vec3, direction: Vec3| {
        let beta = from.beta * surface.coverage * weight;
        if beta.max_element() > options.cutoff {
            let ray = surface.leave(direction);
            next.push(WaveRay { ray, beta, pixel: from.pixel, depth: from.depth + 1, layers: 0 });
        }
    };
    if surface.mirror != Vec3::ZERO {
        follow(surface.mirror, surface.mirrored(from.ray.direction));
    }
    if surface.refraction != Vec3::ZERO {
        follow(surface.refraction, surface.refracted);
    }
}

impl Surface {
    /// The surface as a vertex that wants light, reached with throughput `beta`.
    pub(crate) fn vertex(&self, beta: Vec3, pixel: u32) -> Vertex {
        Vertex {
            position: self.position,
            n: self.n,
            ng: self.ng,
            extent: self.extent,
            weight: beta * self.diffuse * std::f32::consts::FRAC_1_PI,
            pixel,
        }
    }

    /// The mirror direction of an arriving `direction`; about the geometric normal where the shading normal would send it
    /// into the surface.
    pub(crate) fn mirrored(&self, direction: Vec3) -> Vec3 {
        let d = direction.normalize();
        let about = |n: Vec3| d - n * (2.0 * n.dot(d));
        let mirrored = about(self.n);
        if mirrored.dot(self.ng) > 0.0 { mirrored } else { about(self.ng) }
    }

    /// A ray from the surface along `direction`.
    pub(crate) fn leave(&self, direction: Vec3) -> Ray {
        Ray::new(offset_origin(self.position, self.ng, self.extent, direction), direction)
    }
}
