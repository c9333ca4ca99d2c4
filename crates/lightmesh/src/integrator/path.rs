//! Unidirectional path tracing with next-event estimation over all lights and multiple importance sampling of those that have a
//! size (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 9): slow, unbiased, the truth.

use glam::Vec3;
use rayon::prelude::*;

use super::block::MAX_LAYERS;
use super::direct::Scratch;
use super::lamps::{LampSampler, power_heuristic};
use super::sampling::{Sampler, basis, pdf_cosine_hemisphere, sample_cosine_hemisphere};
use super::surface::{Surface, Vertex, evaluate};
use crate::bvh::Hit;
use crate::film::Film;
use crate::geometry::Ray;
use crate::progress::Reporter;
use crate::{Error, Progress, RayCounts, RenderOptions, RenderStats, Scene, Stage};

/// Samples per unit of parallel work, and units between two visits to the film.
const BLOCK: u64 = 256;
const BLOCKS: u64 = 256;

/// Diffuse bounces after which Russian roulette may end a path.
const ROULETTE_AFTER: u32 = 3;

/// Paths that go on from the first diffuse surface of a camera ray (splitting: Arvo and Kirk, "Particle Transport and Image
/// Synthesis", SIGGRAPH 1990): what is left of the noise there is in the indirect light. Measured on the Cornell box, 64 samples:
/// error 12.2% with one path and 50.8 M bounces, 8.1% with two and 101.6 M; 10.1% with one and no roulette, 87.4 M.
const BRANCHES: u32 = 2;

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
                let mut tracer = PathTracer {
                    scene,
                    options,
                    scratch: Scratch::default(),
                    lamps: LampSampler::default(),
                    rays: RayCounts::default(),
                };
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
    lamps: LampSampler,
    rays: RayCounts,
}

/// How the ray at hand came about: what the emission that it meets counts.
#[derive(Clone, Copy, Debug)]
enum Arrival {
    /// From the camera, by mirrors and glass alone: everything that shines is seen, unlit surfaces too.
    Seen,
    /// By a mirror from a diffuse surface: no light sample leads here.
    Mirrored,
    /// From a diffuse surface in a direction of this density (per steradian), through nothing: half of an estimate, the other half
    /// is a light sample.
    Bounced { pdf: f32 },
    /// From a diffuse surface through glass or layers, where shadow rays go as well: they count it.
    Passed,
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
struct Walk {
    ray: Ray,
    beta: Vec3,
    bounces: u32,
    arrival: Arrival,
}

impl PathTracer<'_> {
    /// An estimate of the radiance along a camera ray, cd/m².
    fn li(&mut self, ray: Ray, sampler: &mut Sampler) -> Vec3 {
        self.rays.primary += 1;
        self.follow(Walk { ray, beta: Vec3::ONE, bounces: 0, arrival: Arrival::Seen }, sampler)
    }

    /// An estimate of what a path brings from here on.
    fn follow(&mut self, walk: Walk, sampler: &mut Sampler) -> Vec3 {
        let Walk { mut ray, mut beta, mut bounces, mut arrival } = walk;
        let mut li = Vec3::ZERO;
        let (mut depth, mut layers) = (0, 0);
        loop {
            let Some(hit) = self.scene.bvh().closest(&ray) else {
                return li + beta * self.sky(&ray, arrival);
            };
            let surface = evaluate(self.scene, &ray, &hit);

            // A surface that covers a part stops that part of the paths.
            if surface.coverage < 1.0 && sampler.choice() >= surface.coverage {
                layers += 1;
                if layers > MAX_LAYERS {
                    break;
                }
                ray.t_min = hit.t;
                self.rays.secondary += 1;
                if let Arrival::Bounced { .. } = arrival {
                    arrival = Arrival::Passed;
                }
                continue;
            }
            layers = 0;

            li += beta * self.emission(&ray, &hit, &surface, arrival);
            // The last bounce only looks for lamps.
            if bounces > self.options.bounces {
                break;
            }
            if surface.diffuse != Vec3::ZERO {
                let vertex = surface.vertex(beta, 0);
                li += vertex.weight * self.direct(&vertex, sampler);
            }

            // Choose how to go on, in proportion to what each way may carry.
            let ends = bounces == self.options.bounces && !self.lamps.can_be_hit(self.scene);
            let diffuse = if ends { Vec3::ZERO } else { surface.diffuse };
            let specular = if depth < self.options.depth { 1.0 } else { 0.0 };
            let ways = [diffuse, surface.mirror * specular, surface.refraction * specular];
            let total: f32 = ways.iter().map(|w| w.max_element()).sum();
            if total <= 0.0 {
                break;
            }
            let u = sampler.choice() * total;
            let way = usize::from(u >= ways[0].max_element())
                + usize::from(u >= ways[0].max_element() + ways[1].max_element());
            let way = if ways[way] == Vec3::ZERO { (0..3).find(|&w| ways[w] != Vec3::ZERO).unwrap_or(0) } else { way };
            beta *= ways[way] * (total / ways[way].max_element());
            if way == 0 && bounces == 0 {
                return li + self.branch(&surface, beta, sampler);
            }
            if way == 0 {
                bounces += 1;
                depth = 0;
                let pdf;
                (ray, pdf) = self.bounce(&surface, sampler);
                arrival = Arrival::Bounced { pdf };
                self.rays.gather += 1;
            } else {
                depth += 1;
                let direction = if way == 1 { surface.mirrored(ray.direction) } else { surface.refracted };
                ray = surface.leave(direction);
                arrival = match (arrival, way) {
                    (Arrival::Seen, _) => Arrival::Seen,
                    (_, 1) => Arrival::Mirrored,
                    _ => Arrival::Passed,
                };
                self.rays.secondary += 1;
            }

            // Russian roulette: dim paths end, the survivors carry their share.
            if bounces > ROULETTE_AFTER {
                let survive = beta.max_element().min(0.95);
                if sampler.choice() >= survive {
                    break;
                }
                beta /= survive;
            }
        }
        li
    }

    /// The mean of [`BRANCHES`] paths that leave the first diffuse surface.
    fn branch(&mut self, surface: &Surface, beta: Vec3, sampler: &Sampler) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for branch in 0..BRANCHES {
            let mut sampler = sampler.branch(branch, BRANCHES);
            let (ray, pdf) = self.bounce(surface, &mut sampler);
            self.rays.gather += 1;
            let arrival = Arrival::Bounced { pdf };
            sum += self.follow(Walk { ray, beta, bounces: 1, arrival }, &mut sampler);
        }
        sum * (1.0 / BRANCHES as f32)
    }

    /// A cosine-distributed direction about the shading normal: its pdf, cosθ / π, cancels Lambert's cosine / π.
    fn bounce(&self, surface: &Surface, sampler: &mut Sampler) -> (Ray, f32) {
        let (t, b) = basis(surface.n);
        let local = sample_cosine_hemisphere(sampler.next_pair());
        let ray = surface.leave(t * local.x + b * local.y + surface.n * local.z);
        (ray, pdf_cosine_hemisphere(local.z))
    }

    /// Direct irradiance: every punctual light, and a point on an area light and a direction of the environment, with their
    /// share of the estimate.
    fn direct(&mut self, vertex: &Vertex, sampler: &mut Sampler) -> Vec3 {
        let (scene, falloff) = (self.scene, self.options.falloff);
        let mut sum = Vec3::ZERO;
        if scene.emitters().light_radius > 0.0 {
            sum += self.lamps.balls(scene, falloff, vertex, sampler);
        } else {
            let (irradiance, rays) = self.scratch.irradiance(scene, &scene.emitters().punctual, falloff, vertex);
            self.rays.shadow += rays;
            sum += irradiance;
        }
        sum += self.lamps.area(scene, falloff, vertex, sampler);
        sum += self.lamps.environment(scene, vertex, sampler);
        self.rays.shadow += self.lamps.take_rays();
        sum
    }

    /// What the emission of a surface counts.
    fn emission(&self, ray: &Ray, hit: &Hit, surface: &Surface, arrival: Arrival) -> Vec3 {
        let area = &self.scene.emitters().area;
        let light = || area.pdf(self.scene.data(), hit.target);
        match arrival {
            Arrival::Seen => surface.emission,
            Arrival::Mirrored => surface.lights,
            Arrival::Bounced { pdf } if surface.lights != Vec3::ZERO => {
                let d = surface.position - ray.origin;
                let cos = surface.ng.dot(ray.direction).abs();
                let light = light() * d.length_squared() / cos.max(1e-6);
                surface.lights * power_heuristic(pdf, light)
            }
            // User-defined shapes cannot be sampled.
            Arrival::Passed if light() == 0.0 => surface.lights,
            Arrival::Bounced { .. } | Arrival::Passed => Vec3::ZERO,
        }
    }

    /// What the environment counts.
    fn sky(&self, ray: &Ray, arrival: Arrival) -> Vec3 {
        let Some(environment) = &self.scene.emitters().environment else { return Vec3::ZERO };
        let direction = ray.direction.normalize();
        let share = match arrival {
            Arrival::Seen | Arrival::Mirrored => 1.0,
            Arrival::Bounced { pdf } => power_heuristic(pdf, environment.pdf(direction)),
            Arrival::Passed => return Vec3::ZERO,
        };
        environment.radiance(direction) * share
    }
}
