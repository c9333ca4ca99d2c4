//! Unidirectional path tracing with next-event estimation over all lights and multiple importance sampling of those
//! that have a size (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 9): slow,
//! unbiased, the truth.

use std::f32::consts::PI;
use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::emitter_sampling::{EmitterSampler, power_heuristic};
use super::first_hits::FirstHits;
use crate::bvh::Hit;
use crate::direct::{ExactShader, FewRaysShader};
use crate::film::{Film, RenderClock, SumOrder, UnlitSample, take_samples};
use crate::geometry::{Cone, Ray};
use crate::interaction::{
    Lobe, MirroredLights, MirroredShader, PathRay, ShadedHit, ShadingPoint, SpecularLobe, evaluate_footprint,
};
use crate::light::LightCut;
use crate::progress::Reporter;
use crate::sampling::{PixelOrder, Sampler, basis, pdf_cosine_hemisphere, sample_cosine_hemisphere};
use crate::{Aov, Error, RayCounts, RenderOptions, RenderStats, Scene};

/// Samples per unit of parallel work.
const BLOCK: u64 = 256;

/// Diffuse bounces after which Russian roulette may end a path.
const ROULETTE_AFTER: u32 = 3;

/// Paths that go on from the first diffuse surface of a camera ray (splitting: Arvo and Kirk, "Particle Transport and
/// Image Synthesis", SIGGRAPH 1990): the noise that is left there is in the indirect light. Measured on the Cornell
/// box, 64 samples: error 12.2% with one path and 50.8 M bounces, 8.1% with two and 101.6 M; 10.1% with one and no
/// roulette, 87.4 M.
const SPLITS: u32 = 2;

/// Renders the picture by path tracing.
pub(crate) fn render_path(
    scene: &Scene,
    film: &mut Film,
    options: &RenderOptions,
    clock: &mut RenderClock<'_>,
) -> Result<RenderStats, Error> {
    let mut stats = RenderStats::default();
    take_samples(film, options, SumOrder::Samples, clock, |film, clock, reporter| {
        trace_pass(scene, options, film, clock, reporter, &mut stats)
    })?;
    Ok(stats)
}

/// Takes the samples of the film's pass.
pub(crate) fn trace_pass(
    scene: &Scene,
    options: &RenderOptions,
    film: &mut Film,
    clock: &mut RenderClock<'_>,
    reporter: &Reporter<'_>,
    stats: &mut RenderStats,
) -> Result<(), Error> {
    let started = std::time::Instant::now();
    while let Some(samples) = clock.next_wave(film) {
        // Trace blocks of samples in parallel.
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

        // Add them to the film in order.
        for block in blocks {
            block.add_to(film);
            stats.rays += block.rays;
        }
        clock.wave_done(film, samples);
    }
    stats.seconds.shade += started.elapsed().as_secs_f64();
    Ok(())
}

/// What some samples have brought to the film.
struct PathBlock {
    radiance: Vec<(u32, Radiance)>,
    unlit: Vec<UnlitSample>,
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
        let order = PixelOrder::new(options.picture.width, options.picture.spp);
        let radiance = film
            .samples(samples)
            .take_while(|_| !reporter.cancelled())
            .map(|s| {
                let mut sampler = order.sampler(options.seed, s.pixel, s.index);
                let (ray, cone) = film.ray(s);
                (s.pixel, tracer.li(ray, cone, s.pixel, &mut sampler))
            })
            .collect();
        reporter.add(count, tracer.rays.total());
        Self { radiance, unlit: tracer.unlit, first_hits: tracer.first_hits, rays: tracer.rays }
    }

    fn add_to(&self, film: &mut Film) {
        for (pixel, radiance) in &self.radiance {
            film.add(*pixel, radiance.all);
        }
        self.unlit.iter().for_each(|&sample| film.add_unlit(sample));
        if film.has_layers() {
            for (pixel, radiance) in &self.radiance {
                film.layers().add(Aov::Direct, *pixel, radiance.direct);
                film.layers().add(Aov::Indirect, *pixel, radiance.indirect);
            }
            self.first_hits.add_to(film);
        }
    }
}

/// Radiance along a path, cd/m², or irradiance: the sum, and the parts that [`Aov::Direct`] and [`Aov::Indirect`] show.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Radiance {
    pub(super) all: Vec3,
    pub(super) direct: Vec3,
    pub(super) indirect: Vec3,
    /// The part of the sum that diffuse surfaces receive by way of mirrors and glass: caustics.
    pub(super) caustics: Vec3,
}

impl Radiance {
    fn add(&mut self, aov: Aov, radiance: Vec3) {
        self.all += radiance;
        *(if aov == Aov::Direct { &mut self.direct } else { &mut self.indirect }) += radiance;
    }

    /// Adds a share of another path's radiance.
    fn add_part(&mut self, path: Self, share: f32) {
        self.all += path.all * share;
        self.direct += path.direct * share;
        self.indirect += path.indirect * share;
        self.caustics += path.caustics * share;
    }

    /// Adds emission at the end of a path with so many diffuse bounces.
    fn add_emission(&mut self, bounces: u32, origin: RayOrigin, radiance: Vec3) {
        self.add(layer_of_emission(bounces, origin), radiance);
        if matches!(origin, RayOrigin::Specular) {
            self.caustics += radiance;
        }
    }
}

pub(super) struct PathTracer<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions,
    scratch: ExactShader,
    few_rays: FewRaysShader,
    /// Shadow rays to punctual lights at each surface, at most.
    most_rays: u32,
    mirrored: MirroredShader,
    emitters: EmitterSampler,
    pub(super) rays: RayCounts,
    /// The parts of camera rays that show unlit surfaces.
    unlit: Vec<UnlitSample>,
    first_hits: FirstHits,
}

/// Where a ray comes from, which decides how much the emission that it meets counts.
#[derive(Clone, Copy, Debug)]
enum RayOrigin {
    /// From the camera, by glass alone: all emission counts, that of unlit surfaces too, and the background.
    Camera,
    /// From the camera, by a mirror: the same, with the environment for the background.
    CameraMirror,
    /// By a mirror from a diffuse surface: no light sample leads here.
    Specular,
    /// From a diffuse surface in a direction of this density (per steradian), through nothing: one half of an
    /// estimate, of which light samples are the other one.
    Bsdf { pdf: f32 },
    /// From a diffuse surface through glass or partly transparent surfaces: shadow rays go through them as well and
    /// count the emission.
    Transmitted,
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
struct PathState {
    /// After a diffuse bounce, its cone is a point.
    path: PathRay,
    beta: Vec3,
    /// Diffuse bounces so far.
    bounces: u32,
    origin: RayOrigin,
    pixel: u32,
}

/// The layer of what shines at the end of a path with so many diffuse bounces: after the first one, it is the other
/// half of the direct light, unless a mirror came between.
fn layer_of_emission(bounces: u32, origin: RayOrigin) -> Aov {
    match (bounces, origin) {
        (0, _) | (1, RayOrigin::Bsdf { .. } | RayOrigin::Transmitted) => Aov::Direct,
        _ => Aov::Indirect,
    }
}

impl<'a> PathTracer<'a> {
    /// Lets it shoot no more shadow rays than these at a surface, where there are more punctual lights: to lights that are
    /// chosen by what they would give.
    pub(super) fn with_most_rays(mut self, most: u32) -> Self {
        self.most_rays = most;
        self
    }

    pub(crate) fn new(scene: &'a Scene, options: &'a RenderOptions) -> Self {
        Self {
            scene,
            options,
            scratch: ExactShader::default(),
            few_rays: FewRaysShader::default(),
            most_rays: u32::MAX,
            mirrored: MirroredShader::default(),
            emitters: EmitterSampler::default(),
            rays: RayCounts::default(),
            unlit: Vec::new(),
            first_hits: FirstHits::default(),
        }
    }

    /// An estimate of the irradiance at a point, lux.
    pub(super) fn irradiance(&mut self, point: &ShadingPoint, sampler: &mut Sampler) -> Radiance {
        let mut e = Radiance::default();
        e.add(Aov::Direct, self.direct(point, sampler));
        if self.options.transport.bounces > 0 || self.emitters.can_be_hit(self.scene) {
            // The mean of radiance over directions in proportion to the cosine is E / π.
            let mut mean = Radiance::default();
            self.split(point, Vec3::ONE, sampler, &mut mean);
            e.add_part(mean, PI);
        }
        e
    }

    /// An estimate of the radiance along a camera ray, cd/m².
    pub(super) fn li(&mut self, ray: Ray, cone: Cone, pixel: u32, sampler: &mut Sampler) -> Radiance {
        self.rays.primary += 1;
        let path = PathRay::new(ray, cone);
        self.follow(PathState { path, beta: Vec3::ONE, bounces: 0, origin: RayOrigin::Camera, pixel }, sampler)
    }

    /// An estimate of the radiance that a path brings from here on.
    fn follow(&mut self, state: PathState, sampler: &mut Sampler) -> Radiance {
        let PathState { mut path, mut beta, mut bounces, mut origin, pixel } = state;
        let mut li = Radiance::default();
        loop {
            let Some(hit) = self.scene.bvh().closest(&path.ray) else {
                li.add_emission(bounces, origin, beta * self.sky(&path.ray, origin));
                break;
            };
            let surface = evaluate_footprint(self.scene, &path.ray, path.cone, &hit);

            // Go straight through a partly transparent surface, by chance.
            if surface.lets_through(|| sampler.choice()) {
                let Some(passed) = path.pass_through(&hit) else { break };
                path = passed;
                self.rays.secondary += 1;
                // What is not there at all takes nothing of a shadow ray either.
                if let RayOrigin::Bsdf { .. } = origin
                    && surface.opacity > 0.0
                {
                    origin = RayOrigin::Transmitted;
                }
                continue;
            }
            if !self.options.picture.aovs.is_empty() && bounces + path.depth == 0 {
                self.first_hits.push(pixel, 1.0, &surface, None);
            }

            // Add the surface's own light, and direct light that it reflects.
            let radiance = beta * self.emission(&path.ray, &hit, &surface, origin);
            li.add_emission(bounces, origin, radiance);
            if matches!(origin, RayOrigin::Camera | RayOrigin::CameraMirror) && surface.is_unlit() {
                self.unlit.push(UnlitSample { pixel, radiance, part: beta.max_element().min(1.0) });
            }
            // The last bounce only looks for emitters.
            if bounces > self.options.transport.bounces {
                break;
            }
            if surface.diffuse != Vec3::ZERO {
                let point = surface.shading_point(beta, pixel);
                let aov = if bounces == 0 { Aov::Direct } else { Aov::Indirect };
                li.add(aov, point.weight * self.direct(&point, sampler));
            }

            // Choose the lobe to go on by.
            let mut lobes = surface.lobes();
            if bounces == self.options.transport.bounces && !self.emitters.can_be_hit(self.scene) {
                lobes.diffuse = Vec3::ZERO;
            }
            if path.depth >= self.options.transport.depth {
                lobes = lobes.without_specular();
            }
            let Some(sample) = lobes.sample(sampler.choice()) else { break };
            beta *= sample.throughput();
            match sample.lobe {
                Lobe::Diffuse if bounces == 0 => {
                    let point = surface.shading_point(beta, pixel);
                    self.split(&point, beta, sampler, &mut li);
                    break;
                }
                Lobe::Diffuse => {
                    let (ray, pdf) = sample_bounce(&surface.shading_point(beta, pixel), sampler);
                    bounces += 1;
                    path = PathRay::new(ray, Cone::POINT);
                    origin = RayOrigin::Bsdf { pdf };
                    self.rays.gather += 1;
                }
                Lobe::Specular(lobe) => {
                    path = path.spawn(&hit, &surface, lobe);
                    origin = match (origin, lobe) {
                        (RayOrigin::Camera, SpecularLobe::Transmission) => RayOrigin::Camera,
                        (RayOrigin::Camera | RayOrigin::CameraMirror, _) => RayOrigin::CameraMirror,
                        (_, SpecularLobe::Reflection) => RayOrigin::Specular,
                        (_, SpecularLobe::Transmission) => RayOrigin::Transmitted,
                    };
                    self.rays.secondary += 1;
                }
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

    /// Adds the mean of [`SPLITS`] paths that leave a point on the first diffuse surface with this throughput.
    fn split(&mut self, point: &ShadingPoint, beta: Vec3, sampler: &Sampler, li: &mut Radiance) {
        for branch in 0..SPLITS {
            let mut sampler = sampler.split(branch, SPLITS);
            let (ray, pdf) = sample_bounce(point, &mut sampler);
            self.rays.gather += 1;
            let (path, origin) = (PathRay::new(ray, Cone::POINT), RayOrigin::Bsdf { pdf });
            let part = self.follow(PathState { path, beta, bounces: 1, origin, pixel: point.id }, &mut sampler);
            li.add_part(part, 1.0 / SPLITS as f32);
        }
    }

    /// Estimates direct irradiance: from every punctual light, and, weighted against paths, from a point on an area
    /// light and a direction of the environment.
    fn direct(&mut self, point: &ShadingPoint, sampler: &mut Sampler) -> Vec3 {
        let (scene, falloff) = (self.scene, self.options.transport.falloff);
        let mut sum = Vec3::ZERO;
        if scene.emitters().light_radius > 0.0 {
            sum += self.emitters.sphere_lights(scene, falloff, point, sampler);
        } else {
            let lights = LightCut::all(&scene.emitters().punctual);
            let (irradiance, rays) = if scene.emitters().punctual.len() > self.most_rays as usize {
                let seed = (sampler.choice() * (1 << 24) as f32) as u32;
                self.few_rays.irradiance(scene, &lights, falloff, point, self.most_rays, seed)
            } else {
                self.scratch.irradiance(scene, &lights, falloff, point, 0)
            };
            self.rays.shadow += rays;
            sum += irradiance;
        }
        if !scene.mirrored_lights().is_empty() {
            let seed = (sampler.choice() * (1 << 24) as f32) as u32;
            sum += self.mirrored.irradiance(scene, falloff, point, MirroredLights::One { seed });
            self.rays.shadow += self.mirrored.take_rays();
        }
        sum += self.emitters.area(scene, falloff, point, sampler);
        sum += self.emitters.environment(scene, point, sampler);
        self.rays.shadow += self.emitters.take_rays();
        sum
    }

    /// The part of a surface's emission that counts at the end of a ray.
    fn emission(&self, ray: &Ray, hit: &Hit, surface: &ShadedHit, origin: RayOrigin) -> Vec3 {
        let area = &self.scene.emitters().area;
        let light = || area.pdf(self.scene.data(), hit, surface.position);
        match origin {
            RayOrigin::Camera | RayOrigin::CameraMirror => surface.emission,
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

    /// The part of the environment's radiance that counts at the end of a ray.
    fn sky(&self, ray: &Ray, origin: RayOrigin) -> Vec3 {
        if let RayOrigin::Camera = origin {
            return self.scene.backdrop(ray);
        }
        let Some(environment) = &self.scene.emitters().environment else { return Vec3::ZERO };
        let direction = ray.direction.normalize();
        let share = match origin {
            RayOrigin::Camera | RayOrigin::CameraMirror | RayOrigin::Specular => 1.0,
            RayOrigin::Bsdf { pdf } => power_heuristic(pdf, environment.pdf(direction)),
            RayOrigin::Transmitted => return Vec3::ZERO,
        };
        environment.radiance(direction) * share
    }
}

/// A ray from the point in a cosine-distributed direction about the shading normal, and its pdf, cosθ / π, which
/// cancels Lambert's cosine / π.
fn sample_bounce(point: &ShadingPoint, sampler: &mut Sampler) -> (Ray, f32) {
    let (t, b) = basis(point.n);
    let local = sample_cosine_hemisphere(sampler.next_pair());
    let direction = t * local.x + b * local.y + point.n * local.z;
    (Ray::new(point.light_origin(direction), direction), pdf_cosine_hemisphere(local.z))
}
