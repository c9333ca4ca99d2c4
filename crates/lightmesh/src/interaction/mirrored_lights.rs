//! Lamps seen in plane mirrors: each is a lamp at its mirror image, which shines through the mirror as through a window.

use glam::Vec3;

use super::surface::{ShadingPoint, evaluate};
use super::transmittance::{VisibilityScratch, visibility};
use crate::Falloff;
use crate::geometry::Ray;
use crate::light::PlaneMirror;
use crate::sampling::{hash, unit_f32};
use crate::scene::Light;
use crate::world::Scene;

/// The last part of a shadow ray to a lamp is left out.
const SEGMENT_END: f32 = 1.0 - 1e-4;

/// The cosine of mirrors' normals with a plane's, at least.
const SAME_NORMAL: f32 = 0.999;

/// Which lamps in mirrors a surface looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MirroredLights {
    /// All of them.
    All,
    /// One, by chance in proportion to its unshadowed light: for the many hits of gather rays.
    One { seed: u32 },
}

/// Sums the light of lamps in mirrors, with buffers that it keeps; one per worker.
#[derive(Debug, Default)]
pub(crate) struct MirroredShader {
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
    candidates: Vec<Candidate>,
    /// Rays since they were last taken.
    rays: u64,
}

/// A lamp in a mirror as a surface may see it.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    light: Light,
    mirror: PlaneMirror,
    /// Towards the image: with its length, or unit if the lamp is infinitely far.
    towards: Vec3,
    /// Irradiance, were the mirror perfect and nothing in between, lux.
    irradiance: Vec3,
}

impl MirroredShader {
    /// Returns the irradiance from punctual lights by way of one plane mirror, lux per channel.
    pub(crate) fn irradiance(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        point: &ShadingPoint,
        which: MirroredLights,
    ) -> Vec3 {
        // List the lamps whose rays may arrive.
        self.candidates.clear();
        for &(light, mirror) in scene.mirrored_lights() {
            let (towards, illuminance) = mirror.image_of_light(&light).arriving(falloff, point.position);
            let cos = point.n.dot(towards.normalize_or_zero());
            let height = mirror.height(point.position);
            let lamp_height = match light {
                Light::Point { position, .. } | Light::Spot { position, .. } => mirror.height(position),
                Light::Directional { direction, .. } => -direction.dot(mirror.n),
            };
            let on_mirror = point.position - towards * (height / towards.dot(mirror.n));
            let lit = cos > 0.0 && illuminance != Vec3::ZERO && height * lamp_height > 0.0;
            if lit && mirror.may_hold(on_mirror) {
                self.candidates.push(Candidate { light, mirror, towards, irradiance: illuminance * cos });
            }
        }

        // Look at them, or at one.
        match which {
            MirroredLights::One { seed } if self.candidates.len() > 1 => {
                let part = |candidate: &Candidate| candidate.irradiance.max_element();
                let total: f32 = self.candidates.iter().map(part).sum();
                let mut rest = unit_f32(hash(seed)) * total;
                let chosen = self.candidates.iter().position(|candidate| {
                    rest -= part(candidate);
                    rest < 0.0
                });
                let candidate = self.candidates[chosen.unwrap_or(self.candidates.len() - 1)];
                self.arriving(scene, point, &candidate) * (total / part(&candidate))
            }
            _ => (0..self.candidates.len()).map(|i| self.arriving(scene, point, &self.candidates[i].clone())).sum(),
        }
    }

    /// Follows a ray to the mirror, and from there to the lamp.
    fn arriving(&mut self, scene: &Scene, point: &ShadingPoint, candidate: &Candidate) -> Vec3 {
        let Candidate { light, mirror, towards, irradiance } = candidate;
        let ray = Ray::new(point.light_origin(*towards), *towards);
        self.rays += 1;
        let Some(hit) = scene.bvh().closest(&ray) else { return Vec3::ZERO };
        let surface = evaluate(scene, &ray, &hit);
        let off = mirror.height(surface.position).abs();
        if surface.mirror == Vec3::ZERO
            || surface.ng.dot(mirror.n).abs() < SAME_NORMAL
            || off > 1e-3 * mirror.radius
            || !mirror.may_hold(surface.position)
        {
            return Vec3::ZERO;
        }

        let shadow = match *light {
            Light::Point { position, .. } | Light::Spot { position, .. } => {
                Ray { t_max: SEGMENT_END, ..surface.spawn_ray(position - surface.position) }
            }
            Light::Directional { direction, .. } => surface.spawn_ray(-direction),
        };
        self.rays += 1;
        visibility(scene, &[shadow], &mut self.shadow, &mut self.visible);
        *irradiance * surface.mirror * (surface.opacity * self.visible[0])
    }

    /// Returns the rays since the last call.
    pub(crate) fn take_rays(&mut self) -> u64 {
        std::mem::take(&mut self.rays)
    }
}
