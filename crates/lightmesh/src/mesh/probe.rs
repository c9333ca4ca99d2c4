//! Probing a mesh point: whether it is inside a solid, and its clearance.

use glam::Vec3;

use super::clearance::Clearance;
use super::lattice::ON_SURFACE;
use crate::bvh::Hit;
use crate::geometry::Ray;
use crate::interaction::{is_back_face, is_opaque};
use crate::world::Scene;

/// Directions of the rays that tell whether a point is inside a solid: six of a cube turned off the axes, along which
/// architecture has its edges.
const INSIDE: [Vec3; 6] = [
    Vec3::new(0.8, 0.36, 0.48),
    Vec3::new(-0.8, -0.36, -0.48),
    Vec3::new(-0.6, 0.48, 0.64),
    Vec3::new(0.6, -0.48, -0.64),
    Vec3::new(0.0, 0.8, -0.6),
    Vec3::new(0.0, -0.8, 0.6),
];

/// How far surfaces count, in spacings: what is a solid for a point that surfaces read has a side near it. The far side of
/// a sky dome must not make all points in it points of a solid. A judgement.
const FAR: f32 = 256.0;

/// Towards the neighbours, in the order of [`Clearance`].
const SIDES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Rays that [`probe`] traces.
pub(crate) const PROBE_RAYS: u64 = (INSIDE.len() + SIDES.len()) as u64;

/// Returns the clearance of a point at `x` up to its neighbours, `spacing` away (metres); `None` if it is inside a
/// solid or on a surface.
pub(crate) fn probe(scene: &Scene, x: Vec3, spacing: f32) -> Option<Clearance> {
    if is_inside(scene, x, spacing) {
        return None;
    }
    Some(Clearance::new(SIDES.map(|side| {
        let ray = Ray { t_max: 1.0, ..Ray::new(x, side * spacing) };
        closest_opaque(scene, ray).map(|hit| hit.t)
    })))
}

/// Returns the first opaque surface on a ray: glass hides nothing, and what is in it is not inside a solid.
fn closest_opaque(scene: &Scene, mut ray: Ray) -> Option<Hit> {
    loop {
        let hit = scene.bvh().closest(&ray)?;
        if scene.all_opaque() || is_opaque(scene, &hit) {
            return Some(hit);
        }
        ray.t_min = hit.t;
    }
}

/// Returns whether most of the surfaces that the point sees near it are back faces of one-sided ones, or it lies on a
/// surface.
fn is_inside(scene: &Scene, x: Vec3, spacing: f32) -> bool {
    let near = ON_SURFACE * spacing;
    // Count the faces around the point.
    let (mut back, mut front) = (0, 0);
    for direction in INSIDE {
        let mut ray = Ray { t_max: FAR * spacing, ..Ray::new(x - direction * near, direction) };
        if 2 * front >= INSIDE.len() || scene.all_double_sided() {
            // It is not inside anything, but it may be on a surface.
            ray.t_max = 2.0 * near;
        }
        if let Some(hit) = closest_opaque(scene, ray) {
            if hit.t < 2.0 * near {
                return true;
            }
            if is_back_face(scene, &ray, &hit) { back += 1 } else { front += 1 }
        }
    }
    back > front && (front == 0 || back >= INSIDE.len() / 2)
}

/// Returns whether nothing opaque stands on the open segment that is `ray`.
pub(crate) fn sees(scene: &Scene, ray: &Ray) -> bool {
    if scene.all_opaque() { !scene.bvh().occluded(ray) } else { !scene.bvh().any_hit(ray, |hit| is_opaque(scene, hit)) }
}
