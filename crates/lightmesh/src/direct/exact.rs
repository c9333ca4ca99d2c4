//! Exact direct light: a shadow ray to every light sample that the surface faces ("standard tracing").

use glam::Vec3;

use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{ShadingPoint, VisibilityScratch, visibility};
use crate::light::{Directions, LightCut, Stratum, shadow_ray_to};
use crate::sampling::{hash, seed_of_position};
use crate::world::Scene;

/// Sums light exactly, with buffers that it keeps; one per worker.
#[derive(Debug, Default)]
pub(crate) struct ExactShader {
    directions: Directions,
    light: Vec<Vec3>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl ExactShader {
    /// Returns Σ_i V_i φ2 E_i / φ3 over the lights of a cut: formula (2) with exact visibility, lux per channel; and
    /// the number of shadow rays. The ray to a light that stands for a part of an emitter goes to a random point of that
    /// part, by the seed: the expectation is exact.
    pub(crate) fn irradiance(
        &mut self,
        scene: &Scene,
        cut: &LightCut<'_>,
        falloff: Falloff,
        vertex: &ShadingPoint,
        seed: u32,
    ) -> (Vec3, u64) {
        let lights = cut.lights();
        lights.directions(scene.simd_level(), falloff, vertex.position, &mut self.directions);

        // Make a ray to each light that is in front of the surface and has it in its cone and range.
        self.light.clear();
        self.rays.clear();
        let d = &self.directions;
        let seed = hash(seed ^ seed_of_position(vertex.position));
        for lane in 0..lights.lanes() {
            let intensity = lights.intensity(lane);
            if intensity == Vec3::ZERO {
                continue;
            }
            if lights.stratum(lane) != Stratum::Point {
                let Some(light) = scene.random_light(lights, lane, vertex.position, seed) else { continue };
                let opposite = scene.emitters().opposite_point(lights, lane, vertex.position, seed);
                let share = if opposite.is_some() { 0.5 } else { 1.0 };
                for light in std::iter::once(light).chain(opposite) {
                    let (direction, f) = light.arriving(falloff, vertex.position);
                    let term = vertex.n.dot(direction) * f;
                    if term > 0.0 {
                        self.light.push(light.intensity * (term * share));
                        self.rays.push(shadow_ray_to(&light, vertex.light_origin(direction)));
                    }
                }
                continue;
            }
            let direction = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]);
            let term = vertex.n.dot(direction) * d.f[lane];
            if term > 0.0 {
                self.light.push(intensity * term);
                self.rays.push(cut.shadow_ray(lane, vertex.light_origin(direction)));
            }
        }

        // Trace the rays and sum.
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        let sum = self.light.iter().zip(&self.visible).map(|(&light, &v)| light * v).sum();
        (sum, self.rays.len() as u64)
    }
}
