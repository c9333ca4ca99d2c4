//! How much light passes along a shadow ray.

use glam::Vec3;

use super::surface::{crossing_kind, is_opaque, shadow_transmittance};
use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::world::Scene;

/// Crossings closer than this part of their distance are one: a hit's t is off by a few 2⁻²⁴ of it.
const SAME_CROSSING: f32 = 1.0 / (1 << 21) as f32;

/// Buffers of [`visibility`], kept between calls.
#[derive(Debug, Default)]
pub(crate) struct VisibilityScratch {
    hidden: Vec<bool>,
    crossings: Vec<Hit>,
}

/// Computes the fraction of light per channel that passes along each ray: V of formula (1), 0 or 1 where all surfaces
/// are opaque, a colour through glass and other BLEND or transmissive ones.
pub(crate) fn visibility(scene: &Scene, rays: &[Ray], scratch: &mut VisibilityScratch, passed: &mut Vec<Vec3>) {
    passed.clear();
    if scene.all_opaque() {
        scratch.hidden.resize(rays.len(), false);
        scene.bvh().occluded_batch(rays, &mut scratch.hidden[..rays.len()]);
        passed.extend(scratch.hidden[..rays.len()].iter().map(|&hidden| if hidden { Vec3::ZERO } else { Vec3::ONE }));
    } else {
        passed.extend(rays.iter().map(|ray| transmittance(scene, ray, &mut scratch.crossings)));
    }
}

/// The product over all surfaces that the ray crosses.
fn transmittance(scene: &Scene, ray: &Ray, crossings: &mut Vec<Hit>) -> Vec3 {
    // Collect what the ray crosses, until a surface is opaque.
    crossings.clear();
    let blocked = scene.bvh().any_hit(ray, |hit: &Hit| {
        crossings.push(*hit);
        is_opaque(scene, hit)
    });
    if blocked {
        return Vec3::ZERO;
    }

    // Multiply in the order of the ray, so that the product does not depend on the traversal's.
    crossings.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.target.cmp(&b.target)));

    let (mut passed, mut last) = (Vec3::ONE, None);
    for hit in crossings.iter() {
        // A ray through an edge meets both of its triangles, but crosses the surface once.
        let again = |last: &Hit| {
            hit.t - last.t <= SAME_CROSSING * hit.t.abs()
                && crossing_kind(scene, ray, last) == crossing_kind(scene, ray, hit)
        };
        if !last.is_some_and(again) {
            passed *= shadow_transmittance(scene, ray, hit);
        }
        last = Some(hit);
    }
    passed
}
