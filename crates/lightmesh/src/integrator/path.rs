//! Unidirectional path tracing with next-event estimation over all lights: slow, unbiased, the truth.

use glam::Vec3;
use rayon::prelude::*;

use super::direct::Scratch;
use super::sampling::{Sampler, basis, sample_cosine_hemisphere};
use super::surface::{Surface, evaluate};
use super::wave::MAX_LAYERS;
use crate::film::Film;
use crate::geometry::Ray;
use crate::progress::Reporter;
use crate::{Error, Progress, RayCounts, RenderOptions, RenderStats, Scene, Stage};

/// Samples per unit of parallel work, and units between two visits to the film.
const BLOCK: u64 = 256;
const BLOCKS: u64 = 256;

/// Diffuse bounces after which Russian roulette may end a path.
const ROULETTE_AFTER: u32 = 3;

/// Renders all samples of the film by path tracing.
pub(crate) fn render_path(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Result<RenderStats, Error> {
    let started = std::time::Instant::now();
    let mut stats = RenderStats::default();
    let total = film.sample_count();
    let reporter = Reporter::new(progress, Stage::Render, total);
    let mut first = 0;
    while first < total {
        let end = (first + BLOCK * BLOCKS).min(total);
        let camera = &*film;
        let blocks: Vec<(Vec<(u32, Vec3)>, RayCounts)> = (0..(end - first).div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let mut tracer = PathTracer { scene, options, scratch: Scratch::default(), rays: RayCounts::default() };
                let begin = first + block * BLOCK;
                let radiance = camera
                    .samples(begin..(begin + BLOCK).min(end))
                    .take_while(|_| !reporter.cancelled())
                    .map(|s| (s.pixel, tracer.li(camera.ray(s), &mut Sampler::new(options.seed, s.pixel, s.index))))
                    .collect();
                reporter.add(end.min(begin + BLOCK) - begin, tracer.rays.total());
                (radiance, tracer.rays)
            })
            .collect();
        if reporter.cancelled() {
            return Err(Error::Cancelled);
        }
        for (samples, rays) in blocks {
            samples.into_iter().for_each(|(pixel, radiance)| film.add(pixel, radiance));
            stats.rays.primary += rays.primary;
            stats.rays.shadow += rays.shadow;
            stats.rays.gather += rays.gather;
            stats.rays.secondary += rays.secondary;
        }
        first = end;
    }
    stats.seconds.shade = started.elapsed().as_secs_f64();
    Ok(stats)
}

struct PathTracer<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions,
    scratch: Scratch,
    rays: RayCounts,
}

impl PathTracer<'_> {
    /// An estimate of the radiance along `ray`, cd/m².
    fn li(&mut self, mut ray: Ray, sampler: &mut Sampler) -> Vec3 {
        let (mut li, mut beta) = (Vec3::ZERO, Vec3::ONE);
        let (mut bounces, mut depth, mut layers) = (0, 0, 0);
        self.rays.primary += 1;
        while let Some(hit) = self.scene.bvh().closest(&ray) {
            let surface = evaluate(self.scene, &ray, &hit);

            // A surface that covers a part stops that part of the paths.
            if surface.coverage < 1.0 && sampler.next() >= surface.coverage {
                layers += 1;
                if layers > MAX_LAYERS {
                    break;
                }
                ray.t_min = hit.t;
                self.rays.secondary += 1;
                continue;
            }
            layers = 0;

            // Emission and every light, at every vertex.
            li += beta * surface.emission;
            if surface.diffuse != Vec3::ZERO {
                let vertex = surface.vertex(beta, 0);
                let (irradiance, shadow) = self.scratch.irradiance(self.scene, self.options.falloff, &vertex);
                li += vertex.weight * irradiance;
                self.rays.shadow += shadow;
            }

            // Choose how to go on, in proportion to what each way may carry.
            let diffuse = if bounces < self.options.bounces { surface.diffuse } else { Vec3::ZERO };
            let specular = if depth < self.options.depth { 1.0 } else { 0.0 };
            let ways = [diffuse, surface.mirror * specular, surface.refraction * specular];
            let total: f32 = ways.iter().map(|w| w.max_element()).sum();
            if total <= 0.0 {
                break;
            }
            let u = sampler.next() * total;
            let way = usize::from(u >= ways[0].max_element())
                + usize::from(u >= ways[0].max_element() + ways[1].max_element());
            let way = if ways[way] == Vec3::ZERO { (0..3).find(|&w| ways[w] != Vec3::ZERO).unwrap_or(0) } else { way };
            beta *= ways[way] * (total / ways[way].max_element());
            if way == 0 {
                bounces += 1;
                depth = 0;
                ray = self.bounce(&surface, sampler);
                self.rays.gather += 1;
            } else {
                depth += 1;
                let direction = if way == 1 { surface.mirrored(ray.direction) } else { surface.refracted };
                ray = surface.leave(direction);
                self.rays.secondary += 1;
            }

            // Russian roulette: dim paths end, the survivors carry their share.
            if bounces > ROULETTE_AFTER {
                let survive = beta.max_element().min(0.95);
                if sampler.next() >= survive {
                    break;
                }
                beta /= survive;
            }
        }
        li
    }

    /// A cosine-distributed direction about the shading normal: its pdf cancels Lambert's cosine / π.
    fn bounce(&self, surface: &Surface, sampler: &mut Sampler) -> Ray {
        let (t, b) = basis(surface.n);
        let local = sample_cosine_hemisphere(sampler.next_pair());
        surface.leave(t * local.x + b * local.y + surface.n * local.z)
    }
}
