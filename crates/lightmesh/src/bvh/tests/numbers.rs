//! Rays and triangles at the ends of the range of 32-bit floats: nothing panics, and what is hit is a number.

use glam::{Affine3A, Vec3};

use super::super::scene_bvh::SceneBvh;
use super::{Random, scene};
use crate::geometry::Ray;
use crate::scene::{Instance, SceneData};

/// 200 triangles in the world, and as many of a mesh that is placed twice and has a tree of its own.
fn two_levels(scale: f32) -> SceneData {
    let mut random = Random(7);
    let triangles: Vec<[Vec3; 3]> = (0..600).map(|_| [(); 3].map(|()| random.point() * scale)).collect();
    let mut data = scene(&triangles[..200]);
    let mesh = data.meshes.len();
    data.meshes.extend(scene(&triangles).meshes);
    for x in [-scale, scale] {
        data.instances.push(Instance { mesh, world_from_object: Affine3A::from_translation(Vec3::X * x) });
    }
    data
}

const STRANGE: [f32; 10] =
    [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX, 1e30, 1e19, f32::MIN_POSITIVE, 1e-45, 0.0];

/// A number that is none in origin, direction or interval.
#[test]
fn rays_that_are_no_numbers_meet_nothing() {
    let bvh = SceneBvh::build(&two_levels(1.0));
    let good = Ray::new(Vec3::new(0.1, 0.2, 3.0), Vec3::new(0.02, -0.03, -1.0));
    assert!(bvh.closest(&good).is_some());
    for strange in STRANGE {
        for axis in 0..3 {
            let (mut origin, mut direction) = (good, good);
            origin.origin[axis] = strange;
            direction.direction[axis] = strange;
            let interval = Ray { t_max: strange, ..good };
            for ray in [origin, direction, interval] {
                let (hit, mut offered) = (bvh.closest(&ray), 0);
                let occluded = bvh.occluded(&ray);
                bvh.any_hit(&ray, |hit| {
                    offered += 1;
                    assert!(hit.t.is_finite(), "{ray:?}");
                    false
                });
                let is_finite = ray.origin.is_finite() && ray.direction.is_finite();
                assert!(is_finite || (hit.is_none() && !occluded && offered == 0), "{ray:?}");
                assert!(hit.is_none_or(|hit| hit.t.is_finite() && hit.u.is_finite() && hit.v.is_finite()), "{ray:?}");
            }
        }
    }
}

/// Scenes so large that distances overflow, and so small that areas vanish.
#[test]
fn hits_are_numbers_at_any_scale() {
    for scale in [1e-40, 1e-25, 1e-12, 1e9, 1e12, 1e18, 1e30, 1e38] {
        let bvh = SceneBvh::build(&two_levels(scale));
        let mut random = Random(11);
        for _ in 0..200 {
            let ray = Ray::new(random.point() * scale * 2.0, random.point());
            let hit = bvh.closest(&ray);
            assert!(hit.is_none_or(|hit| hit.t.is_finite() && hit.u.is_finite() && hit.v.is_finite()), "{ray:?}");
            bvh.any_hit(&ray, |hit| {
                assert!(hit.t.is_finite(), "{ray:?}");
                false
            });
        }
    }
}
