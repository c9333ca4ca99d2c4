//! The estimate of `--error` is honest: it counts what the mesh leaves out or gets wrong.

use crate::common::*;
use glam::Vec3;
use lightmesh::{Camera, Frame, Image, Light, Material, Method, RenderOptions, Scene, SceneData};

/// Error of means over blocks of 4 × 4 pixels, relative to the mean of the truth.
fn block_error(picture: &Image, truth: &Image) -> f64 {
    let (columns, rows) = (truth.width as usize / 4, truth.height as usize / 4);
    let block = |image: &Image, i: usize| -> Vec3 {
        let (x, y) = (i % columns * 4, i / columns * 4);
        (0..16).map(|k| image.pixels[(y + k / 4) * image.width as usize + x + k % 4]).sum::<Vec3>() / 16.0
    };
    let square = |i| f64::from((block(picture, i) - block(truth, i)).length_squared());
    let mean = |i| f64::from(block(truth, i).element_sum());
    let n = columns * rows;
    let (squares, sum) = (0..n).fold((0.0, 0.0), |(s, m), i| (s + square(i), m + mean(i)));
    (squares / (3 * n) as f64).sqrt() / (sum / (3 * n) as f64)
}

fn small(method: Method, spp: u32) -> RenderOptions {
    RenderOptions { method, ..RenderOptions::default() }.with(|o| {
        (o.picture.width, o.picture.height, o.picture.spp) = (64, 48, spp);
    })
}

/// The bounded picture of a scene, and its error against paths.
fn bounded(data: SceneData, camera: &Camera, bound: f32) -> (Frame, f64) {
    let scene = Scene::new(data).expect("scene");
    let truth = shoot(&scene, camera, &small(Method::Path, 256)).image;
    let frame = shoot(&scene, camera, &small(Method::with_error(bound), 4));
    let error = block_error(&frame.image, &truth);
    (frame, error)
}

fn assert_honest(frame: &Frame, error: f64) {
    let estimate = frame.stats.estimated_error.expect("an estimate");
    assert!(1.5 * estimate >= error - 0.01, "{estimate} of {error}");
}

/// A panel that shines at a mirror alone: most light on the floor comes by way of it. It is named, and what of it is
/// missing is in the estimate.
#[test]
fn light_by_way_of_a_mirror_is_counted() {
    let mut data = floor(Vec3::splat(0.6));
    data.materials.push(Material { metallic: 1.0, roughness: 0.0, ..Material::lambert(Vec3::splat(0.95)) });
    data.materials.push(Material { emission: Vec3::splat(50.0), ..Material::lambert(Vec3::ZERO) });
    let wall = |x: f32, half: f32, low: f32| {
        [(low, half), (low, -half), (low + 2.0 * half, -half), (low + 2.0 * half, half)]
            .map(|(y, z)| Vec3::new(x, y, z))
    };
    place(&mut data, quad(wall(-1.5, 1.5, 0.0), 1));
    let [a, b, c, d] = wall(-0.5, 0.4, 0.8);
    place(&mut data, quad([a, d, c, b], 2));
    let camera = Camera::look_at(Vec3::new(2.5, 4.0, 0.0), Vec3::new(0.8, 0.0, 0.0), 0.9);
    let (frame, error) = bounded(data, &camera, 0.05);
    assert_honest(&frame, error);
    let caustics = frame.stats.error_estimate.expect("an estimate").caustics;
    assert!((0.05..1.0).contains(&caustics), "{caustics}");
}

/// A panel 6 cm below the ceiling of a closed room: its light samples are too few there, whatever they are compared
/// with.
#[test]
fn lamps_near_walls_are_counted() {
    let mut data = room();
    data.lights.clear();
    data.materials.push(Material { emission: Vec3::splat(100.0), double_sided: true, ..Material::lambert(Vec3::ZERO) });
    let c = |x: f32, z: f32| Vec3::new(x, 2.94, z);
    place(&mut data, quad([c(-0.6, -0.6), c(0.6, -0.6), c(0.6, 0.6), c(-0.6, 0.6)], 2));
    let camera = Camera::look_at(Vec3::new(1.8, 1.2, 1.8), Vec3::new(-1.0, 1.9, -1.0), 1.1);
    let (frame, error) = bounded(data, &camera, 0.05);
    assert_honest(&frame, error);
}

/// Two bounces in a closed room with punctual lights: the verified error of all light is near the true one, and there
/// are no caustics.
#[test]
fn interreflections_are_counted() {
    let (frame, error) = bounded(room(), &room_camera(), 0.03);
    assert_honest(&frame, error);
    let estimate = frame.stats.error_estimate.expect("an estimate");
    assert_eq!(estimate.caustics, 0.0);
    assert!(estimate.all <= 2.0 * error.max(0.03), "{estimate:?} of {error}");
    assert!(estimate.uncertainty <= 0.035 && estimate.path_spp > 0, "{estimate:?}");
}

/// A picture without any light is exact if it is black.
#[test]
fn a_dark_room_is_dark() {
    let mut data = room();
    data.lights = vec![Light::Point { position: Vec3::Y * 9.0, intensity_cd: Vec3::ONE, range: Some(0.5) }];
    let scene = Scene::new(data).expect("scene");
    let frame = shoot(&scene, &room_camera(), &small(Method::with_error(0.05), 1));
    assert_eq!(frame.stats.estimated_error, Some(0.0));
}
