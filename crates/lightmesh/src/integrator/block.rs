//! A block of a wave: up to 512 rays, what they hit, and the rays that go on from there.

use std::ops::Range;

use glam::Vec3;

use super::first_hits::FirstHits;
use super::point_block::PointBlock;
use crate::bvh::Hit;
use crate::film::{Film, Sample, UnlitSample};
use crate::geometry::Ray;
use crate::interaction::{PathRay, ShadedHit, SpecularLobe, evaluate_footprint};
use crate::sampling::{hash, seed_of_position, unit_f32};
use crate::{Aov, RenderOptions, Scene};

/// Rays per block, the unit of parallel work: large enough for one SIMD dispatch, small enough to cancel quickly.
pub(super) const BLOCK: usize = 512;

/// A ray that splits off after the first mirror or refraction and carries less than this part of the picture's light goes on
/// by chance, in proportion, and then carries this part (Russian roulette; Arvo and Kirk, "Particle Transport and Image
/// Synthesis", SIGGRAPH 1990). A judgement: a box of half-transparent sides takes half the rays.
const WEAK: f32 = 0.1;

const REFLECTION: SpecularLobe = SpecularLobe::Reflection;

/// A ray of a wave, with its part of a film sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct WaveRay {
    path: PathRay,
    /// Throughput: radiance at the film per unit of radiance along the ray.
    beta: Vec3,
    pixel: u32,
    /// Whether a mirror was on its way: it then sees the environment, not the background.
    mirrored: bool,
}

impl WaveRay {
    /// The part of the sample that the ray stands for. Before the first mirror or refraction, only opacities have
    /// acted on the throughput, so that it is grey.
    fn coverage(beta: Vec3) -> f32 {
        beta.x
    }
}

/// Up to [`BLOCK`] rays, what they hit, and the rays that go on; buffers are kept from wave to wave.
#[derive(Debug, Default)]
pub(super) struct RayBlock {
    input: Vec<WaveRay>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// The diffuse surfaces among the hits; their ids are pixels.
    pub(super) points: PointBlock,
    /// Radiance that needs no lighting, by pixel: emission and sky.
    emitted: Vec<(u32, Vec3)>,
    /// Which of it is the colour of unlit surfaces.
    unlit: Vec<UnlitSample>,
    /// Whether each camera ray met an emitter, by pixel; empty in scenes without.
    emitter_seen: Vec<(u32, bool)>,
    /// What camera rays met first; empty where the picture has no layers.
    pub(super) first_hits: FirstHits,
    /// The rays that go on.
    pub(super) next: Vec<WaveRay>,
}

impl RayBlock {
    /// Takes the camera rays of some samples.
    pub(super) fn take_camera_rays(&mut self, film: &Film, samples: Range<u64>) {
        self.input.clear();
        self.input.extend(film.samples(samples).map(|sample: Sample| {
            let (ray, cone) = film.ray(sample);
            WaveRay { path: PathRay::new(ray, cone), beta: Vec3::ONE, pixel: sample.pixel, mirrored: false }
        }));
        (self.points.traced, self.points.completes) = (self.input.len() as u64, self.input.len() as u64);
    }

    /// Takes rays that go on from an earlier wave.
    pub(super) fn take_rays(&mut self, rays: &[WaveRay]) {
        self.input.clear();
        self.input.extend_from_slice(rays);
        (self.points.traced, self.points.completes) = (rays.len() as u64, 0);
    }

    /// Adds emission and reflected light to the film.
    pub(super) fn add_to(&self, film: &mut Film) {
        for &(pixel, emitter) in &self.emitter_seen {
            film.mark_seen(pixel, emitter);
        }
        for &(pixel, radiance) in &self.emitted {
            film.add(pixel, radiance);
        }
        self.unlit.iter().for_each(|&sample| film.add_unlit(sample));
        let PointBlock { batch, indirect, .. } = &self.points;
        for (point, &irradiance) in batch.vertices.iter().zip(&batch.direct) {
            film.add(point.id, point.weight * irradiance);
        }
        for (point, &irradiance) in batch.vertices.iter().zip(indirect) {
            film.add(point.id, point.weight * irradiance);
        }
        if film.has_layers() {
            self.add_layers_to(film);
        }
    }

    /// Adds the same light to the film's layers, direct and indirect light apart, and the first hits.
    fn add_layers_to(&self, film: &mut Film) {
        let layers = film.layers();
        for &(pixel, radiance) in &self.emitted {
            layers.add(Aov::Direct, pixel, radiance);
        }
        let PointBlock { batch, indirect, .. } = &self.points;
        for (aov, irradiances) in [(Aov::Direct, &batch.direct), (Aov::Indirect, indirect)] {
            for (point, &irradiance) in batch.vertices.iter().zip(irradiances) {
                layers.add(aov, point.id, point.weight * irradiance);
            }
        }
        self.first_hits.add_to(film);
    }

    /// Traces the input rays and evaluates what they hit.
    pub(super) fn trace(&mut self, scene: &Scene, options: &RenderOptions) {
        // Trace the whole block at once.
        self.rays.clear();
        self.rays.extend(self.input.iter().map(|r| r.path.ray));
        self.hits.clear();
        self.hits.resize(self.rays.len(), None);
        scene.bvh().closest_batch(&self.rays, &mut self.hits);

        self.points.clear();
        self.emitted.clear();
        self.unlit.clear();
        self.next.clear();
        self.emitter_seen.clear();
        self.first_hits.clear();
        let (watched, layered) = (scene.has_visible_emitters(), !options.picture.aovs.is_empty());
        for (from, hit) in self.input.iter().zip(&self.hits) {
            let first = watched && from.path.is_first();

            // Rays that leave the scene see the environment.
            let Some(hit) = hit else {
                let sky = match from.mirrored {
                    true => scene.environment(from.path.ray.direction.normalize()),
                    false => scene.backdrop(&from.path.ray),
                };
                if first {
                    self.emitter_seen.push((from.pixel, sky != Vec3::ZERO));
                }
                if sky != Vec3::ZERO {
                    self.emitted.push((from.pixel, from.beta * sky));
                }
                continue;
            };

            // Add the surface's own light.
            let surface = evaluate_footprint(scene, &from.path.ray, from.path.cone, hit);
            let beta = from.beta * surface.opacity;
            if first {
                self.emitter_seen.push((
                    from.pixel,
                    surface.illuminating != Vec3::ZERO && !scene.is_unsampled(hit, surface.position),
                ));
            }
            if surface.emission != Vec3::ZERO {
                let radiance = beta * surface.emission;
                self.emitted.push((from.pixel, radiance));
                if surface.is_unlit() {
                    self.unlit.push(UnlitSample { pixel: from.pixel, radiance, part: beta.max_element().min(1.0) });
                }
            }

            // Let diffuse surfaces be lit, and send rays on from the others.
            if surface.diffuse != Vec3::ZERO {
                self.points.batch.vertices.push(surface.shading_point(beta, from.pixel));
            }
            if layered && from.path.depth == 0 {
                let index = self.points.batch.vertices.len() as u32;
                let point = (surface.diffuse != Vec3::ZERO).then(|| index - 1);
                self.first_hits.push(from.pixel, WaveRay::coverage(beta), &surface, point);
            }
            spawn(&mut self.next, from, hit, &surface, options);
        }
    }
}

/// Appends the rays that go on from a surface, through it, mirrored and refracted, except those too weak to count.
fn spawn(next: &mut Vec<WaveRay>, from: &WaveRay, hit: &Hit, surface: &ShadedHit, options: &RenderOptions) {
    if surface.opacity < 1.0 {
        let beta = from.beta * (1.0 - surface.opacity);
        if beta.max_element() > options.transport.cutoff
            && let Some(path) = from.path.pass_through(hit)
        {
            next.push(WaveRay { path, beta, ..*from });
        }
    }
    if from.path.depth >= options.transport.depth {
        return;
    }
    for (lobe, albedo) in surface.lobes().specular() {
        let mut beta = from.beta * surface.opacity * albedo;
        let strength = beta.max_element();
        if strength <= options.transport.cutoff {
            continue;
        }
        // In glass, rays that split at every face are many and carry little: of the weak ones, some go on for all.
        if from.path.depth > 0 && strength < WEAK {
            let seed = seed_of_position(surface.position) ^ (2 * from.path.depth + u32::from(lobe == REFLECTION));
            if unit_f32(hash(seed)) * WEAK >= strength {
                continue;
            }
            beta *= WEAK / strength;
        }
        let mirrored = from.mirrored || lobe == REFLECTION;
        next.push(WaveRay { path: from.path.spawn(hit, surface, lobe), beta, mirrored, ..*from });
    }
}
