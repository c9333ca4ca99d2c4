//! What is around an area light: how near the surfaces are that it lights, and how bright they are.
//!
//! Rays from the light find these surfaces; nothing here depends on the size of the scene. From the distance follows how
//! many samples the light needs. Emission that is about as bright as what it shines on is *weak*: it needs none, because
//! gather rays meet it often enough. What counts is what shines there itself, and the light of brighter lamps. A panel
//! close to a floor makes that as bright as itself, and is not weak for that: the light below it has edges that the
//! indirect mesh, with its spacing, would blur (16% too much under a panel of 2 × 2 m at 0.5 m).

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::super::sample::{LightEmission, SampledLight};
use super::area::AreaLights;
use super::{luminance, radical_inverse};
use crate::Falloff;
use crate::bvh::{Hit, SceneBvh, Target};
use crate::geometry::Ray;
use crate::sampling::{basis, hash, sample_cosine_hemisphere, unit_f32};
use crate::scene::SceneData;

/// An emitter is weak where its luminance is at most this many times that of the surfaces around, if these were white.
/// It is then about as bright as a well-lit wall, and gather rays find its light. A box that glows all over has 1; the
/// bound is a choice, not measured.
const WEAK_TIMES_WALL: f32 = 4.0;

/// Light counts as that of a brighter lamp if it has so many times the luminance. A choice, not measured.
const BRIGHTER: f32 = 4.0;

/// Rays from all lights together, and from one.
const RAYS: u32 = 4096;
const RAYS_PER_LIGHT: std::ops::RangeInclusive<u32> = 8..=64;

/// Lights whose shadow counts where a ray ends.
const SHADOWS: usize = 6;

/// Part of the rays that end where it is as dark as around the light, or darker: what is close to a lamp is as bright as
/// the lamp.
const DARK: f32 = 0.33;

/// Parts of the rays that end nearer than what counts as near, and of those that meet anything, as usual.
const NEAR: f32 = 0.15;
const USUAL: f32 = 0.5;

/// A light gets fewer samples where the square root of its area over the usual distance is below the first, and more
/// where that over the near distance is above the second. A panel of 1 m² in a room has about 0.5.
const SMALL: f32 = 0.5;
const CLOSE: f32 = 2.0;

/// Limits of how many times the usual number a light gets.
const FACTOR: [f32; 2] = [0.125, 32.0];

/// A light of so small an area, against the square of the usual distance, casts shadows as a point does.
const POINT: f32 = 0.04;

/// What rays from a light found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings {
    /// Distance of near surfaces, metres; infinite where there are none.
    pub near: f32,
    /// The usual distance of surfaces, metres.
    pub usual: f32,
    /// The same, where rays that meet nothing count as infinite.
    pub with_open: f32,
    /// Up to this luminance emission is weak, cd/m².
    pub weak_below: f32,
}

/// What the light at a surface is summed from.
pub(super) struct Around<'a> {
    pub data: &'a SceneData,
    pub bvh: &'a SceneBvh,
    /// Few samples of every light.
    pub lights: &'a [SampledLight],
    /// Mean luminance of the environment, cd/m².
    pub sky: f32,
}

impl Around<'_> {
    /// Looks around a light by rays from it.
    pub(super) fn survey(&self, area: &AreaLights, light: usize) -> Surroundings {
        let count = (RAYS / area.len().max(1) as u32).clamp(*RAYS_PER_LIGHT.start(), *RAYS_PER_LIGHT.end());
        let (mut distances, mut walls) = (Vec::new(), Vec::new());
        let mut scratch = Vec::new();
        for i in 0..count {
            let u = Vec2::new((i as f32 + 0.5) / count as f32, radical_inverse(i));
            let Some(point) = area.sample_light(self.data, light, u) else { continue };
            // Shoot in proportion to what leaves there, from both sides where both shine.
            let side = if point.two_sided && i % 2 == 1 { -1.0 } else { 1.0 };
            let n = point.normal * side;
            let (t, b) = basis(n);
            let local = sample_cosine_hemisphere(Vec2::new(unit_f32(hash(2 * i)), unit_f32(hash(2 * i + 1))));
            let direction = t * local.x + b * local.y + n * local.z;
            let start = 1e-4 / point.pdf.max(1e-20).sqrt();
            let ray = Ray { t_min: start, ..Ray::new(point.position, direction) };
            match self.bvh.closest(&ray) {
                Some(hit) => {
                    distances.push(hit.t);
                    let from = ray.at(hit.t);
                    let normal = self.normal(&hit, from, direction);
                    let own = luminance(point.emission);
                    let illuminance = self.illuminance(from + normal * (1e-3 * hit.t), normal, own, &mut scratch);
                    walls.push((illuminance * FRAC_1_PI).max(area.luminance_at(self.data, &hit, from)));
                }
                None => {
                    distances.push(f32::INFINITY);
                    walls.push(self.sky);
                }
            }
        }
        let quantile = |values: &mut Vec<f32>, part: f32, otherwise: f32| {
            values.sort_unstable_by(f32::total_cmp);
            values.get((part * values.len() as f32) as usize).copied().unwrap_or(otherwise)
        };
        let near = quantile(&mut distances, NEAR, f32::INFINITY);
        let with_open = quantile(&mut distances, USUAL, f32::INFINITY);
        // In the open it is the ground that counts, not the rays that leave.
        distances.retain(|t| t.is_finite());
        Surroundings {
            near,
            usual: quantile(&mut distances, USUAL, f32::INFINITY),
            with_open,
            weak_below: WEAK_TIMES_WALL * quantile(&mut walls, DARK, 0.0),
        }
    }

    /// Returns the unit normal where a ray ended, on the side from which it came.
    fn normal(&self, hit: &Hit, position: Vec3, direction: Vec3) -> Vec3 {
        let n = match hit.target {
            Target::Triangle { instance, triangle } => {
                let instance = &self.data.instances[instance as usize];
                let mesh = &self.data.meshes[instance.mesh];
                let [a, b, c] = mesh.triangles[triangle as usize]
                    .map(|v| instance.world_from_object.transform_point3(mesh.positions[v as usize]));
                (b - a).cross(c - a).normalize_or(-direction)
            }
            Target::Sphere(i) => self.data.spheres[i as usize].normal(position),
            Target::Shape(_) => -direction,
        };
        if n.dot(direction) > 0.0 { -n } else { n }
    }

    /// Returns the illuminance at a surface, lux, by lights that are brighter than luminance `own`, cd/m²: of the
    /// strongest ones with their shadows, as if the others were hidden alike.
    fn illuminance(&self, position: Vec3, n: Vec3, own: f32, arriving: &mut Vec<(f32, usize)>) -> f32 {
        arriving.clear();
        let mut all = 0.0;
        for (i, light) in self.lights.iter().enumerate().filter(|(_, light)| is_brighter(light, own)) {
            let (d, f) = light.arriving(Falloff::InverseSquare, position);
            let e = luminance(light.intensity) * f * d.dot(n).max(0.0);
            if e > 0.0 {
                all += e;
                arriving.push((e, i));
            }
        }
        let strongest = arriving.len().min(SHADOWS);
        if strongest == 0 {
            return 0.0;
        }
        arriving.select_nth_unstable_by(strongest - 1, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let (mut sum, mut visible) = (0.0, 0.0);
        for &(e, i) in &arriving[..strongest] {
            let light = &self.lights[i];
            let ray = match light.emission {
                LightEmission::Directional => Ray::new(position, light.position),
                _ => Ray { t_max: 0.999, ..Ray::segment(position, light.position) },
            };
            sum += e;
            visible += if self.bvh.occluded(&ray) { 0.0 } else { e };
        }
        all * visible / sum
    }
}

/// Whether a light is brighter by far than a luminance, cd/m²; a point is brighter than any.
fn is_brighter(light: &SampledLight, own: f32) -> bool {
    match light.emission {
        LightEmission::Patch { area_over_pi, .. } => {
            luminance(light.intensity) >= BRIGHTER * own * area_over_pi * std::f32::consts::PI
        }
        _ => true,
    }
}

impl Surroundings {
    /// Whether a light of this area is so small that a point may stand for it in the mesh.
    pub(super) fn is_small(&self, area: f32) -> bool {
        area < POINT * self.with_open * self.with_open
    }

    /// Returns how many samples a light of an area needs, if `usual` is the number for a usual one.
    pub(super) fn samples(&self, area: f32, usual: u32) -> u32 {
        let close = area.sqrt() / self.near / CLOSE;
        let small = (area.sqrt() / self.usual / SMALL).clamp(FACTOR[0], 1.0);
        let factor = if close > 1.0 { close.min(FACTOR[1]) } else { small };
        ((usual as f32 * factor).round() as u32).max(1)
    }
}
