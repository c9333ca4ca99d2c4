//! More lights than are summed one by one: clusters of them, within the error that is asked for.

mod common;

use common::*;
use glam::Vec3;
use lightmesh::{Frame, Light, LightMesh, Method, RenderOptions, Scene, SceneData, render};

/// The room under 2000 lamps: a grid below its ceiling, every third a spot, and a ball of them in a corner.
fn crowded() -> SceneData {
    let mut data = room();
    data.lights = (0..2000)
        .map(|i| {
            let (x, z) = ((i % 40) as f32 / 39.0, (i / 40 % 25) as f32 / 24.0);
            let position = if i < 1000 {
                Vec3::new(3.6 * x - 1.8, 2.7, 3.6 * z - 1.8)
            } else {
                Vec3::new(-1.4, 1.5, -1.4) + 0.3 * Vec3::new(libm::sinf(i as f32), x - 0.5, libm::cosf(i as f32))
            };
            let intensity_cd = Vec3::new(1.0, 0.5 + 0.5 * x, 0.5 + 0.5 * z) * 0.02;
            match i % 3 {
                0 => Light::Spot {
                    position,
                    direction: Vec3::NEG_Y,
                    intensity_cd,
                    range: Some(6.0),
                    inner_cone_angle: 0.5,
                    outer_cone_angle: 0.9,
                },
                _ => point_light(position, intensity_cd),
            }
        })
        .collect();
    data
}

fn relrmse(a: &Frame, b: &Frame) -> f32 {
    let pairs = || a.image.pixels.iter().zip(&b.image.pixels);
    let squares: f32 = pairs().map(|(a, b)| (a - b).length_squared() / 3.0).sum();
    let mean: f32 = pairs().map(|(_, b)| b.element_sum() / 3.0).sum();
    (squares * pairs().len() as f32).sqrt() / mean
}

/// The ladder of errors: each rung's picture, with the noise of the clusters' shadows, is within ε (empirical: ε is of the unshadowed light) of
/// that which knows every light, and takes fewer rays.
#[test]
fn pictures_are_as_near_as_they_say() {
    let scene = Scene::new(crowded()).expect("scene");
    let options = |light_error| RenderOptions { light_error, ..options(Method::Mesh) };
    let exact = shoot(&scene, &room_camera(), &options(0.0));
    let mut rays = exact.stats.rays.shadow;
    for error in [0.003, 0.01, 0.03] {
        let frame = shoot(&scene, &room_camera(), &options(error));
        let off = relrmse(&frame, &exact);
        assert!(off < error, "{off} {error}");
        assert!(frame.stats.rays.shadow < rays, "{} {rays}", frame.stats.rays.shadow);
        rays = frame.stats.rays.shadow;
    }
}

/// Bit for bit: one thread or three, first or second frame, camera rays or gather rays first.
#[test]
fn clusters_are_the_same_whoever_asks() {
    let scene = Scene::new(crowded()).expect("scene");
    for method in [Method::Mesh, Method::Paper] {
        let options = RenderOptions { bounces: 1, gather_rays: 16, ..options(method) };
        let frames = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
            pool.install(|| {
                let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
                let mut frame = || render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame").image;
                [frame(), frame()]
            })
        });
        assert!(frames[0][0] == frames[0][1] && frames[0] == frames[1], "{method:?}");
    }
}

/// The truth knows every light, whatever is allowed.
#[test]
fn standard_and_path_have_no_clusters() {
    let scene = Scene::new(crowded()).expect("scene");
    for method in [Method::Standard, Method::Path] {
        let options = |light_error| RenderOptions { light_error, width: 8, height: 6, ..options(method) };
        let [a, b] = [0.0, 0.5].map(|error| shoot(&scene, &room_camera(), &options(error)).image);
        assert_eq!(a, b);
    }
}

/// A mesh that was filled from clusters is not one of every light.
#[test]
fn a_mesh_has_one_light_error() {
    let scene = Scene::new(crowded()).expect("scene");
    let mut mesh = LightMesh::new(&scene, &options(Method::Mesh)).expect("mesh");
    let exact = RenderOptions { light_error: 0.0, ..options(Method::Mesh) };
    assert!(render(&scene, &room_camera(), &exact, &mut mesh, &()).is_err());
    assert!(RenderOptions { light_error: 1.0, ..exact }.validate().is_err());
}
