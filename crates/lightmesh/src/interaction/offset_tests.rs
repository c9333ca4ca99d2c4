//! Rays start so far off a surface that they do not meet it, and not further than they must.

use glam::{Affine3A, Mat3, Quat, Vec3};

use super::{ShadedHit, evaluate};
use crate::geometry::{Ray, Sphere, TriangleMesh};
use crate::sampling::{hash, sample_cosine_hemisphere, unit_f32};
use crate::scene::{Instance, Material, SceneData};
use crate::world::Scene;

/// Random numbers.
struct Dice(u32);

impl Dice {
    fn unit(&mut self) -> f32 {
        self.0 += 1;
        unit_f32(hash(self.0))
    }

    /// In [−1, 1]³.
    fn cube(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| 2.0 * self.unit() - 1.0))
    }

    fn direction(&mut self) -> Vec3 {
        self.cube().normalize_or(Vec3::X)
    }
}

fn scene(meshes: Vec<TriangleMesh>, places: &[Affine3A], spheres: Vec<Sphere>) -> Scene {
    let instances = places.iter().map(|&world_from_object| Instance { mesh: 0, world_from_object }).collect();
    let materials = vec![Material::default()];
    Scene::new(SceneData { meshes, instances, spheres, materials, ..SceneData::default() }).expect("a scene")
}

/// How many of the rays that leave a hit on the side that was hit, in all directions, grazing ones too, meet something.
fn self_hits(scene: &Scene, hit: &ShadedHit, dice: &mut Dice) -> usize {
    let (t, b) = crate::sampling::basis(hit.ng);
    let rays = (0..16).filter(|i| {
        let mut local = sample_cosine_hemisphere(glam::Vec2::new(dice.unit(), dice.unit()));
        if i % 2 == 0 {
            local.z *= 1e-3;
        }
        let direction = (t * local.x + b * local.y + hit.ng * local.z).normalize();
        scene.bvh().occluded(&hit.spawn_ray(direction))
    });
    rays.count()
}

/// Shoots at points near `target`, and returns self-hits, rays, and the mean offset.
fn probe(scene: &Scene, target: Vec3, spread: f32, dice: &mut Dice) -> (usize, usize, f32) {
    let (mut met, mut shot, mut offset) = (0, 0, 0.0);
    for _ in 0..4 {
        let from = target + dice.direction() * spread * (1.0 + 3.0 * dice.unit());
        let ray = Ray::new(from, (target + dice.cube() * (0.3 * spread) - from).normalize_or(Vec3::X));
        if let Some(hit) = scene.bvh().closest(&ray) {
            let surface = evaluate(scene, &ray, &hit);
            met += self_hits(scene, &surface, dice);
            (shot, offset) = (shot + 16, offset + surface.offset * 16.0);
        }
    }
    (met, shot, offset)
}

fn triangle(dice: &mut Dice, centre: Vec3, size: f32) -> TriangleMesh {
    let positions = [(); 3].map(|()| centre + dice.cube() * size).to_vec();
    TriangleMesh { positions, triangles: vec![[0, 1, 2]], ..TriangleMesh::default() }
}

/// Triangles of 1 mm to 5 km, up to 10⁵ m from the origin; in world space.
#[test]
fn rays_do_not_meet_the_triangle_they_leave() {
    let mut dice = Dice(1);
    for size in [1e-3, 0.1, 3.0, 100.0, 5000.0] {
        for far in [0.0, 10.0, 1e3, 1e4, 1e5].into_iter().filter(|far| far * 1e-5 <= size) {
            let (mut met, mut shot) = (0, 0);
            for _ in 0..400 {
                let centre = dice.cube() * far;
                let mesh = triangle(&mut dice, centre, size);
                let middle = mesh.positions.iter().sum::<Vec3>() / 3.0;
                let scene = scene(vec![mesh], &[Affine3A::IDENTITY], Vec::new());
                let (m, s, _) = probe(&scene, middle, size, &mut dice);
                (met, shot) = (met + m, shot + s);
            }
            assert!(met == 0 && shot > 5000, "{size} m at {far}: {met} of {shot}");
        }
    }
}

/// Instances with trees of their own: rotated, scaled from 10⁻³ to 10³, sheared, far away, with vertices far from the
/// origin of their own space.
#[test]
fn rays_do_not_meet_the_instance_they_leave() {
    let mut dice = Dice(2);
    for (scale, shear, far, own) in [
        (1.0, 0.0, 10.0, 0.0),
        (1e-3, 0.0, 10.0, 0.0),
        (1e3, 0.0, 1e3, 0.0),
        (1.0, 3.0, 10.0, 0.0),
        (1.0, 0.5, 1e4, 0.0),
        (1.0, 0.0, 0.0, 1e4),
        (0.1, 3.0, 1e3, 100.0),
    ] {
        let (mut met, mut shot) = (0, 0);
        for _ in 0..60 {
            // More triangles than are copied into the world, all the same but one.
            let centre = dice.cube() * own;
            let mut mesh = triangle(&mut dice, centre, 1.0);
            let middle = mesh.positions.iter().sum::<Vec3>() / 3.0;
            let rotation = Quat::from_axis_angle(dice.direction(), 6.0 * dice.unit());
            let sheared = Mat3::from_cols(Vec3::X, Vec3::new(shear, 1.0, 0.0), Vec3::new(0.0, -shear, 1.0));
            let place = dice.cube() * far;
            let m = Mat3::from_quat(rotation) * sheared * scale;
            let world = Affine3A::from_mat3_translation(m, place);
            let apart = Affine3A::from_translation(Vec3::new(0.0, 1e6, 0.0));
            for i in 0..600 {
                let far_off = Vec3::new(0.0, 3e5 + 2.0 * i as f32, 0.0);
                let first = mesh.positions.len() as u32;
                mesh.positions.extend([far_off, far_off + Vec3::X, far_off + Vec3::Z]);
                mesh.triangles.push([first, first + 1, first + 2]);
            }
            let scene = scene(vec![mesh], &[world, apart], Vec::new());
            let (m, s, _) = probe(&scene, world.transform_point3(middle), scale, &mut dice);
            (met, shot) = (met + m, shot + s);
        }
        assert!(met == 0 && shot > 500, "{scale} {shear} {far} {own}: {met} of {shot}");
    }
}

/// Spheres of 1 mm and 1 km, from outside.
#[test]
fn rays_do_not_meet_the_sphere_they_leave() {
    let mut dice = Dice(3);
    for (radius, far) in [(1e-3, 1.0), (0.1, 10.0), (1.0, 1e4), (1e3, 1e3), (1e3, 1e5)] {
        let (mut met, mut shot) = (0, 0);
        for _ in 0..400 {
            let center = dice.cube() * far;
            let scene = scene(Vec::new(), &[], vec![Sphere { center, radius, material: 0 }]);
            let (m, s, _) = probe(&scene, center, 2.0 * radius, &mut dice);
            (met, shot) = (met + m, shot + s);
        }
        assert!(met == 0 && shot > 2000, "{radius} {far}: {met} of {shot}");
    }
}

/// Next to the origin a ray between two surfaces a tenth of a millimetre apart starts between them: on a wall of 10 m,
/// and 3 m from the origin.
#[test]
fn a_tenth_of_a_millimetre_is_room_for_a_ray() {
    let wall = TriangleMesh {
        positions: vec![Vec3::new(-5.0, -5.0, 3.0), Vec3::new(5.0, -5.0, 3.0), Vec3::new(0.0, 5.0, 3.0)],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let scene = scene(vec![wall], &[Affine3A::IDENTITY], Vec::new());
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    let hit = scene.bvh().closest(&ray).expect("the wall");
    assert!(evaluate(&scene, &ray, &hit).offset < 5e-5);
}
