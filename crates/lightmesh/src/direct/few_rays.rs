//! Direct light by a few shadow rays where the mesh knows nothing: light sampling without a control variate.

use glam::Vec3;

use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{ShadingPoint, VisibilityScratch, visibility};
use crate::light::{Directions, LightCut, Stratum, shadow_ray_to};
use crate::sampling::{hash, seed_of_position, unit_f32};
use crate::world::Scene;

/// The least that is expected of a part of an emitter, in units of what it gave if its middle were as high above the
/// surface as the part's radius. Not varied.
const LEAST: f32 = 0.1;

/// Estimates light with few rays, with buffers that it keeps; one per worker.
#[derive(Debug, Default)]
pub(crate) struct FewRaysShader {
    directions: Directions,
    /// The lights that the surface faces: lanes, and their unshadowed light on it.
    lanes: Vec<u32>,
    terms: Vec<Vec3>,
    /// Running sums of the largest channels of `terms`.
    sums: Vec<f32>,
    weights: Vec<Vec3>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl FewRaysShader {
    /// Returns an unbiased estimate of Σ_i V_i c_i over the lights of a cut, lux per channel, with at most `most`
    /// shadow rays, and the number of rays: one to each light where so many suffice, else to lights chosen in
    /// proportion to their unshadowed light c_i, stratified over the list.
    pub(crate) fn irradiance(
        &mut self,
        scene: &Scene,
        cut: &LightCut<'_>,
        falloff: Falloff,
        vertex: &ShadingPoint,
        most: u32,
        seed: u32,
    ) -> (Vec3, u64) {
        // List the lights that are in front of the surface.
        let lights = cut.lights();
        lights.directions(scene.simd_level(), falloff, vertex.position, &mut self.directions);
        self.lanes.clear();
        self.terms.clear();
        self.sums.clear();
        let (d, mut total) = (&self.directions, 0.0);
        for lane in 0..lights.lanes() {
            // A part of an emitter may reach above the horizon although its middle does not.
            let cos = vertex.n.dot(Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]));
            let radius = lights.radius(lane);
            let term = if cos + radius > 0.0 { cos.max(LEAST * radius) * d.f[lane] } else { 0.0 };
            if term > 0.0 && lights.intensity(lane) != Vec3::ZERO {
                let light = lights.intensity(lane) * term;
                total += light.max_element();
                self.lanes.push(lane as u32);
                self.terms.push(light);
                self.sums.push(total);
            }
        }

        // Choose those that get a ray.
        self.rays.clear();
        self.weights.clear();
        let direction = |lane: usize| Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]);
        let seed_of_places = hash(seed ^ seed_of_position(vertex.position));
        let mut ray_to = |i: usize, k: u32, scale: f32| {
            let lane = self.lanes[i] as usize;
            if lights.stratum(lane) == Stratum::Point {
                self.rays.push(cut.shadow_ray(lane, vertex.light_origin(direction(lane))));
                self.weights.push(self.terms[i] * scale);
            } else if let Some(light) = scene.random_light(lights, lane, vertex.position, seed_of_places ^ hash(k)) {
                // A random point of the part of the emitter that the lane stands for.
                let (towards, f) = light.arriving(falloff, vertex.position);
                self.rays.push(shadow_ray_to(&light, vertex.light_origin(towards)));
                self.weights.push(light.intensity * (vertex.n.dot(towards) * f).max(0.0) * scale);
            }
        };
        if self.terms.len() <= most as usize {
            (0..self.terms.len()).for_each(|i| ray_to(i, 0, 1.0));
        } else {
            for k in 0..most {
                let u = (k as f32 + unit_f32(hash(seed ^ hash(k)))) / most as f32;
                let i = self.sums.partition_point(|&sum| sum <= u * total).min(self.terms.len() - 1);
                let p = self.terms[i].max_element() / total * most as f32;
                ray_to(i, k, 1.0 / p);
            }
        }

        // Trace the rays and sum.
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        let sum = self.weights.iter().zip(&self.visible).map(|(&weight, &v)| weight * v).sum();
        (sum, self.rays.len() as u64)
    }
}
