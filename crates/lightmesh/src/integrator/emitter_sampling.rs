//! Random samples of emitters that have a size, for the path tracer.

use glam::Vec3;

use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{ShadingPoint, VisibilityScratch, visibility};
use crate::light::sample_unit_ball;
use crate::sampling::{Sampler, pdf_cosine_hemisphere};
use crate::scene::Light;
use crate::world::Scene;

/// A shadow ray to a point on a surface stops this part of its length short of it.
const SEGMENT_END: f32 = 1.0 - 1e-4;

/// The weight of a sample of density `pdf`, where another sampler would have found it with density `other` (Veach
/// 1997, section
/// 9.2.4, β = 2).
pub(super) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    if pdf == 0.0 {
        return 0.0;
    }
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

/// Samples emitters that have a size, and counts its shadow rays.
#[derive(Debug, Default)]
pub(super) struct EmitterSampler {
    rays: u64,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl EmitterSampler {
    /// Whether a ray that leaves a diffuse surface may meet emission that counts.
    pub(super) fn can_be_hit(&self, scene: &Scene) -> bool {
        let emitters = scene.emitters();
        !emitters.area.is_dark() || emitters.environment.is_some() || scene.has_unsampled_emitters()
    }

    /// Returns the shadow rays since the last call.
    pub(super) fn take_rays(&mut self) -> u64 {
        std::mem::take(&mut self.rays)
    }

    /// Estimates the irradiance from all area lights with one point on them.
    pub(super) fn area(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        point: &ShadingPoint,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let lights = &scene.emitters().area;
        if lights.is_dark() {
            return Vec3::ZERO;
        }
        let Some(emitter) = lights.sample(scene.data(), sampler.next_pair()) else { return Vec3::ZERO };
        let d = emitter.position - point.position;
        let r2 = d.length_squared();
        let direction = d / r2.sqrt();
        let (cos, ahead) = (point.n.dot(direction), -emitter.normal.dot(direction));
        let cos_light = if emitter.two_sided { ahead.abs() } else { ahead };
        if cos.is_nan() || cos <= 0.0 || cos_light <= 0.0 {
            return Vec3::ZERO;
        }
        let ray = Ray { t_max: SEGMENT_END, ..Ray::segment(point.light_origin(direction), emitter.position) };
        let v = self.visibility(scene, ray);
        if v == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let weight = self.weight(v, emitter.pdf * r2 / cos_light, cos);
        let attenuation = falloff.attenuation(r2, r2.sqrt());
        emitter.emission * v * (cos * cos_light * attenuation / emitter.pdf * weight)
    }

    /// Estimates the irradiance from the environment with one direction.
    pub(super) fn environment(&mut self, scene: &Scene, point: &ShadingPoint, sampler: &mut Sampler) -> Vec3 {
        let Some(environment) = &scene.emitters().environment else { return Vec3::ZERO };
        let (direction, pdf) = environment.sample(sampler.next_pair());
        let cos = point.n.dot(direction);
        if cos <= 0.0 || pdf <= 0.0 {
            return Vec3::ZERO;
        }
        let v = self.visibility(scene, Ray::new(point.light_origin(direction), direction));
        if v == Vec3::ZERO {
            return Vec3::ZERO;
        }
        environment.radiance(direction) * v * (cos / pdf * self.weight(v, pdf, cos))
    }

    /// Estimates the irradiance from punctual lights with one point in the sphere of each.
    pub(super) fn sphere_lights(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        point: &ShadingPoint,
        sampler: &mut Sampler,
    ) -> Vec3 {
        let radius = scene.emitters().light_radius;
        let mut sum = Vec3::ZERO;
        for light in &scene.data().lights {
            let u = Vec3::new(sampler.next(), sampler.next(), sampler.next());
            let light = light.moved(sample_unit_ball(u) * radius);
            let (towards, illuminance) = light.arriving(falloff, point.position);
            let cos = point.n.dot(towards.normalize_or_zero());
            if cos <= 0.0 || illuminance == Vec3::ZERO {
                continue;
            }
            let t_max = if matches!(light, Light::Directional { .. }) { f32::INFINITY } else { SEGMENT_END };
            let ray = Ray { t_max, ..Ray::new(point.light_origin(towards), towards) };
            sum += illuminance * self.visibility(scene, ray) * cos;
        }
        sum
    }

    /// The weight of a light sample of density `pdf` (per steradian) at angle `cos`. Where the shadow ray went through
    /// glass or partly transparent surfaces, no bounce counts the light.
    fn weight(&self, v: Vec3, pdf: f32, cos: f32) -> f32 {
        if v == Vec3::ONE { power_heuristic(pdf, pdf_cosine_hemisphere(cos)) } else { 1.0 }
    }

    fn visibility(&mut self, scene: &Scene, ray: Ray) -> Vec3 {
        self.rays += 1;
        visibility(scene, &[ray], &mut self.shadow, &mut self.visible);
        self.visible[0]
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;

    #[test]
    fn the_weights_of_both_samplers_sum_to_one() {
        for (a, b) in [(0.1, 3.0), (1e-3, 1e4), (PI, PI), (2.0, 0.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6);
        }
        assert_eq!((power_heuristic(0.0, 1.0), power_heuristic(1.0, f32::INFINITY)), (0.0, 0.0));
    }
}
