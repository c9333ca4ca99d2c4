use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2};

use super::*;
use crate::geometry::TriangleMesh;
use crate::light::emitters::radical_inverse;
use crate::sampling::{hash, unit_f32};
use crate::{EmitterOptions, Environment, ImageData, Instance, Light, Material, SceneData, Texels};

const SIZE: Vec3 = Vec3::new(10.0, 4.0, 8.0);

/// Two triangles.
fn quad(corner: Vec3, a: Vec3, b: Vec3, material: usize) -> TriangleMesh {
    TriangleMesh {
        positions: vec![corner, corner + a, corner + a + b, corner + b],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..TriangleMesh::default()
    }
}

/// The floor of the room.
fn floor() -> SceneData {
    let lamp = Material { emission: Vec3::splat(1000.0), ..Material::lambert(Vec3::splat(0.5)) };
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.5)), lamp], ..SceneData::default() };
    place(&mut data, quad(Vec3::ZERO, Vec3::Z * SIZE.z, Vec3::X * SIZE.x, 0));
    place(&mut data, quad(Vec3::Y * SIZE.y, Vec3::Z * SIZE.z, Vec3::X * SIZE.x, 0));
    data
}

pub(crate) fn place(data: &mut SceneData, mesh: TriangleMesh) {
    data.instances.push(Instance { mesh: data.meshes.len(), world_from_object: Affine3A::IDENTITY });
    data.meshes.push(mesh);
}

fn unit(i: u32, k: u32) -> f32 {
    unit_f32(hash(i ^ hash(k)))
}

/// `count` coloured points, 0.3 m off the walls.
fn point_lights(count: u32) -> SceneData {
    let mut data = floor();
    data.lights = (0..count)
        .map(|i| {
            let u = Vec3::new(unit(i, 0), unit(i, 1), unit(i, 2));
            let warm = unit(i, 3);
            let intensity_cd = Vec3::new(1.0, 0.8, 0.5).lerp(Vec3::new(0.6, 0.8, 1.0), warm) * (40.0 / count as f32);
            Light::Point { position: 0.3 + u * (SIZE - 0.6), intensity_cd, range: None }
        })
        .collect();
    data
}

/// 24 lamps of 1.2 × 0.3 m that hang from the ceiling and face down.
fn panels() -> SceneData {
    let mut data = floor();
    for i in 0..24 {
        let corner = Vec3::new(0.4 + 1.6 * (i % 6) as f32, 3.9, 0.8 + 2.0 * (i / 6) as f32);
        place(&mut data, quad(corner, Vec3::X * 1.2, Vec3::Z * 0.3, 1));
    }
    data
}

/// A sky with a sun of 2°.
fn sky() -> SceneData {
    let (width, height) = (360_u32, 180_u32);
    let texel = |i: u32| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        let up = libm::cosf((y + 0.5) / height as f32 * 2.0 * FRAC_PI_2);
        let c = Vec3::new(0.4, 0.6, 1.0) * (0.3 + up.max(0.0)) * if up < 0.0 { 0.1 } else { 1.0 };
        let sun = Vec2::new(x - 200.0, y - 50.0).length() < 1.2;
        (c + if sun { Vec3::splat(5000.0) } else { Vec3::ZERO }).extend(1.0).to_array()
    };
    let texels: Vec<[f32; 4]> = (0..width * height).map(texel).collect();
    let map = ImageData { name: "sky".into(), width, height, texels: Texels::Rgba32F(Arc::from(texels)) };
    let mut data = floor();
    data.environment =
        Some(Environment { map: Some(map), radiance: Vec3::splat(100.0), world_from_map: Quat::IDENTITY });
    data
}

fn scene(data: SceneData, light_samples: u32) -> Scene {
    Scene::with_emitters(data, &EmitterOptions { light_samples, ..EmitterOptions::default() }).expect("scene")
}

/// Places on the room's six sides and, every other one, on balls in it.
fn surfaces(count: u32) -> Vec<(Vec3, Vec3)> {
    (0..count)
        .map(|i| {
            let (u, v) = ((i as f32 + 0.5) / count as f32, radical_inverse(i));
            if i % 2 == 0 {
                let (z, phi) = (1.0 - 2.0 * v, TAU * unit(i, 9));
                let r = (1.0 - z * z).sqrt();
                let n = Vec3::new(r * libm::cosf(phi), r * libm::sinf(phi), z);
                return (SIZE * Vec3::new(u, 0.4, unit(i, 8)) + n * 0.5, n);
            }
            let side = i as usize / 2 % 6;
            let (axis, far) = (side / 2, side % 2);
            let mut position = SIZE;
            position[(axis + 1) % 3] *= u;
            position[(axis + 2) % 3] *= v;
            position[axis] *= far as f32;
            let mut n = Vec3::ZERO;
            n[axis] = 1.0 - 2.0 * far as f32;
            (position, n)
        })
        .collect()
}

fn regions(scene: &Scene, light_error: f32) -> RegionCuts {
    let options = RenderOptions::default().with(|o| o.transport.light_error = light_error);
    RegionCuts::new(scene, None, &options, options.limits.max_memory).expect("memory")
}

fn one_by_one(scene: &Scene, points: &[(Vec3, Vec3)]) -> Vec<Vec3> {
    let mut sums = Vec::new();
    scene.lights().irradiance(scene.simd_level(), Falloff::default(), points.iter().copied(), &mut sums);
    sums
}

/// Few lights, or no error allowed: the sum over all, bit for bit.
#[test]
fn without_a_tree_the_sum_is_over_all_lights() {
    let points = surfaces(1500);
    for (count, error) in [(FEW as u32, 0.5), (3000, 0.0)] {
        let scene = scene(point_lights(count), 1);
        let sums = regions(&scene, error).irradiance(&scene, Falloff::default(), &points);
        assert_eq!(sums, one_by_one(&scene, &points));
    }
}

/// Kept or made anew, together or one by one, after another falloff: a cut depends on its region alone.
#[test]
fn sums_do_not_depend_on_earlier_calls() {
    let scene = scene(point_lights(3000), 1);
    let points = surfaces(800);
    let mut lights = regions(&scene, 0.02);
    lights.irradiance(&scene, Falloff::ConstantPlusDistance { constant: 1.0 }, &points);
    let together = lights.irradiance(&scene, Falloff::default(), &points);
    assert!(lights.bytes() > 0);
    let mut without_memory = RegionCuts { most_bytes: 0, ..regions(&scene, 0.02) };
    assert_eq!(without_memory.irradiance(&scene, Falloff::default(), &points), together);
    assert_eq!(without_memory.bytes(), 0);
    let one_by_one: Vec<_> =
        points.iter().flat_map(|&p| without_memory.read_irradiance(&scene, Falloff::default(), &[p])).collect();
    assert_eq!(one_by_one, together);
}

#[test]
fn a_tree_too_large_is_refused_before_it_is_built() {
    let scene = scene(point_lights(3000), 1);
    let error = RegionCuts::new(&scene, None, &RenderOptions::default(), 1 << 20).expect_err("3000 lights in 1 MiB");
    assert!(matches!(error, Error::OutOfMemory { .. }), "{error}");
}

/// Errors of the sums at 6000 surface points against the sums over all lights, R + G + B, as parts of the mean
/// irradiance over these points. The table of docs/many-lights.md.
#[test]
#[allow(clippy::print_stderr, reason = "it prints a table")]
fn table_of_errors() {
    let kinds = [
        ("100,000 points", scene(point_lights(100_000), 1)),
        ("24 panels, 24,000 patches", scene(panels(), 1000)),
        ("sky with a sun, 16,384 directions", scene(sky(), 16_384)),
    ];
    let points = surfaces(6000);
    for (name, scene) in &kinds {
        let exact = one_by_one(scene, &points);
        let mean = exact.iter().map(|e| e.element_sum()).sum::<f32>() / exact.len() as f32;
        for error in [0.1, 0.03, 0.01, 0.003, 0.001] {
            let mut lights = regions(scene, error);
            let sums = lights.irradiance(scene, Falloff::default(), &points);
            let errors = || sums.iter().zip(&exact).map(|(a, b)| (*a - *b).abs().element_sum() / mean);
            let rms = (errors().map(|e| e * e).sum::<f32>() / sums.len() as f32).sqrt();
            let largest = errors().fold(0.0, f32::max);
            let lengths = lights.cuts.values().map(|cut| cut.len()).sum::<usize>() / lights.cuts.len();
            eprintln!("{name} | {error} | {:.3}% | {:.2}% | {lengths}", 100.0 * rms, 100.0 * largest);
            assert!(rms <= error, "{name}: {rms} {error}");
            assert!(largest <= 10.0 * error, "{name}: {largest} {error}");
        }
    }
}
