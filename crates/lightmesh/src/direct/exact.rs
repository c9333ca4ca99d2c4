//! Exact direct light: a shadow ray to every light sample that the surface faces ("standard tracing").

use glam::Vec3;

use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{ShadingPoint, VisibilityScratch, visibility};
use crate::light::{Directions, LightCut};
use crate::world::Scene;

/// Sums light exactly, with buffers that it keeps; one per worker.
#[derive(Debug, Default)]
pub(crate) struct ExactShader {
    directions: Directions,
    lanes: Vec<u32>,
    terms: Vec<f32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl ExactShader {
    /// Returns Σ_i V_i φ2 E_i / φ3 over the lights of a cut: formula (2) with exact visibility, lux per channel; and
    /// the number of shadow rays.
    pub(crate) fn irradiance(
        &mut self,
        scene: &Scene,
        cut: &LightCut<'_>,
        falloff: Falloff,
        vertex: &ShadingPoint,
    ) -> (Vec3, u64) {
        let lights = cut.lights();
        lights.directions(scene.simd_level(), falloff, vertex.position, &mut self.directions);

        // Make a ray to each light that is in front of the surface and has it in its cone and range.
        self.lanes.clear();
        self.terms.clear();
        self.rays.clear();
        let d = &self.directions;
        for lane in 0..lights.lanes() {
            let direction = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]);
            let term = vertex.n.dot(direction) * d.f[lane];
            if term > 0.0 && lights.intensity(lane) != Vec3::ZERO {
                self.lanes.push(lane as u32);
                self.terms.push(term);
                self.rays.push(cut.shadow_ray(lane, vertex.light_origin(direction)));
            }
        }

        // Trace the rays and sum.
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        let mut sum = Vec3::ZERO;
        for ((&lane, &term), &v) in self.lanes.iter().zip(&self.terms).zip(&self.visible) {
            sum += lights.intensity(lane as usize) * v * term;
        }
        (sum, self.rays.len() as u64)
    }
}
