//! Instances, spheres and user-defined shapes through the top level.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};

use super::super::brute_force::closest_brute_force;
use super::super::hit::{Hit, Target};
use super::super::scene_bvh::SceneBvh;
use super::{Random, mesh, rays, scene};
use crate::geometry::{Aabb, Ray, Shape, Sphere, TriangleMesh};
use crate::scene::{Instance, SceneData, ShapeEntry};

/// A square plate |x|, |y| ≤ 1 in the plane z = `z`.
#[derive(Debug)]
struct Plate {
    z: f32,
}

impl Shape for Plate {
    fn bounds(&self) -> Aabb {
        Aabb { min: Vec3::new(-1.0, -1.0, self.z), max: Vec3::new(1.0, 1.0, self.z) }
    }

    fn intersect(&self, ray: &Ray) -> Option<f32> {
        let t = (self.z - ray.origin.z) / ray.direction.z;
        let p = ray.at(t);
        (t > ray.t_min && t < ray.t_max && p.x.abs() <= 1.0 && p.y.abs() <= 1.0).then_some(t)
    }

    fn normal(&self, _: Vec3) -> Vec3 {
        Vec3::Z
    }
}

fn blob(random: &mut Random) -> Vec<[Vec3; 3]> {
    (0..200).map(|_| [random.point(), random.point(), random.point()].map(|p| p * 0.5)).collect()
}

fn placed(mesh: usize, world_from_object: Affine3A) -> Instance {
    Instance { mesh, world_from_object }
}

/// 30 instances of one mesh, with rotation, mirroring and uneven scale, hit where the same triangles in world space
/// are.
#[test]
fn instances_agree_with_the_flattened_scene() {
    let mut random = Random(2);
    let triangles = blob(&mut random);
    let transforms: Vec<Affine3A> = (0..30)
        .map(|i| {
            let scale = Vec3::new(0.5 + random.unit(), 0.5 + random.unit(), if i % 3 == 0 { -0.7 } else { 0.7 });
            let rotation = Quat::from_axis_angle(random.point().normalize_or(Vec3::X), 6.0 * random.unit());
            Affine3A::from_scale_rotation_translation(scale, rotation, random.point() * 4.0)
        })
        .collect();
    let data = SceneData {
        meshes: vec![mesh(&triangles)],
        instances: transforms.iter().map(|&m| placed(0, m)).collect(),
        ..Default::default()
    };
    let world: Vec<[Vec3; 3]> =
        transforms.iter().flat_map(|m| triangles.iter().map(|t| t.map(|c| m.transform_point3(c)))).collect();
    let (bvh, flat) = (SceneBvh::build(&data), SceneBvh::build(&scene(&world)));
    assert!(bvh.bytes() < flat.bytes() / 10, "{} against {}", bvh.bytes(), flat.bytes());

    let (mut met, mut other) = (0, 0);
    for _ in 0..20_000 {
        // From anywhere to a point inside a triangle.
        let [a, b, c] = world[random.below(world.len())];
        let (u, v) = (0.05 + 0.45 * random.unit(), 0.05 + 0.45 * random.unit());
        let origin = random.point() * 8.0;
        let ray = Ray::new(origin, a + (b - a) * u + (c - a) * v - origin);
        let (a, b) = (bvh.closest(&ray), flat.closest(&ray));
        assert_eq!(bvh.occluded(&ray), a.is_some());
        let (Some(a), Some(b)) = (a, b) else {
            other += usize::from(a.is_some() != b.is_some());
            continue;
        };
        met += 1;
        let (Target::Triangle { instance, triangle }, Target::Triangle { triangle: id, .. }) = (a.target, b.target)
        else {
            panic!("only triangles are there")
        };
        if (a.t - b.t).abs() > 1e-4 * b.t.max(0.1) || instance * 200 + triangle != id {
            other += 1;
        }
    }
    // A few rays pass another triangle's edge within rounding.
    assert!(met > 15_000 && other < 10, "{other} of {met} differ");
}

/// A mesh used 1,000 times costs its memory once, and an inverse that does not exist is no hit and no NaN.
#[test]
fn a_thousand_instances_cost_one_mesh() {
    let mut random = Random(4);
    let triangles: Vec<[Vec3; 3]> = (0..20).flat_map(|_| blob(&mut random)).collect();
    let scene_of = |n: usize| SceneData {
        meshes: vec![mesh(&triangles)],
        instances: (0..n).map(|i| placed(0, Affine3A::from_translation(Vec3::X * 2.0 * i as f32))).collect(),
        ..Default::default()
    };
    let (one, many) = (SceneBvh::build(&scene_of(1)).bytes(), SceneBvh::build(&scene_of(1000)).bytes());
    assert!(many < one + 1000 * 250, "{many} against {one}");

    let mut data = scene_of(3);
    data.instances[1].world_from_object = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    data.instances[2].world_from_object = Affine3A::from_scale(Vec3::ZERO);
    let (bvh, alone) = (SceneBvh::build(&data), SceneBvh::build(&scene_of(1)));
    for ray in rays(&triangles, 1.0, 2000, &mut random) {
        assert_eq!(bvh.closest(&ray).map(|h| h.t > 0.0), alone.closest(&ray).map(|_| true));
    }
}

#[test]
fn spheres_and_shapes_stand_beside_triangles() {
    let mut random = Random(6);
    let mut data = scene(&blob(&mut random));
    data.spheres = (0..40)
        .map(|_| Sphere { center: random.point() * 2.0, radius: 0.1 + 0.2 * random.unit(), material: 0 })
        .collect();
    data.shapes =
        (0..5).map(|i| ShapeEntry { shape: Arc::new(Plate { z: i as f32 * 0.3 - 0.7 }), material: 0 }).collect();
    let bvh = SceneBvh::build(&data);
    let mut kinds = [0; 3];
    for ray in rays(&[], 2.0, 10_000, &mut random) {
        let truth = closest_brute_force(&data, &ray);
        assert_eq!(bvh.closest(&ray), truth);
        assert_eq!(bvh.occluded(&ray), truth.is_some());
        match truth.map(|h| h.target) {
            Some(Target::Triangle { .. }) => kinds[0] += 1,
            Some(Target::Sphere(_)) => kinds[1] += 1,
            Some(Target::Shape(_)) => kinds[2] += 1,
            None => {}
        }
    }
    assert!(kinds.iter().all(|&n| n > 500), "{kinds:?}");
}

/// Through a unit sphere at the origin: in at t = 2, out at t = 4, and the plate z = 0 between at t = 3.
#[test]
fn any_hit_offers_every_crossing_until_told_to_stop() {
    let data = SceneData {
        spheres: vec![Sphere { center: Vec3::ZERO, radius: 1.0, material: 0 }],
        shapes: vec![ShapeEntry { shape: Arc::new(Plate { z: 0.0 }), material: 0 }],
        ..Default::default()
    };
    let bvh = SceneBvh::build(&data);
    let ray = Ray::new(Vec3::Z * 3.0, Vec3::NEG_Z);
    let mut ts = Vec::new();
    assert!(!bvh.any_hit(&ray, |hit| {
        ts.push(hit.t);
        false
    }));
    ts.sort_by(f32::total_cmp);
    assert_eq!(ts, [2.0, 3.0, 4.0]);
    let mut offered = 0;
    assert!(bvh.any_hit(&ray, |_| {
        offered += 1;
        true
    }));
    assert_eq!(offered, 1);
}

#[test]
fn ties_go_to_the_lowest_target() {
    let square = [[Vec3::new(-1.0, -1.0, 0.0), Vec3::new(3.0, -1.0, 0.0), Vec3::new(-1.0, 3.0, 0.0)]];
    // A mesh large enough to stay an instance, twice in the same place, and the same plane as a shape.
    let large: Vec<[Vec3; 3]> =
        square.into_iter().chain(vec![[Vec3::ONE * 9.0, Vec3::X * 9.0, Vec3::Y * 9.0]; 999]).collect();
    let once = placed(1, Affine3A::IDENTITY);
    let data = SceneData {
        meshes: vec![mesh(&large), mesh(&square)],
        instances: vec![placed(0, Affine3A::IDENTITY), once, placed(0, Affine3A::IDENTITY)],
        shapes: vec![ShapeEntry { shape: Arc::new(Plate { z: 0.0 }), material: 0 }],
        ..Default::default()
    };
    let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
    let target = |data: &SceneData| SceneBvh::build(data).closest(&ray).map(|h| h.target);
    assert_eq!(target(&data), Some(Target::Triangle { instance: 0, triangle: 0 }));
    let swapped = SceneData { instances: data.instances[1..].to_vec(), ..data };
    assert_eq!(target(&swapped), Some(Target::Triangle { instance: 0, triangle: 0 }));
}

#[test]
fn a_single_triangle_and_nothing_at_all() {
    let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
    for empty in [SceneData::default(), scene(&[]), SceneData { meshes: vec![TriangleMesh::default()], ..scene(&[]) }] {
        let empty = SceneBvh::build(&empty);
        assert!(empty.bounds().is_empty() && empty.closest(&ray).is_none() && !empty.occluded(&ray));
    }
    let bvh = SceneBvh::build(&scene(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]));
    let target = Target::Triangle { instance: 0, triangle: 0 };
    assert_eq!(bvh.closest(&ray), Some(Hit { t: 1.0, u: 0.25, v: 0.25, target }));
    assert!(bvh.occluded(&ray) && bvh.any_hit(&ray, |hit| hit.target == target));
    assert!(!bvh.occluded(&Ray { t_max: 1.0, ..ray }) && !bvh.occluded(&Ray { t_min: 1.0, ..ray }));
}
