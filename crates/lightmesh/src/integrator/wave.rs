//! Waves: camera rays → hits → light → film, and mirrored, refracted and passed-through rays as the next wave.

use std::ops::Range;
use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use super::direct::Scratch;
use super::surface::{Surface, Vertex, evaluate};
use crate::bvh::Hit;
use crate::film::{Film, Sample};
use crate::geometry::{Ray, offset_origin};
use crate::light_mesh::{LightMesh, Marks, Reading};
use crate::progress::Reporter;
use crate::{Error, Progress, RenderOptions, RenderStats, Scene, Stage};

/// Rays per block, the unit of parallel work: large enough for one SIMD dispatch, small enough to cancel quickly.
const BLOCK: usize = 512;

/// Blocks per wave: work for many threads, and buffers (about 250 B a ray) that stay near the cache.
const BLOCKS_PER_WAVE: usize = 128;

/// Rays per wave. A fixed number: the order in which a pixel's light is summed must not depend on the machine.
const WAVE: usize = BLOCK * BLOCKS_PER_WAVE;

/// BLEND and MASK layers that a ray may pass in a row.
pub(super) const MAX_LAYERS: u8 = 64;

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
    vertices: Vec<Vertex>,
    emitted: Vec<(u32, Vec3)>,
    next: Vec<WaveRay>,
    irradiance: Vec<Vec3>,
    /// Vertices that the mesh has not answered yet.
    waiting: Vec<u32>,
    scratch: Scratch,
    shadow_rays: u64,
    fallbacks: u64,
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
            stats.rays.shadow += std::mem::take(&mut block.shadow_rays);
            stats.exact_fallbacks += std::mem::take(&mut block.fallbacks);
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
    marks: Option<&mut Marks>,
    reporter: &Reporter<'_>,
    stats: &mut RenderStats,
) -> Result<(), Error> {
    let cancelled = || if reporter.cancelled() { Err(Error::Cancelled) } else { Ok(()) };
    cancelled()?;
    match (lighting, marks) {
        (Lighting::Mesh(mesh), Some(marks)) => {
            let started = Instant::now();
            blocks.par_iter_mut().for_each(|block| block.sum_unshadowed(scene, options));
            stats.seconds.shade += started.elapsed().as_secs_f64();
            // Demand and shade are one loop: what can be read is shaded, the rest waits for the fill.
            loop {
                let started = Instant::now();
                blocks.par_iter_mut().for_each(|block| block.shade_by_mesh(scene, options, mesh, marks));
                let waiting = blocks.iter().any(|block| !block.waiting.is_empty());
                let step = if waiting { &mut stats.seconds.demand } else { &mut stats.seconds.shade };
                *step += started.elapsed().as_secs_f64();
                if !waiting {
                    blocks.iter().for_each(|block| block.report(reporter));
                    break;
                }
                let started = Instant::now();
                let fill = mesh.fill(scene, marks)?;
                stats.rays.shadow += fill.shadow_rays;
                stats.rays.secondary += fill.probe_rays;
                reporter.add(0, fill.shadow_rays + fill.probe_rays);
                stats.seconds.fill_direct += started.elapsed().as_secs_f64();
                cancelled()?;
            }
        }
        _ => {
            let started = Instant::now();
            blocks.par_iter_mut().for_each(|block| {
                block.shade_exactly(scene, options, reporter);
                block.report(reporter);
            });
            stats.seconds.shade += started.elapsed().as_secs_f64();
        }
    }
    cancelled()
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
        reporter.add(if from_camera { rays } else { 0 }, rays + self.shadow_rays);
    }

    fn add_to(&self, film: &mut Film) {
        for &(pixel, radiance) in &self.emitted {
            film.add(pixel, radiance);
        }
        for (vertex, &irradiance) in self.vertices.iter().zip(&self.irradiance) {
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

        self.vertices.clear();
        self.emitted.clear();
        self.next.clear();
        for (from, hit) in self.input.iter().zip(&self.hits) {
            let Some(hit) = hit else { continue };
            let surface = evaluate(scene, &from.ray, hit);
            let beta = from.beta * surface.coverage;
            if surface.emission != Vec3::ZERO {
                self.emitted.push((from.pixel, beta * surface.emission));
            }
            if surface.diffuse != Vec3::ZERO {
                self.vertices.push(surface.vertex(beta, from.pixel));
            }
            spawn(&mut self.next, from, hit, &surface, options);
        }
    }

    fn shade_exactly(&mut self, scene: &Scene, options: &RenderOptions, reporter: &Reporter<'_>) {
        self.irradiance.clear();
        if reporter.cancelled() {
            return;
        }
        for vertex in &self.vertices {
            let (irradiance, rays) = self.scratch.irradiance(scene, options.falloff, vertex);
            self.irradiance.push(irradiance);
            self.shadow_rays += rays;
        }
    }

    /// Σ of formula (2), without visibility, for every vertex; those that face any light wait to be shaded.
    fn sum_unshadowed(&mut self, scene: &Scene, options: &RenderOptions) {
        let points = self.vertices.iter().map(|v| (v.position, v.n));
        scene.lights().irradiance(scene.level(), options.falloff, points, &mut self.irradiance);
        self.waiting.clear();
        let lit = |&i: &u32| self.irradiance[i as usize] != Vec3::ZERO;
        self.waiting.extend((0..self.vertices.len() as u32).filter(lit));
    }

    /// Formula (2) times formula (3g) for the vertices that wait; those whose mesh points are empty mark them and go on
    /// waiting.
    fn shade_by_mesh(&mut self, scene: &Scene, options: &RenderOptions, mesh: &LightMesh, marks: &Marks) {
        let mut reader = mesh.reader();
        let Self { waiting, vertices, irradiance, scratch, shadow_rays, fallbacks, .. } = self;
        waiting.retain(|&i| {
            let (vertex, irradiance) = (&vertices[i as usize], &mut irradiance[i as usize]);
            match reader.read(vertex, marks) {
                Reading::Visibility(visibility) => *irradiance *= visibility,
                Reading::Nothing => {
                    let (exact, rays) = scratch.irradiance(scene, options.falloff, vertex);
                    *irradiance = exact;
                    *shadow_rays += rays;
                    *fallbacks += 1;
                }
                Reading::Empty => return true,
            }
            false
        });
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
    pub(super) fn vertex(&self, beta: Vec3, pixel: u32) -> Vertex {
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
    pub(super) fn mirrored(&self, direction: Vec3) -> Vec3 {
        let d = direction.normalize();
        let about = |n: Vec3| d - n * (2.0 * n.dot(d));
        let mirrored = about(self.n);
        if mirrored.dot(self.ng) > 0.0 { mirrored } else { about(self.ng) }
    }

    /// A ray from the surface along `direction`.
    pub(super) fn leave(&self, direction: Vec3) -> Ray {
        Ray::new(offset_origin(self.position, self.ng, self.extent, direction), direction)
    }
}
