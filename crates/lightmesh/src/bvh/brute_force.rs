//! The truth that the tree is tested against: every surface, one after the other.

use super::flatten::{ObjectFromWorld, corners};
use super::hit::{Hit, Target};
use super::triangle_block::{Shear, intersect_triangle};
use super::triangle_bvh::has_area;
use crate::geometry::Ray;
use crate::scene::SceneData;

/// What [`SceneBvh::closest`](super::scene_bvh::SceneBvh::closest) answers, without a tree: triangles are transformed
/// to world space and tested one by one. Where the tree tests a mesh in object space, t, u and v may differ by
/// rounding.
pub fn closest_brute_force(data: &SceneData, ray: &Ray) -> Option<Hit> {
    let shear = Shear::new(ray);
    let mut hits = Vec::new();
    for (placed, instance) in data.instances.iter().zip(0..) {
        if ObjectFromWorld::new(placed).is_none() {
            continue;
        }
        let triangles = corners(&data.meshes[placed.mesh], |p| placed.world_from_object.transform_point3(p));
        for (corners, triangle) in triangles.zip(0..).filter(|(corners, _)| has_area(corners)) {
            if let Some([t, u, v]) = intersect_triangle(&shear, &corners) {
                hits.push(Hit { t, u, v, target: Target::Triangle { instance, triangle } });
            }
        }
    }
    let plain = |t, target| Hit { t, u: 0.0, v: 0.0, target };
    let spheres = data.spheres.iter().zip(0..).filter_map(|(s, i)| Some(plain(s.intersect(ray)?, Target::Sphere(i))));
    let shapes =
        data.shapes.iter().zip(0..).filter_map(|(s, i)| Some(plain(s.shape.intersect(ray)?, Target::Shape(i))));
    hits.extend(spheres.chain(shapes));
    hits.retain(|hit| hit.t > ray.t_min && hit.t < ray.t_max);
    hits.into_iter().min_by(|a, b| a.t.total_cmp(&b.t).then(a.target.cmp(&b.target)))
}
