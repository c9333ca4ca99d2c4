//! How large the places are that lamps light: a room, whatever stands around it.
//!
//! Spacings and regions of lights are parts of this extent, not of the scene's box: a room on a ground of 5 km has the
//! mesh of the room. Rays from each lamp find what is around it; the box of the nearest nine tenths of what they hit is
//! the place that the lamp lights. A lamp in the open has no such place, and the sky none at all: where they prevail,
//! it is the scene's box that counts.

use glam::Vec3;

use crate::bvh::{Hit, SceneBvh};
use crate::geometry::{Aabb, Ray};
use crate::light::LightSamples;
use crate::light::sample::LightEmission;

/// Lamps that are asked, at most, spread over the list; and rays from each.
const LAMPS: usize = 64;
const RAYS: usize = 64;

/// Surfaces that a ray passes because they shine, at most.
const SHINING: usize = 4;

/// The part of its rays that must hit something for a lamp to be in a place of its own.
const ENCLOSED: f32 = 0.8;

/// The part of the hits that makes the place: the nearest ones. The others go out through doors and windows.
const NEAREST: f32 = 0.9;

/// An extent of at least this part of the box's is the box's: furniture, columns and niches do not make a room of their
/// own.
const ALL: f32 = 0.25;

/// A smaller extent counts as this part of the box's, so that there are not too many mesh points on what lies around.
const LEAST: f32 = 1.0 / 400.0;

/// Returns the longest edge of what lamps light, metres: the median over the lamps.
///
/// Rays pass what `shines`: lamps may stand for the surfaces around them.
pub(super) fn lit_extent(bvh: &SceneBvh, lights: &LightSamples, shines: impl Fn(&Hit, Vec3) -> bool) -> f32 {
    let whole = bvh.bounds().size().max_element();
    let lanes: Vec<usize> = (0..lights.lanes()).filter(|&lane| lights.intensity(lane) != Vec3::ZERO).collect();
    let step = lanes.len().div_ceil(LAMPS).max(1);
    let asked: Vec<usize> = lanes.into_iter().step_by(step).collect();
    let mut extents: Vec<f32> =
        asked.iter().map(|&lane| place_of(bvh, lights, lane, &shines).unwrap_or(whole)).collect();
    extents.sort_by(f32::total_cmp);
    let median = extents.get(extents.len() / 2).copied().unwrap_or(whole);
    if median >= ALL * whole { whole } else { median.max(LEAST * whole) }
}

/// Returns the longest edge of the place that a lamp lights, metres; `None` in the open and for the sky.
fn place_of(bvh: &SceneBvh, lights: &LightSamples, lane: usize, shines: &impl Fn(&Hit, Vec3) -> bool) -> Option<f32> {
    // Rays start off the lamp's own surface.
    let light = lights.sample(lane)?;
    let (start, normal) = match light.emission {
        LightEmission::Directional => return None,
        LightEmission::Isotropic | LightEmission::Spot { .. } => (light.position, None),
        LightEmission::Patch { normal, area_over_pi, .. } => {
            (light.position + normal * (1e-2 * area_over_pi.sqrt()), Some(normal))
        }
    };
    let directions = (0..RAYS).map(fibonacci).map(|d| match normal {
        Some(n) if d.dot(n) < 0.0 => d - n * (2.0 * d.dot(n)),
        _ => d,
    });
    let mut hits: Vec<(f32, Vec3)> = directions
        .filter_map(|direction| {
            let mut ray = Ray::new(start, direction);
            (0..SHINING).find_map(|_| {
                let hit = bvh.closest(&ray);
                let p = hit.map_or(start, |hit| ray.at(hit.t));
                if hit.is_some_and(|hit| shines(&hit, p)) {
                    ray.t_min = hit.map_or(0.0, |hit| hit.t);
                    return None;
                }
                Some(hit.map(|hit| (hit.t, p)))
            })?
        })
        .collect();
    if (hits.len() as f32) < ENCLOSED * RAYS as f32 {
        return None;
    }

    // The box of the nearest ones, and of the lamp.
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    hits.truncate((NEAREST * hits.len() as f32) as usize);
    let mut bounds = Aabb { min: start, max: start };
    for (_, p) in hits {
        bounds = Aabb { min: bounds.min.min(p), max: bounds.max.max(p) };
    }
    Some(bounds.size().max_element())
}

/// Returns the i-th of [`RAYS`] directions that are evenly spread.
fn fibonacci(i: usize) -> Vec3 {
    let z = 1.0 - (2.0 * i as f32 + 1.0) / RAYS as f32;
    let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), i as f32 * 2.399_963);
    Vec3::new(r * libm::cosf(phi), r * libm::sinf(phi), z)
}
