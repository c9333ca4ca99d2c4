//! How much light a shadow ray lets through.

use glam::Vec3;

use super::surface::shadow_transmittance;
use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::scene::Scene;

/// Below this the rest of a coloured shadow is black: a thousandth of what the eye tells apart.
const OPAQUE: f32 = 1e-5;

/// Buffers of [`visibility`], kept between calls.
#[derive(Debug, Default)]
pub(crate) struct VisibilityScratch {
    hidden: Vec<bool>,
}

/// The fraction of light per channel that passes along each ray: V of formula (1), 0 or 1 between solid surfaces, a colour
/// through glass and other BLEND or transmissive ones.
pub(crate) fn visibility(scene: &Scene, rays: &[Ray], scratch: &mut VisibilityScratch, passed: &mut Vec<Vec3>) {
    passed.clear();
    if scene.all_solid() {
        scratch.hidden.resize(rays.len(), false);
        scene.bvh().occluded_batch(rays, &mut scratch.hidden[..rays.len()]);
        passed.extend(scratch.hidden[..rays.len()].iter().map(|&hidden| if hidden { Vec3::ZERO } else { Vec3::ONE }));
    } else {
        passed.extend(rays.iter().map(|ray| transmittance(scene, ray)));
    }
}

/// The product over all surfaces that the ray crosses, in any order.
fn transmittance(scene: &Scene, ray: &Ray) -> Vec3 {
    let mut passed = Vec3::ONE;
    let opaque = scene.bvh().any_hit(ray, &mut |hit: &Hit| {
        passed *= shadow_transmittance(scene, ray, hit);
        passed.max_element() < OPAQUE
    });
    if opaque { Vec3::ZERO } else { passed }
}
