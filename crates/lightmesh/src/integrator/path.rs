//! Unidirectional path tracing with next-event estimation over all lights and multiple importance sampling of those that have a
//! size (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 9): slow, unbiased, the truth.

use std::f32::consts::PI;
use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::emitter_sampling::{EmitterSampler, power_heuristic};
use super::first_hits::FirstHits;
use crate::bvh::Hit;
use crate::direct::Scratch;
use crate::film::{Film, RenderClock, SumOrder, take_samples};
use crate::geometry::{Cone, Ray};
use crate::interaction::{MAX_TRANSPARENT_HITS, ShadedHit, ShadingPoint, evaluate_footprint};
use crate::light::LightCut;
use crate::progress::Reporter;
use crate::sampling::{Sampler, basis, pdf_cosine_hemisphere, sample_cosine_hemisphere};
use crate::{Aov, Error, RayCounts, RenderOptions, RenderStats, Scene};

/// Samples per unit of parallel work.
const BLOCK: u64 = 256;

/// Diffuse bounces after which Russian roulette may end a path.
const ROULETTE_AFTER: u32 = 3;

/// Paths that go on from the first diffuse surface of a camera ray (splitting: Arvo and Kirk, "Particle Transport and Image
/// Synthesis", SIGGRAPH 1990): what is left of the noise there is in the indirect light. Measured on the Cornell box, 64 samples:
/// error 12.2% with one path and 50.8 M bounces, 8.1% with two and 101.6 M; 10.1% with one and no roulette, 87.4 M.
const SPLITS: u32 = 2;

/// Renders the picture by path tracing.
pub(crate) fn render_path(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    watch: &mut RenderClock<'_>,
) -> Result<RenderStats, Error> {
    let mut stats = RenderStats::default();
    take_samples(film, options, SumOrder::Samples, watch, |film, watch, reporter| {
        trace_pass(scene, options, film, watch, reporter, &mut stats)
    })?;
    Ok(stats)
}

/// Takes the samples of the film's pass.
pub(crate) fn trace_pass(
    scene: &Scene,
    options: &RenderOptions,
    film: &mut Film,
    watch: &mut RenderClock<'_>,
    reporter: &Reporter<'_>,
    stats: &mut RenderStats,
) -> Result<(), Error> {
    let started = std::time::Instant::now();
    while let Some(samples) = watch.next_wave(film) {
        let first = film.done();
        let end = first + samples;
        let camera = &*film;
        let blocks: Vec<PathBlock> = (0..samples.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let begin = first + block * BLOCK;
                PathBlock::trace(scene, options, camera, begin..(begin + BLOCK).min(end), reporter)
            })
            .collect();
        if reporter.cancelled() {
            return Err(Error::Cancelled);
        }
        for block in blocks {
            block.add_to(film);
            stats.rays += block.rays;
        }
        watch.wave_done(film, samples);
    }
    stats.seconds.shade += started.elapsed().as_secs_f64();
    Ok(())
}

/// What came of some samples.
struct PathBlock {
    radiance: Vec<(u32, Radiance)>,
    first_hits: FirstHits,
    rays: RayCounts,
}

impl PathBlock {
    /// Follows the paths of some samples of the film, until the work is cancelled.
    fn trace(
        scene: &Scene,
        options: &RenderOptions,
        film: &Film,
        samples: Range<u64>,
        reporter: &Reporter<'_>,
    ) -> Self {
        let mut tracer = PathTracer::new(scene, options);
        let count = samples.end - samples.start;
        let radiance = film
            .samples(samples)
            .take_while(|_| !reporter.cancelled())
            .map(|s| {
                let mut sampler = Sampler::new(options.seed, s.pixel, s.index);
                let (ray, cone) = film.ray(s);
                (s.pixel, tracer.li(ray, cone, s.pixel, &mut sampler))
            })
            .collect();
        reporter.add(count, tracer.rays.total());
        Self { radiance, first_hits: tracer.first_hits, rays: tracer.rays }
    }

    fn add_to(&self, film: &mut Film) {
        for (pixel, radiance) in &self.radiance {
            film.add(*pixel, radiance.all);
        }
        if film.has_layers() {
            for (pixel, radiance) in &self.radiance {
                film.layers().add(Aov::Direct, *pixel, radiance.direct);
                film.layers().add(Aov::Indirect, *pixel, radiance.indirect);
            }
            self.first_hits.add_to(film);
        }
    }
}

/// Radiance along a path, cd/m², or irradiance: all of it, and the parts that [`Aov::Direct`] and [`Aov::Indirect`] have of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Radiance {
    all: Vec3,
    pub(super) direct: Vec3,
    pub(super) indirect: Vec3,
}

impl Radiance {
    fn add(&mut self, aov: Aov, radiance: Vec3) {
        self.all += radiance;
        *(if aov == Aov::Direct { &mut self.direct } else { &mut self.indirect }) += radiance;
    }

    /// Adds a share of another path's.
    fn add_part(&mut self, path: Self, share: f32) {
        self.all += path.all * share;
        self.direct += path.direct * share;
        self.indirect += path.indirect * share;
    }
}

pub(super) struct PathTracer<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions,
    scratch: Scratch,
    lamps: EmitterSampler,
    pub(super) rays: RayCounts,
    first_hits: FirstHits,
}

/// How the ray at hand came about: what the emission that it meets counts.
#[derive(Clone, Copy, Debug)]
enum RayOrigin {
    /// From the camera, by mirrors and glass alone: everything that shines is seen, unlit surfaces too.
    Camera,
    /// By a mirror from a diffuse surface: no light sample leads here.
    Specular,
    /// From a diffuse surface in a direction of this density (per steradian), through nothing: half of an estimate, the other half
    /// is a light sample.
    Bsdf { pdf: f32 },
    /// From a diffuse surface through glass or layers, where shadow rays go as well: they count it.
    Transmitted,
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
struct PathState {
    ray: Ray,
    /// What it stands for: after a diffuse bounce nothing but itself.
    cone: Cone,
    beta: Vec3,
    bounces: u32,
    arrival: RayOrigin,
    pixel: u32,
}

/// Which layer has what shines at the end of a path with so many diffuse bounces: after the first one, it is the other
/// half of the direct light, unless a mirror came between.
fn part(bounces: u32, arrival: RayOrigin) -> Aov {
    match (bounces, arrival) {
        (0, _) | (1, RayOrigin::Bsdf { .. } | RayOrigin::Transmitted) => Aov::Direct,
        _ => Aov::Indirect,
    }
}

impl<'a> PathTracer<'a> {
    pub(crate) fn new(scene: &'a Scene, options: &'a RenderOptions) -> Self {
        Self {
            scene,
            options,
            scratch: Scratch::default(),
            lamps: EmitterSampler::default(),
            rays: RayCounts::default(),
            first_hits: FirstHits::default(),
        }
    }

    /// An estimate of the irradiance at a vertex, lux.
    pub(super) fn irradiance(&mut self, vertex: &ShadingPoint, sampler: &mut Sampler) -> Radiance {
        let mut e = Radiance::default();
        e.add(Aov::Direct, self.direct(vertex, sampler));
        if self.options.transport.bounces > 0 || self.lamps.can_be_hit(self.scene) {
            // The mean of radiance over directions in proportion to the cosine is E / π.
            let mut mean = Radiance::default();
            self.split(vertex, (Vec3::ONE, 0), sampler, &mut mean);
            e.add_part(mean, PI);
        }
        e
    }

    /// An estimate of the radiance along a camera ray, cd/m².
    fn li(&mut self, ray: Ray, cone: Cone, pixel: u32, sampler: &mut Sampler) -> Radiance {
        self.rays.primary += 1;
        self.follow(PathState { ray, cone, beta: Vec3::ONE, bounces: 0, arrival: RayOrigin::Camera, pixel }, sampler)
    }

    /// An estimate of what a path brings from here on.
    fn follow(&mut self, walk: PathState, sampler: &mut Sampler) -> Radiance {
        let PathState { mut ray, mut cone, mut beta, mut bounces, mut arrival, pixel } = walk;
        let mut li = Radiance::default();
        let (mut depth, mut layers) = (0, 0);
        loop {
            let Some(hit) = self.scene.bvh().closest(&ray) else {
                li.add(part(bounces, arrival), beta * self.sky(&ray, arrival));
                break;
            };
            let surface = evaluate_footprint(self.scene, &ray, cone, &hit);

            // A surface that covers a part stops that part of the paths.
            if surface.opacity < 1.0 && sampler.choice() >= surface.opacity {
                layers += 1;
                if layers > MAX_TRANSPARENT_HITS {
                    break;
                }
                ray.t_min = hit.t;
                self.rays.secondary += 1;
                if let RayOrigin::Bsdf { .. } = arrival {
                    arrival = RayOrigin::Transmitted;
                }
                continue;
            }
            layers = 0;
            if !self.options.picture.aovs.is_empty() && bounces + depth == 0 {
                self.first_hits.push(pixel, 1.0, &surface, None);
            }

            li.add(part(bounces, arrival), beta * self.emission(&ray, &hit, &surface, arrival));
            // The last bounce only looks for lamps.
            if bounces > self.options.transport.bounces {
                break;
            }
            if surface.diffuse != Vec3::ZERO {
                let vertex = surface.shading_point(beta, 0);
                let aov = if bounces == 0 { Aov::Direct } else { Aov::Indirect };
                li.add(aov, vertex.weight * self.direct(&vertex, sampler));
            }

            // Choose how to go on, in proportion to what each way may carry.
            let ends = bounces == self.options.transport.bounces && !self.lamps.can_be_hit(self.scene);
            let diffuse = if ends { Vec3::ZERO } else { surface.diffuse };
            let specular = if depth < self.options.transport.depth { 1.0 } else { 0.0 };
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
                self.split(&surface.shading_point(beta, pixel), (beta, pixel), sampler, &mut li);
                break;
            }
            if way == 0 {
                bounces += 1;
                depth = 0;
                let pdf;
                (ray, pdf) = self.bounce(&surface.shading_point(beta, pixel), sampler);
                cone = Cone::POINT;
                arrival = RayOrigin::Bsdf { pdf };
                self.rays.gather += 1;
            } else {
                depth += 1;
                let direction = if way == 1 { surface.reflect(ray.direction) } else { surface.refracted };
                cone = cone.after(hit.t);
                if way == 1 {
                    cone = cone.mirrored(ray.direction, direction);
                }
                ray = surface.spawn_ray(direction);
                arrival = match (arrival, way) {
                    (RayOrigin::Camera, _) => RayOrigin::Camera,
                    (_, 1) => RayOrigin::Specular,
                    _ => RayOrigin::Transmitted,
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

    /// Adds the mean of [`SPLITS`] paths that leave the first diffuse surface with this throughput.
    fn split(&mut self, vertex: &ShadingPoint, (beta, pixel): (Vec3, u32), sampler: &Sampler, li: &mut Radiance) {
        for branch in 0..SPLITS {
            let mut sampler = sampler.branch(branch, SPLITS);
            let (ray, pdf) = self.bounce(vertex, &mut sampler);
            self.rays.gather += 1;
            let arrival = RayOrigin::Bsdf { pdf };
            let part =
                self.follow(PathState { ray, cone: Cone::POINT, beta, bounces: 1, arrival, pixel }, &mut sampler);
            li.add_part(part, 1.0 / SPLITS as f32);
        }
    }

    /// A cosine-distributed direction about the shading normal: its pdf, cosθ / π, cancels Lambert's cosine / π.
    fn bounce(&self, vertex: &ShadingPoint, sampler: &mut Sampler) -> (Ray, f32) {
        let (t, b) = basis(vertex.n);
        let local = sample_cosine_hemisphere(sampler.next_pair());
        let direction = t * local.x + b * local.y + vertex.n * local.z;
        (Ray::new(vertex.origin_towards(direction), direction), pdf_cosine_hemisphere(local.z))
    }

    /// Direct irradiance: every punctual light, and a point on an area light and a direction of the environment, with their
    /// share of the estimate.
    fn direct(&mut self, vertex: &ShadingPoint, sampler: &mut Sampler) -> Vec3 {
        let (scene, falloff) = (self.scene, self.options.transport.falloff);
        let mut sum = Vec3::ZERO;
        if scene.emitters().light_radius > 0.0 {
            sum += self.lamps.sphere_lights(scene, falloff, vertex, sampler);
        } else {
            let lights = LightCut::all(&scene.emitters().punctual);
            let (irradiance, rays) = self.scratch.irradiance(scene, &lights, falloff, vertex);
            self.rays.shadow += rays;
            sum += irradiance;
        }
        sum += self.lamps.area(scene, falloff, vertex, sampler);
        sum += self.lamps.environment(scene, vertex, sampler);
        self.rays.shadow += self.lamps.take_rays();
        sum
    }

    /// What the emission of a surface counts.
    fn emission(&self, ray: &Ray, hit: &Hit, surface: &ShadedHit, arrival: RayOrigin) -> Vec3 {
        let area = &self.scene.emitters().area;
        let light = || area.pdf(self.scene.data(), hit.target);
        match arrival {
            RayOrigin::Camera => surface.emission,
            RayOrigin::Specular => surface.illuminating,
            RayOrigin::Bsdf { pdf } if surface.illuminating != Vec3::ZERO => {
                let d = surface.position - ray.origin;
                let cos = surface.ng.dot(ray.direction).abs();
                let light = light() * d.length_squared() / cos.max(1e-6);
                surface.illuminating * power_heuristic(pdf, light)
            }
            // User-defined shapes cannot be sampled.
            RayOrigin::Transmitted if light() == 0.0 => surface.illuminating,
            RayOrigin::Bsdf { .. } | RayOrigin::Transmitted => Vec3::ZERO,
        }
    }

    /// What the environment counts.
    fn sky(&self, ray: &Ray, arrival: RayOrigin) -> Vec3 {
        let Some(environment) = &self.scene.emitters().environment else { return Vec3::ZERO };
        let direction = ray.direction.normalize();
        let share = match arrival {
            RayOrigin::Camera | RayOrigin::Specular => 1.0,
            RayOrigin::Bsdf { pdf } => power_heuristic(pdf, environment.pdf(direction)),
            RayOrigin::Transmitted => return Vec3::ZERO,
        };
        environment.radiance(direction) * share
    }
}
