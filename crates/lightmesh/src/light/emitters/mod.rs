//! The emitters of a scene: emissive meshes and spheres, punctual lights, which may be sphere lights, and the
//! environment; and the point-like and directional samples that represent them.
//!
//! | emitter | samples |
//! |---|---|
//! | punctual light | itself; as a sphere light, N points of equal power in its ball ([`sphere`]) |
//! | emissive mesh, all its triangles together, or emissive sphere | patches with cosine emission: N, more where it is close to what it lights, fewer where it is small ([`AreaLights`]) |
//! | environment | N directions, more where it is bright ([`EnvironmentLight`]) |
//!
//! Each sample stands for a stratum of its emitter ([`Stratum`]). Weak emission, no brighter than lit walls, is left to
//! gather rays; so is that of user-defined shapes, which cannot be sampled. Double-sided surfaces shine from both sides,
//! the others from their front. Unlit surfaces show and light nothing.

mod area;
mod arrange;
mod bulb;
mod emission_bounds;
mod environment;
mod pieces;
mod primitive;
mod sky_cells;
pub(crate) mod sphere;
mod strata;
mod subdivision;
mod surroundings;

pub(crate) use area::AreaLights;
use arrange::{Arrangement, LightStrata};
pub(crate) use environment::EnvironmentLight;
use glam::{Vec2, Vec3};
use sphere::BallStrata;
use surroundings::Around;

use super::sample::{LightSample, SampledLight};
use super::samples::LightSamples;
use super::stratum::{LaneStratum, Stratum};
use crate::Error;
use crate::bvh::SceneBvh;
use crate::sampling::{hash, unit_f32};
use crate::scene::{EmitterOptions, Light, SceneData};

/// Most samples of all emitters together: 64 MiB of them.
const MAX_SAMPLES: u64 = 1 << 20;

/// The emitters of a scene.
#[derive(Debug)]
pub(crate) struct Emitters {
    /// Emissive meshes and spheres.
    pub area: AreaLights,
    /// The environment, unless it is black.
    pub environment: Option<EnvironmentLight>,
    /// Punctual lights alone, as points.
    pub punctual: LightSamples,
    /// Those of them that are parallel.
    pub suns: LightSamples,
    /// The samples of the mesh methods: of all emitters but those that are left to gather rays.
    pub sampled: LightSamples,
    /// The samples of all emitters; `None` where these are `sampled`.
    all: Option<LightSamples>,
    /// Radius of the sphere lights that punctual lights are, metres; 0: points.
    pub light_radius: f32,
    balls: BallStrata,
}

impl Emitters {
    /// Collects the emitters of a checked scene.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for options out of range or too many samples.
    pub(crate) fn new(data: &SceneData, bvh: &SceneBvh, options: &EmitterOptions) -> Result<Self, Error> {
        options.validate()?;
        // Limit the number of samples before they are made.
        let n = options.light_samples;
        let is_spherical = options.light_radius > 0.0;
        let mut area = AreaLights::new(data);
        let mut environment = data.environment.as_ref().and_then(EnvironmentLight::new);
        let spheres = if is_spherical { data.lights.len() as u64 } else { 0 };
        let sources = spheres + area.len() as u64 + u64::from(environment.is_some());
        if sources * u64::from(n) > MAX_SAMPLES {
            let what = format!(
                "{n} samples of each of {sources} emitters are more than the {MAX_SAMPLES} that are kept; choose fewer"
            );
            return Err(Error::InvalidOption { option: "light-samples", what });
        }
        // Sample the emitters.
        let point = |&light| (LightSample::Punctual(light), LaneStratum::default());
        let balls = BallStrata::new(if is_spherical { n } else { 0 });
        let mut samples: Vec<(LightSample, LaneStratum)> = match is_spherical {
            true => {
                (0..).zip(&data.lights).flat_map(|(i, light)| balls.lights(i, light, options.light_radius)).collect()
            }
            false => data.lights.iter().map(point).collect(),
        };
        let sky = environment.as_ref().map_or(0.0, |environment| environment.mean_luminance() as f32);
        let strata = arrange(&mut area, data, bvh, n, sky);
        samples.extend(strata.iter().flat_map(|light| &light.sampled));
        if let Some(environment) = &mut environment {
            samples.extend(environment.arrange(n));
        }
        let sampled = LightSamples::of_strata(&samples);
        let all = area.has_weak().then(|| {
            samples.extend(strata.iter().flat_map(|light| &light.weak));
            LightSamples::of_strata(&samples)
        });
        let punctual: Vec<LightSample> = data.lights.iter().map(|&light| LightSample::Punctual(light)).collect();
        let is_sun = |light: &&LightSample| matches!(light, LightSample::Punctual(Light::Directional { .. }));
        let suns = LightSamples::new(&punctual.iter().filter(is_sun).copied().collect::<Vec<_>>());
        let punctual = LightSamples::new(&punctual);
        Ok(Self { area, environment, punctual, suns, sampled, all, light_radius: options.light_radius, balls })
    }

    /// All samples, those of weak emitters too.
    pub(crate) fn all(&self) -> &LightSamples {
        self.all.as_ref().unwrap_or(&self.sampled)
    }

    /// Returns the point of a small ball that is opposite to [`Emitters::random_point`]'s, as seen from the position:
    /// `None` for all other lights. The mean of both has nearly no noise where all of the ball is visible.
    pub(crate) fn opposite_point(
        &self,
        lights: &LightSamples,
        lane: usize,
        at: Vec3,
        seed: u32,
    ) -> Option<SampledLight> {
        let Stratum::Bulb(bulb) = lights.stratum(lane) else { return None };
        let seed = hash(seed ^ hash(lane as u32));
        let u = |k: u32| unit_f32(hash(seed.wrapping_add(k)));
        let turned = u(1) + if u(1) < 0.5 { 0.5 } else { -0.5 };
        Some(self.area.bulb(bulb).sample(lights.sample(lane)?, at, Vec2::new(u(0), turned)))
    }

    /// Returns the k-th of `count` random directions, spread evenly, in the part of the sky that a lane's light stands for.
    pub(crate) fn sky_direction(
        &self,
        lights: &LightSamples,
        lane: usize,
        k: u32,
        count: u32,
        seed: u32,
    ) -> Option<SampledLight> {
        let Stratum::Sky(stratum) = lights.stratum(lane) else { return None };
        let seed = hash(seed ^ hash(lane as u32));
        self.environment.as_ref()?.sample_stratum(stratum, spread_evenly(k, count, seed))
    }

    /// Returns a random point of the stratum that a lane's light stands for, as a light that shines on a position, by a
    /// seed for that: its light there has the stratum's light as expectation. `None` where it gives none.
    pub(crate) fn random_point(
        &self,
        data: &SceneData,
        lights: &LightSamples,
        lane: usize,
        at: Vec3,
        seed: u32,
    ) -> Option<SampledLight> {
        let stratum = lights.stratum(lane);
        let seed = hash(seed ^ hash(lane as u32));
        let u = |k: u32| unit_f32(hash(seed.wrapping_add(k)));
        match stratum {
            Stratum::Point => lights.sample(lane),
            Stratum::Area(stratum) => self.area.sample_stratum(data, stratum, Vec2::new(u(0), u(1))),
            Stratum::Bulb(bulb) => Some(self.area.bulb(bulb).sample(lights.sample(lane)?, at, Vec2::new(u(0), u(1)))),
            Stratum::Sky(stratum) => self.environment.as_ref()?.sample_stratum(stratum, Vec2::new(u(0), u(1))),
            Stratum::Ball { light, part } => {
                let u = Vec3::new(u(0), u(1), u(2));
                Some(self.balls.sample_light(&data.lights[light as usize], part, self.light_radius, u))
            }
        }
    }
}

/// Returns the k-th of `count` numbers in [0, 1)² that are spread evenly, moved by a seed: Hammersley's set with a shift
/// (Cranley and Patterson 1976).
fn spread_evenly(k: u32, count: u32, seed: u32) -> Vec2 {
    let shift = Vec2::new(unit_f32(hash(seed)), unit_f32(hash(!seed)));
    let u = Vec2::new((k as f32 + 0.5) / count as f32, radical_inverse(k)) + shift;
    (u - u.floor()).min(Vec2::splat(1.0 - f32::EPSILON))
}

/// Samples of all lights by which the surroundings of each are judged, and of one of them.
const JUDGING: u32 = 1024;
const JUDGING_PER_LIGHT: u32 = 16;

/// Divides area lights into strata, as many as their surroundings ask for if a usual light gets `n` of them.
fn arrange(area: &mut AreaLights, data: &SceneData, bvh: &SceneBvh, n: u32, sky: f32) -> Vec<LightStrata> {
    let count = area.len();
    if count == 0 {
        return Vec::new();
    }
    // Light the surroundings by few samples of every light.
    let few = (JUDGING / count as u32).clamp(1, JUDGING_PER_LIGHT);
    let strata = area.arrange(data, &vec![Arrangement { strata: [few, 0], weak_below: 0.0, is_small: false }; count]);
    let patches = strata.iter().flat_map(|light| &light.sampled).map(|(sample, _)| *sample);
    let points = data.lights.iter().map(|&light| LightSample::Punctual(light));
    let mut lights: Vec<SampledLight> = patches.chain(points).map(|sample| SampledLight::of(&sample)).collect();
    lights.sort_by(|a, b| luminance(b.intensity).total_cmp(&luminance(a.intensity)));
    lights.truncate(2 * JUDGING as usize);
    let around = Around { data, bvh, lights: &lights, sky };
    let surroundings: Vec<_> = (0..count).map(|light| around.survey(area, light)).collect();

    // Choose how many strata each gets; if they were too many in all, none gets more than the usual number.
    let wanted = |most: u32| -> Vec<Arrangement> {
        let arrangement = |(light, around): (usize, &surroundings::Surroundings)| {
            let bright = area.bright_area(light, around.weak_below);
            let samples = around.samples(bright, n).min(most);
            Arrangement { strata: [samples, n], weak_below: around.weak_below, is_small: around.is_small(bright) }
        };
        surroundings.iter().enumerate().map(arrangement).collect()
    };
    let mut arrangements = wanted(u32::MAX);
    let sum: u64 = arrangements.iter().map(|a| u64::from(a.strata[0])).sum();
    if sum > MANY.max(u64::from(n) * count as u64) {
        arrangements = wanted(n);
    }
    area.arrange(data, &arrangements)
}

/// Strata of all lights together, more of which none gets because it is close to what it lights.
const MANY: u64 = 1 << 14;

/// Returns the Rec. 709 luminance of linear RGB.
pub(crate) fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns i / 2³² with the bits of i reversed: van der Corput's sequence, in [0, 1).
pub(crate) fn radical_inverse(i: u32) -> f32 {
    unit_f32(i.reverse_bits())
}
