//! What a ray sees: the diffuse surface at the end of its way through panes and by mirrors.

use glam::Vec3;

use super::{Lobe, PathRay, evaluate};
use crate::Scene;
use crate::geometry::{Cone, Ray};
use crate::light::emitters::luminance;
use crate::sampling::Sampler;

/// Mirrors, panes and partly transparent surfaces that a ray follows to what is seen.
const EVENTS: u32 = 12;

/// A place on a diffuse surface, on the side that is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenPlace {
    /// A little off the surface, metres.
    pub point: Vec3,
    pub n: Vec3,
    /// The part of its irradiance that it reflects.
    pub albedo: f32,
}

impl SeenPlace {
    /// Follows a ray through panes, mirrors and partly transparent surfaces to the first diffuse surface that does not
    /// shine itself.
    pub(crate) fn along(scene: &Scene, ray: Ray, sampler: &mut Sampler) -> Option<Self> {
        let mut path = PathRay::new(ray, Cone::POINT);
        for _ in 0..EVENTS {
            let hit = scene.bvh().closest(&path.ray)?;
            let surface = evaluate(scene, &path.ray, &hit);
            if surface.lets_through(|| sampler.choice()) {
                path = path.pass_through(&hit)?;
                continue;
            }
            // Its own light says nothing of other light on it.
            if surface.emission.max_element() > 0.0 {
                return None;
            }
            match surface.lobes().sample(sampler.choice())?.lobe {
                Lobe::Diffuse => {
                    let point = surface.spawn_ray(surface.n).origin;
                    return Some(Self { point, n: surface.n, albedo: luminance(surface.diffuse) });
                }
                Lobe::Specular(lobe) => path = path.spawn(&hit, &surface, lobe),
            }
        }
        None
    }
}
