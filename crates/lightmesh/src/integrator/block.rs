//! A block of a wave: up to 512 rays, what they hit, and what came of it.

use std::ops::Range;

use glam::Vec3;

use super::first_hits::FirstHits;
use crate::bvh::Hit;
use crate::direct::{Indirect, LightingPlan, Shading, ShadingBatch};
use crate::film::{Film, Sample};
use crate::geometry::{Cone, Ray};
use crate::indirect::{IndirectField, IndirectReading};
use crate::interaction::{MAX_TRANSPARENT_HITS, ShadedHit, ShadingPoint, evaluate_footprint};
use crate::light_mesh::{LightMarks, LightMesh};
use crate::mesh::{CornerVisibility, Marks};
use crate::progress::Reporter;
use crate::{Aov, RenderOptions, Scene};

/// Rays per block, the unit of parallel work: large enough for one SIMD dispatch, small enough to cancel quickly.
pub(super) const BLOCK: usize = 512;

/// A ray with what it carries.
#[derive(Clone, Copy, Debug)]
pub(super) struct WaveRay {
    ray: Ray,
    /// What it stands for.
    cone: Cone,
    /// Throughput: radiance at the film per unit of radiance along the ray.
    beta: Vec3,
    pixel: u32,
    /// Mirror and refraction events so far.
    depth: u32,
    /// Layers passed since the last event.
    transparent_hits: u8,
}

/// Up to [`BLOCK`] rays, what they hit and what came of it; buffers are kept from wave to wave.
#[derive(Debug, Default)]
pub(super) struct RayBlock {
    pub(super) input: Vec<WaveRay>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    pub(super) lit: ShadingBatch,
    /// Indirect irradiance of each vertex, lux; empty where there is none.
    pub(super) indirect: Vec<Vec3>,
    /// Vertices that the indirect mesh has not answered yet, and those that it has no answer for.
    pub(super) waiting: Vec<u32>,
    pub(super) unresolved: Vec<u32>,
    pub(super) visibility_rays: u64,
    emitted: Vec<(u32, Vec3)>,
    /// Whether each camera ray saw a lamp; empty where nobody asks.
    emitter_seen: Vec<(u32, bool)>,
    /// What the camera rays met; empty where nobody asks.
    pub(super) first_hits: FirstHits,
    pub(super) next: Vec<WaveRay>,
}

/// A hit with its irradiance, lux.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadedPoint {
    pub vertex: ShadingPoint,
    pub direct: glam::Vec3,
    pub indirect: glam::Vec3,
}

impl RayBlock {
    pub(super) fn take_camera_rays(&mut self, film: &Film, samples: Range<u64>) {
        self.input.clear();
        self.input.extend(film.samples(samples).map(|sample: Sample| {
            let (ray, cone) = film.ray(sample);
            WaveRay { ray, cone, beta: Vec3::ONE, pixel: sample.pixel, depth: 0, transparent_hits: 0 }
        }));
    }

    /// Counts the rays of a finished block, and its samples if they are camera rays or meters, which no ray has led to.
    pub(super) fn report(&self, reporter: &Reporter<'_>) {
        let rays = self.input.len() as u64;
        let done = match self.input.first() {
            None => self.lit.vertices.len() as u64,
            Some(ray) if ray.depth == 0 && ray.transparent_hits == 0 => rays,
            Some(_) => 0,
        };
        reporter.add(done, rays + self.lit.rays());
    }

    /// The vertices with their light.
    pub(super) fn shaded_points(&self) -> impl Iterator<Item = ShadedPoint> {
        let direct = self.lit.vertices.iter().zip(&self.lit.direct);
        direct.enumerate().map(|(i, (&vertex, &direct))| {
            let indirect = self.indirect.get(i).copied().unwrap_or_default();
            ShadedPoint { vertex, direct, indirect }
        })
    }

    pub(super) fn add_to(&self, film: &mut Film) {
        for &(pixel, lamp) in &self.emitter_seen {
            film.saw(pixel, lamp);
        }
        for &(pixel, radiance) in &self.emitted {
            film.add(pixel, radiance);
        }
        for (vertex, &irradiance) in self.lit.vertices.iter().zip(&self.lit.direct) {
            film.add(vertex.pixel, vertex.weight * irradiance);
        }
        for (vertex, &irradiance) in self.lit.vertices.iter().zip(&self.indirect) {
            film.add(vertex.pixel, vertex.weight * irradiance);
        }
        if film.has_layers() {
            self.add_layers_to(film);
        }
    }

    /// Adds what the film's layers want of it: of what was added to the film above, once more, which is what.
    fn add_layers_to(&self, film: &mut Film) {
        let layers = film.layers();
        for &(pixel, radiance) in &self.emitted {
            layers.add(Aov::Direct, pixel, radiance);
        }
        for (aov, irradiances) in [(Aov::Direct, &self.lit.direct), (Aov::Indirect, &self.indirect)] {
            for (vertex, &irradiance) in self.lit.vertices.iter().zip(irradiances) {
                layers.add(aov, vertex.pixel, vertex.weight * irradiance);
            }
        }
        self.first_hits.add_to(film);
    }

    /// Traces the input rays and evaluates what they hit.
    pub(super) fn trace(&mut self, scene: &Scene, options: &RenderOptions) {
        self.rays.clear();
        self.rays.extend(self.input.iter().map(|r| r.ray));
        self.hits.clear();
        self.hits.resize(self.rays.len(), None);
        scene.bvh().closest_batch(&self.rays, &mut self.hits);

        self.lit.vertices.clear();
        self.indirect.clear();
        self.emitted.clear();
        self.next.clear();
        self.emitter_seen.clear();
        self.first_hits.clear();
        let (watched, layered) = (scene.has_lamps(), !options.picture.aovs.is_empty());
        for (from, hit) in self.input.iter().zip(&self.hits) {
            let first = watched && from.depth == 0 && from.transparent_hits == 0;
            let Some(hit) = hit else {
                let sky = scene.environment(from.ray.direction.normalize());
                if first {
                    self.emitter_seen.push((from.pixel, sky != Vec3::ZERO));
                }
                if sky != Vec3::ZERO {
                    self.emitted.push((from.pixel, from.beta * sky));
                }
                continue;
            };
            let surface = evaluate_footprint(scene, &from.ray, from.cone, hit);
            let beta = from.beta * surface.opacity;
            if first {
                self.emitter_seen
                    .push((from.pixel, surface.illuminating != Vec3::ZERO && !scene.is_gathered(hit.target)));
            }
            if surface.emission != Vec3::ZERO {
                self.emitted.push((from.pixel, beta * surface.emission));
            }
            if surface.diffuse != Vec3::ZERO {
                self.lit.vertices.push(surface.shading_point(beta, from.pixel));
            }
            if layered && from.depth == 0 {
                let vertex = (surface.diffuse != Vec3::ZERO).then(|| self.lit.vertices.len() as u32 - 1);
                self.first_hits.push(from.pixel, beta.x, &surface, vertex);
            }
            spawn(&mut self.next, from, hit, &surface, options);
        }
    }

    /// Marks the mesh points that the vertices read and that are empty.
    pub(super) fn demand(&self, (scene, plan): (&Scene, LightingPlan), mesh: &LightMesh, marks: &LightMarks) {
        let vertices = &self.lit.vertices;
        if plan.primary != Shading::Exact {
            mesh.direct.points().demand(scene, vertices, &marks.direct, CornerVisibility::All);
        }
        if let (Some(field), Some(marks), Indirect::Mesh) = (&mesh.indirect, &marks.indirect, plan.indirect) {
            field.points().demand(scene, vertices, marks, CornerVisibility::All);
        }
    }

    /// Lets every vertex wait for indirect light.
    pub(super) fn await_indirect(&mut self) {
        self.indirect.clear();
        self.indirect.resize(self.lit.vertices.len(), Vec3::ZERO);
        self.unresolved.clear();
        self.waiting.clear();
        self.waiting.extend(0..self.lit.vertices.len() as u32);
    }

    /// Lets every vertex gather its indirect light itself.
    pub(super) fn gather_all(&mut self) {
        std::mem::swap(&mut self.unresolved, &mut self.waiting);
    }

    /// Reads the mesh for the vertices that wait; those whose points are empty mark them and go on waiting.
    pub(super) fn read_indirect(&mut self, scene: &Scene, field: &IndirectField, bounces: u32, marks: &Marks) {
        let mut reader = field.reader(scene, bounces, CornerVisibility::All);
        let Self { waiting, lit, indirect, unresolved: orphans, .. } = self;
        waiting.retain(|&i| {
            match reader.read(&lit.vertices[i as usize], marks) {
                IndirectReading::Irradiance(irradiance) => indirect[i as usize] = irradiance,
                IndirectReading::Unavailable => orphans.push(i),
                IndirectReading::Pending => return true,
            }
            false
        });
        self.visibility_rays += reader.visibility_rays();
    }

    /// The vertices that the indirect mesh has no answer for.
    pub(super) fn unresolved(&self) -> impl Iterator<Item = &ShadingPoint> {
        self.unresolved.iter().map(|&i| &self.lit.vertices[i as usize])
    }
}

/// The rays that go on from a surface: through it, mirrored and refracted.
fn spawn(next: &mut Vec<WaveRay>, from: &WaveRay, hit: &Hit, surface: &ShadedHit, options: &RenderOptions) {
    if surface.opacity < 1.0 && from.transparent_hits < MAX_TRANSPARENT_HITS {
        let beta = from.beta * (1.0 - surface.opacity);
        if beta.max_element() > options.transport.cutoff {
            let ray = Ray { t_min: hit.t, ..from.ray };
            next.push(WaveRay { ray, beta, transparent_hits: from.transparent_hits + 1, ..*from });
        }
    }
    if from.depth >= options.transport.depth {
        return;
    }
    let cone = from.cone.after(hit.t);
    let mut follow = |weight: Vec3, direction: Vec3, cone: Cone| {
        let beta = from.beta * surface.opacity * weight;
        if beta.max_element() > options.transport.cutoff {
            let ray = surface.spawn_ray(direction);
            next.push(WaveRay { ray, cone, beta, pixel: from.pixel, depth: from.depth + 1, transparent_hits: 0 });
        }
    };
    if surface.mirror != Vec3::ZERO {
        let mirrored = surface.reflect(from.ray.direction);
        follow(surface.mirror, mirrored, cone.mirrored(from.ray.direction, mirrored));
    }
    if surface.refraction != Vec3::ZERO {
        follow(surface.refraction, surface.refracted, cone);
    }
}
