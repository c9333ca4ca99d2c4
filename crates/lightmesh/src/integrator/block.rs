//! A block of a wave: up to 512 rays, what they hit, and what came of it.

use std::ops::Range;

use glam::Vec3;

use super::first_hits::FirstHits;
use crate::bvh::Hit;
use crate::direct::{Indirect, LitVertices, Plan, Shading};
use crate::film::{Film, Sample};
use crate::geometry::{Cone, Ray};
use crate::indirect::{IndirectField, IndirectReading};
use crate::interaction::{MAX_LAYERS, Surface, Vertex, evaluate_seen};
use crate::light_mesh::{LightMarks, LightMesh};
use crate::mesh::{Marks, Sight};
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
    layers: u8,
}

/// Up to [`BLOCK`] rays, what they hit and what came of it; buffers are kept from wave to wave.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) input: Vec<WaveRay>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    pub(super) lit: LitVertices,
    /// Indirect irradiance of each vertex, lux; empty where there is none.
    pub(super) indirect: Vec<Vec3>,
    /// Vertices that the indirect mesh has not answered yet, and those that it has no answer for.
    pub(super) waiting: Vec<u32>,
    pub(super) orphans: Vec<u32>,
    pub(super) sight_rays: u64,
    emitted: Vec<(u32, Vec3)>,
    /// Whether each camera ray saw a lamp; empty where nobody asks.
    lamps: Vec<(u32, bool)>,
    /// What the camera rays met; empty where nobody asks.
    pub(super) first_hits: FirstHits,
    pub(super) next: Vec<WaveRay>,
}

/// A hit with its irradiance, lux.
#[derive(Clone, Copy, Debug)]
pub(super) struct LitHit {
    pub vertex: Vertex,
    pub direct: glam::Vec3,
    pub indirect: glam::Vec3,
}

impl Block {
    pub(super) fn take_camera_rays(&mut self, film: &Film, samples: Range<u64>) {
        self.input.clear();
        self.input.extend(film.samples(samples).map(|sample: Sample| {
            let (ray, cone) = film.ray(sample);
            WaveRay { ray, cone, beta: Vec3::ONE, pixel: sample.pixel, depth: 0, layers: 0 }
        }));
    }

    /// Counts the rays of a finished block, and its samples if they are camera rays or meters, which no ray has led to.
    pub(super) fn report(&self, reporter: &Reporter<'_>) {
        let rays = self.input.len() as u64;
        let done = match self.input.first() {
            None => self.lit.vertices.len() as u64,
            Some(ray) if ray.depth == 0 && ray.layers == 0 => rays,
            Some(_) => 0,
        };
        reporter.add(done, rays + self.lit.rays());
    }

    /// The vertices with their light.
    pub(super) fn lit_hits(&self) -> impl Iterator<Item = LitHit> {
        let direct = self.lit.vertices.iter().zip(&self.lit.direct);
        direct.enumerate().map(|(i, (&vertex, &direct))| {
            let indirect = self.indirect.get(i).copied().unwrap_or_default();
            LitHit { vertex, direct, indirect }
        })
    }

    pub(super) fn add_to(&self, film: &mut Film) {
        for &(pixel, lamp) in &self.lamps {
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
        self.lamps.clear();
        self.first_hits.clear();
        let (watched, layered) = (scene.has_lamps(), !options.picture.aovs.is_empty());
        for (from, hit) in self.input.iter().zip(&self.hits) {
            let first = watched && from.depth == 0 && from.layers == 0;
            let Some(hit) = hit else {
                let sky = scene.environment(from.ray.direction.normalize());
                if first {
                    self.lamps.push((from.pixel, sky != Vec3::ZERO));
                }
                if sky != Vec3::ZERO {
                    self.emitted.push((from.pixel, from.beta * sky));
                }
                continue;
            };
            let surface = evaluate_seen(scene, &from.ray, from.cone, hit);
            let beta = from.beta * surface.coverage;
            if first {
                self.lamps.push((from.pixel, surface.lights != Vec3::ZERO && !scene.is_gathered(hit.target)));
            }
            if surface.emission != Vec3::ZERO {
                self.emitted.push((from.pixel, beta * surface.emission));
            }
            if surface.diffuse != Vec3::ZERO {
                self.lit.vertices.push(surface.vertex(beta, from.pixel));
            }
            if layered && from.depth == 0 {
                let vertex = (surface.diffuse != Vec3::ZERO).then(|| self.lit.vertices.len() as u32 - 1);
                self.first_hits.push(from.pixel, beta.x, &surface, vertex);
            }
            spawn(&mut self.next, from, hit, &surface, options);
        }
    }

    /// Marks the mesh points that the vertices read and that are empty.
    pub(super) fn demand(&self, (scene, plan): (&Scene, Plan), mesh: &LightMesh, marks: &LightMarks) {
        let vertices = &self.lit.vertices;
        if plan.seen != Shading::Exact {
            mesh.direct.points().demand(scene, vertices, &marks.direct, Sight::Every);
        }
        if let (Some(field), Some(marks), Indirect::Mesh) = (&mesh.indirect, &marks.indirect, plan.indirect) {
            field.points().demand(scene, vertices, marks, Sight::Every);
        }
    }

    /// Lets every vertex wait for indirect light.
    pub(super) fn await_indirect(&mut self) {
        self.indirect.clear();
        self.indirect.resize(self.lit.vertices.len(), Vec3::ZERO);
        self.orphans.clear();
        self.waiting.clear();
        self.waiting.extend(0..self.lit.vertices.len() as u32);
    }

    /// Lets every vertex gather its indirect light itself.
    pub(super) fn disown_all(&mut self) {
        std::mem::swap(&mut self.orphans, &mut self.waiting);
    }

    /// Reads the mesh for the vertices that wait; those whose points are empty mark them and go on waiting.
    pub(super) fn read_indirect(&mut self, scene: &Scene, field: &IndirectField, bounces: u32, marks: &Marks) {
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
    pub(super) fn orphans(&self) -> impl Iterator<Item = &Vertex> {
        self.orphans.iter().map(|&i| &self.lit.vertices[i as usize])
    }
}

/// The rays that go on from a surface: through it, mirrored and refracted.
fn spawn(next: &mut Vec<WaveRay>, from: &WaveRay, hit: &Hit, surface: &Surface, options: &RenderOptions) {
    if surface.coverage < 1.0 && from.layers < MAX_LAYERS {
        let beta = from.beta * (1.0 - surface.coverage);
        if beta.max_element() > options.transport.cutoff {
            let ray = Ray { t_min: hit.t, ..from.ray };
            next.push(WaveRay { ray, beta, layers: from.layers + 1, ..*from });
        }
    }
    if from.depth >= options.transport.depth {
        return;
    }
    let cone = from.cone.after(hit.t);
    let mut follow = |weight: Vec3, direction: Vec3, cone: Cone| {
        let beta = from.beta * surface.coverage * weight;
        if beta.max_element() > options.transport.cutoff {
            let ray = surface.leave(direction);
            next.push(WaveRay { ray, cone, beta, pixel: from.pixel, depth: from.depth + 1, layers: 0 });
        }
    };
    if surface.mirror != Vec3::ZERO {
        let mirrored = surface.mirrored(from.ray.direction);
        follow(surface.mirror, mirrored, cone.mirrored(from.ray.direction, mirrored));
    }
    if surface.refraction != Vec3::ZERO {
        follow(surface.refraction, surface.refracted, cone);
    }
}
