//! More lights than are summed one by one: clusters of them, within the error that is asked for.

use crate::common::*;
use glam::Vec3;
use lightmesh::{Error, Frame, Light, LightMesh, Method, RenderOptions, Scene, SceneData, Spacing, render};

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

/// The ladder of errors: each rung's picture, with the noise of the clusters' shadows, is within ε (empirical: ε is of
/// the unshadowed light) of that which knows every light, and takes fewer rays.
#[test]
fn pictures_are_as_near_as_they_say() {
    let scene = Scene::new(crowded()).expect("scene");
    let options = |light_error| options(Method::MESH).with(|o| o.transport.light_error = light_error);
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
    let with = |method: Method, refine| {
        let bounces = if method.error().is_some() { 0 } else { 1 };
        options(method).with(|o| {
            o.mesh.refine = refine;
            o.transport.bounces = bounces;
            o.mesh.gather_rays = Some(16);
        })
    };
    for options in [
        with(Method::MESH, None),
        with(Method::PAPER, None),
        with(Method::Hybrid, None),
        with(Method::Hybrid, Some(1)),
        with(Method::UNBIASED, None),
        with(Method::with_error(0.1), Some(1)),
    ] {
        let frames = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
            pool.install(|| {
                let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
                let mut frame = || render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame").image;
                [frame(), frame()]
            })
        });
        assert!(frames[0][0] == frames[0][1] && frames[0] == frames[1], "{options:?}");
    }
}

/// What is known light by light is known of clusters too: near to what knows every light and to the truth, with fewer
/// rays and less memory.
#[test]
fn hybrid_light_of_clusters_is_nearly_exact() {
    let scene = Scene::new(crowded()).expect("scene");
    let options = |light_error| {
        options(Method::Hybrid).with(|o| {
            o.transport.light_error = light_error;
            o.mesh.spacing = Spacing::Metres(0.05);
        })
    };
    let [every, clusters] = [0.0, 0.01].map(|error| shoot(&scene, &room_camera(), &options(error)));
    let truth = shoot(&scene, &room_camera(), &RenderOptions { method: Method::Standard, ..options(0.0) });
    let [off, from_truth] = [&every, &truth].map(|frame| relrmse(&clusters, frame));
    assert!(off < 0.02 && from_truth < 0.02, "{off}, from the truth {from_truth}");
    let [few, all] = [&clusters, &every].map(|frame| (frame.stats.rays.shadow, frame.stats.direct.bytes));
    assert!(10 * few.0 < 7 * all.0, "rays: {few:?} {all:?}");
    assert!(10 * few.1 < 8 * all.1, "bytes: {few:?} {all:?}");
    // Few lights are one by one, bit for bit.
    let scene = Scene::new(SceneData { lights: crowded().lights[..500].to_vec(), ..crowded() }).expect("scene");
    let [every, clusters] = [0.0, 0.01].map(|error| shoot(&scene, &room_camera(), &options(error)));
    assert_eq!(every.image, clusters.image);
}

/// Clusters that are chosen by what they seem to give, one of whose lights stands for all: the mean of pictures of many
/// seeds is the truth within its standard error, as in tests/accuracy.rs, over 12 tiles. Two thirds of the lamps float
/// around the box, little above the plane of its top or below it: most clusters seem to give it nothing, and some of
/// their lights do.
#[test]
fn unbiased_light_of_clusters_has_no_bias() {
    const SEEDS: u64 = 96;
    let mut data = crowded();
    for (i, light) in data.lights.iter_mut().enumerate().filter(|(i, _)| i % 3 != 0) {
        let Light::Point { position, .. } = light else { continue };
        let (angle, r) = (i as f32 * 2.4, 1.0 + 0.6 * (i % 19) as f32 / 18.0);
        *position = Vec3::new(r * libm::cosf(angle), 0.85 + 0.2 * (i % 23) as f32 / 22.0, r * libm::sinf(angle));
    }
    let scene = Scene::new(data).expect("scene");
    let sized = |method| {
        options(method).with(|o| {
            o.picture.width = 32;
            o.picture.height = 24;
            o.transport.light_error = 0.3;
        })
    };
    let truth = shoot(&scene, &room_camera(), &sized(Method::Standard)).image;
    let mut mesh = LightMesh::new(&scene, &sized(Method::UNBIASED)).expect("mesh");
    // 4 × 3 tiles, and all of them.
    let mut sums = [(0.0_f64, 0.0_f64); 13];
    for seed in 0..SEEDS {
        let options = sized(Method::UNBIASED).with(|o| {
            o.seed = seed;
            o.method = Method::unbiased(16);
        });
        let image = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame").image;
        let mut differences = [0.0; 13];
        for (i, (p, t)) in image.pixels.iter().zip(&truth.pixels).enumerate() {
            let d = f64::from((p - t).element_sum());
            differences[i % 32 / 8 + 4 * (i / 32 / 8)] += d;
            differences[12] += d;
        }
        for (sum, d) in sums.iter_mut().zip(differences) {
            *sum = (sum.0 + d, sum.1 + d * d);
        }
    }
    let n = SEEDS as f64;
    let z2 = sums.map(|(sum, squares)| sum * sum / n / ((squares - sum * sum / n) / (n - 1.0)));
    assert!(z2[12] < 16.0, "z² of the whole picture: {}", z2[12]);
    // The squares of Student's t with 95 degrees of freedom have a mean of 95/93.
    let mean = z2[..12].iter().sum::<f64>() / 12.0;
    assert!((mean - 95.0 / 93.0).abs() < 4.0 * (2.0_f64 / 12.0).sqrt(), "mean z² {mean}: {z2:?}");
}

/// What points keep of clusters is checked before it is stored, and the mesh stays as good as it was.
#[test]
fn clusters_at_points_keep_to_the_memory_limit() {
    let scene = Scene::new(crowded()).expect("scene");
    // Enough for the scene, rays, the tree, on one thread, and the points, but not for what they know.
    let max_memory = scene.bytes() + (24 << 20) + (1700 << 10);
    let options = options(Method::Hybrid).with(|o| {
        o.mesh.spacing = Spacing::Metres(0.05);
        o.limits.max_memory = max_memory;
    });
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("pool");
    pool.install(|| {
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        match render(&scene, &room_camera(), &options, &mut mesh, &()).err() {
            Some(Error::OutOfMemory { advice, .. }) => assert!(advice.contains("--light-error"), "{advice}"),
            other => panic!("{other:?}"),
        }
        assert!(mesh.stats().bytes <= max_memory);
    });
}

/// The truth knows every light, whatever is allowed.
#[test]
fn standard_and_path_have_no_clusters() {
    let scene = Scene::new(crowded()).expect("scene");
    for method in [Method::Standard, Method::Path] {
        let options = |light_error| {
            options(method).with(|o| {
                o.transport.light_error = light_error;
                o.picture.width = 8;
                o.picture.height = 6;
            })
        };
        let [a, b] = [0.0, 0.5].map(|error| shoot(&scene, &room_camera(), &options(error)).image);
        assert_eq!(a, b);
    }
}

/// A mesh that was filled from clusters is not one of every light.
#[test]
fn a_mesh_has_one_light_error() {
    let scene = Scene::new(crowded()).expect("scene");
    let mut mesh = LightMesh::new(&scene, &options(Method::MESH)).expect("mesh");
    let exact = options(Method::MESH).with(|o| o.transport.light_error = 0.0);
    assert!(render(&scene, &room_camera(), &exact, &mut mesh, &()).is_err());
    assert!(exact.with(|o| o.transport.light_error = 1.0).validate().is_err());
}
