//! The lights that shine on one mesh point, and how much of each arrives there: V_i of formula (1).

use std::ops::RangeInclusive;

use glam::Vec3;

use super::sky_views::SkyAround;
use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::light::{Directions, LightCut, SKY, Stratum, shadow_ray_to};
use crate::sampling::{hash, seed_of_position};
use crate::world::Scene;

/// Traces the lights of mesh points, one point after the other, with buffers that it keeps.
#[derive(Debug)]
pub(super) struct PointLights<'a> {
    scene: &'a Scene,
    cut: LightCut<'a>,
    falloff: Falloff,
    shadow_rays: u64,
    directions: Directions,
    lanes: Vec<u32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
    /// Rays to the sky, part by part.
    sky: Vec<SkyRay>,
    ray_visible: Vec<Vec3>,
}

/// A ray to a random direction in a part of the sky.
#[derive(Clone, Copy, Debug)]
struct SkyRay {
    /// Its place among the lanes that shine on the point.
    index: usize,
    light: PointLight,
    /// Whether some of the part is visible around the point, and some not.
    is_mixed: bool,
}

/// The variance that the light of the sky may have at a point, in squares of what arrives; and from it, within bounds,
/// the rays to a part whose noise, if one ray had it, is as much as all that arrives. Empirical: with 192 and at most 64
/// a room behind a window had 7.8% error, with these 5.4%.
const SKY_VARIANCE: f32 = 0.0025;
const SKY_RAYS: RangeInclusive<f32> = 96.0..=448.0;
const SKY_RAYS_PER_PART: f32 = 128.0;

/// The most where it is only a guess that some of it may be visible: one ray that meets the rim of a window by chance
/// brought a whole part's light, a bright dot on the floor. Empirical.
const SKY_RAYS_PER_RIM: f32 = 16.0;

/// Of parts that are all visible around a point whose lights are summed, one in so many has its ray, which stands for the
/// others: out of doors, most are. Empirical.
const CLEAR_PARTS: u32 = 4;

/// A light as a mesh point receives it: unshadowed, a plane of normal n gets `intensity` · `f` · (n · `direction`) of
/// it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLight {
    pub intensity: Vec3,
    pub f: f32,
    /// From the point to the light, not normalised.
    pub direction: Vec3,
    /// V_i, the part that arrives, per channel.
    pub visible: Vec3,
    /// [`LightSamples::part`](crate::light::LightSamples::part).
    pub part: usize,
}

impl<'a> PointLights<'a> {
    /// No point yet; `cut` has the lights of the scene.
    pub(super) fn new(scene: &'a Scene, cut: LightCut<'a>, falloff: Falloff) -> Self {
        Self {
            scene,
            cut,
            falloff,
            shadow_rays: 0,
            directions: Directions::default(),
            lanes: Vec::new(),
            rays: Vec::new(),
            visible: Vec::new(),
            shadow: VisibilityScratch::default(),
            sky: Vec::new(),
            ray_visible: Vec::new(),
        }
    }

    /// Returns how many shadow rays have been traced so far.
    pub(super) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    /// Traces a shadow ray from the point at `x` to every light that shines on it, and several to parts of the sky:
    /// `around` has how much is visible of each in the neighbourhood, if there is a sky. `summed`: only the sum over the
    /// lights counts.
    pub(super) fn trace(&mut self, x: Vec3, around: Option<SkyAround<'_>>, summed: bool) {
        self.cut.set_receiver(x, self.falloff);
        let lights = self.cut.lights();
        lights.directions(self.scene.simd_level(), self.falloff, x, &mut self.directions);
        self.lanes.clear();
        self.rays.clear();
        for lane in 0..lights.lanes() {
            if self.directions.f[lane] > 0.0 && lights.intensity(lane) != Vec3::ZERO {
                self.lanes.push(lane as u32);
                self.rays.push(self.cut.shadow_ray(lane, x));
            }
        }
        match around {
            None => visibility(self.scene, &self.rays, &mut self.shadow, &mut self.visible),
            Some(around) => self.trace_with_sky(x, around, summed),
        }
        self.shadow_rays += self.rays.len() as u64;
    }

    /// Traces shadow rays to random directions in each part of the sky that shines on the point, more to parts of which
    /// something is visible and something not, by what is seen `around`. The same few directions everywhere would throw
    /// sharp pictures of a window on the walls behind it.
    fn trace_with_sky(&mut self, x: Vec3, around: SkyAround<'_>, summed: bool) {
        // Find out how much arrives from the whole sky, and drop the rays to the middle of its parts.
        let lights = self.cut.lights();
        let is_sky = |lane: u32| matches!(lights.stratum(lane as usize), Stratum::Sky(_));
        let strength = |lane: u32| lights.intensity(lane as usize).element_sum();
        let sky_lanes = || self.lanes.iter().copied().filter(|&lane| is_sky(lane));
        let arriving: f32 = sky_lanes().map(|lane| strength(lane) * around.of(lane)).sum();
        // The noise of a part, if one ray had it. With rays in proportion to it, the variance is its sum over their number.
        let noise = |lane: u32, q: f32| strength(lane) * (q * (1.0 - q)).sqrt() / arriving.max(f32::MIN_POSITIVE);
        let sum: f32 = sky_lanes().map(|lane| noise(lane, around.of(lane))).sum();
        let sky_rays = (sum / SKY_VARIANCE).clamp(*SKY_RAYS.start(), *SKY_RAYS.end());
        let mut lanes = self.lanes.iter();
        self.rays.retain(|_| lanes.next().is_some_and(|&lane| !is_sky(lane)));

        // Shoot as many rays to each part as its noise asks for.
        let seed = hash(seed_of_position(x));
        let singles = self.rays.len();
        let mut clear_parts = hash(seed) % CLEAR_PARTS;
        self.sky.clear();
        for (index, &lane) in self.lanes.iter().enumerate() {
            if !is_sky(lane) {
                continue;
            }
            let (known, q) = (around.of(lane), around.guess(lane));
            let mut share = 1.0;
            if summed && q == 1.0 {
                clear_parts += 1;
                if !clear_parts.is_multiple_of(CLEAR_PARTS) {
                    continue;
                }
                share = CLEAR_PARTS as f32;
            }
            let most = if known == q { SKY_RAYS_PER_PART } else { SKY_RAYS_PER_RIM };
            let count = (sky_rays * noise(lane, q)).ceil().clamp(1.0, most);
            for k in 0..count as u32 {
                let light = self.scene.emitters().sky_direction(lights, lane as usize, k, count as u32, seed);
                let Some(light) = light else { continue };
                self.rays.push(shadow_ray_to(&light, x));
                let light = PointLight {
                    intensity: light.intensity * (share / count),
                    f: 1.0,
                    direction: light.position,
                    visible: Vec3::ZERO,
                    part: SKY,
                };
                self.sky.push(SkyRay { index, light, is_mixed: known > 0.0 && known < 1.0 });
            }
        }
        visibility(self.scene, &self.rays, &mut self.shadow, &mut self.ray_visible);

        // None or all of a part is visible only where that is so all around.
        let mut rays = self.ray_visible[singles..].iter();
        let mut single = self.ray_visible[..singles].iter();
        self.visible.clear();
        self.visible.extend(self.lanes.iter().map(|&lane| {
            let of_single = if is_sky(lane) { None } else { single.next() };
            of_single.copied().unwrap_or_default()
        }));
        for part in self.sky.chunk_by_mut(|a, b| a.index == b.index) {
            let mut sum = Vec3::ZERO;
            for ray in part.iter_mut() {
                ray.light.visible = rays.next().copied().unwrap_or_default();
                sum += ray.light.visible;
            }
            let mean = sum / part.len() as f32;
            let is_mixed = part[0].is_mixed && (mean == Vec3::ZERO || mean == Vec3::ONE);
            self.visible[part[0].index] = if is_mixed { Vec3::splat(0.5) } else { mean };
        }
    }

    /// Returns the lights that shine on the point traced last, parts of the sky ray by ray.
    pub(super) fn iter(&self) -> impl Iterator<Item = PointLight> {
        let Directions { dx, dy, dz, f } = &self.directions;
        let lights = self.cut.lights();
        let has_sky = !self.sky.is_empty();
        let single = self.lanes.iter().zip(&self.visible).filter_map(move |(&lane, &visible)| {
            let lane = lane as usize;
            if has_sky && matches!(lights.stratum(lane), Stratum::Sky(_)) {
                return None;
            }
            let direction = Vec3::new(dx[lane], dy[lane], dz[lane]);
            let part = lights.part(lane);
            Some(PointLight { intensity: lights.intensity(lane), f: f[lane], direction, visible, part })
        });
        single.chain(self.sky.iter().map(|ray| ray.light))
    }

    /// Returns the lanes of these lights, ascending.
    pub(super) fn lanes(&self) -> &[u32] {
        &self.lanes
    }

    /// Returns V_i of these lights, per channel.
    pub(super) fn visible(&self) -> &[Vec3] {
        &self.visible
    }

    /// Returns the lights that a lane stands for, as an interval of the light tree's leaves.
    pub(super) fn leaves(&self, lane: u32) -> std::ops::Range<u32> {
        self.cut.leaves(lane as usize)
    }
}
