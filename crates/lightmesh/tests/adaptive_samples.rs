//! Samples that follow the noise.

use std::sync::Mutex;

use crate::common::*;
use glam::Vec3;
use lightmesh::metrics::difference;
use lightmesh::{Aov, Camera, Image, LightMesh, Material, Method, Progress, RenderOptions, Scene, Viewer, render};

/// A room with exact light: nothing but outlines and edges of shadows has noise.
fn exact() -> RenderOptions {
    options(Method::Standard).with(|o| {
        (o.picture.width, o.picture.height, o.picture.spp) = (32, 24, 4);
        o.transport.bounces = 0;
    })
}

fn up_to(most: u32) -> RenderOptions {
    exact().with(|o| o.picture.most_spp = Some(most))
}

/// The room with a fence of thin dark posts in one of its corners.
fn fence() -> Scene {
    let mut data = room();
    data.materials.push(Material::lambert(Vec3::splat(0.02)));
    let dark = data.materials.len() - 1;
    for i in 0..16 {
        let (x, z) = (-1.6 + 0.05 * i as f32, 0.4);
        place(&mut data, cuboid(Vec3::new(x, 0.0, z), Vec3::new(x + 0.02, 1.0, z + 0.02), dark));
    }
    Scene::new(data).expect("scene")
}

/// A third more samples bring the error by outlines down by a fifth, against 256 of each pixel; what has no
/// noise is bit for bit as it was, the layers too, and the error by noise that is left is what it was to be.
#[test]
fn a_few_more_samples_where_the_noise_is() {
    let scene = fence();
    let layered = |options: RenderOptions| options.with(|o| o.picture.aovs = [Aov::Normal].into_iter().collect());
    let truth = shoot(&scene, &room_camera(), &exact().with(|o| o.picture.spp = 256)).image;
    let even = shoot(&scene, &room_camera(), &layered(exact()));
    let more = shoot(&scene, &room_camera(), &layered(up_to(64)));
    let error = |image: &Image| difference(&image.pixels, &truth.pixels).relrmse;
    let (before, after) = (error(&even.image), error(&more.image));
    let samples = more.stats.rays.primary as f64 / even.stats.rays.primary as f64;
    assert!(after < 0.85 * before && samples < 1.5, "{before} {after}, {samples} times the samples");
    let estimate = more.stats.sampling_error.expect("an estimate");
    assert!(estimate <= 0.025 && estimate > 0.5 * after && estimate < 2.0 * after, "{estimate} {after}");
    assert_eq!((more.stats.spp, even.stats.sampling_error), (4, None));

    let same = even.image.pixels.iter().zip(&more.image.pixels).filter(|(a, b)| a == b).count();
    assert!(same * 4 > even.image.pixels.len() * 3, "{same}");
    for (a, b) in even.layers[0].values.iter().zip(&more.layers[0].values) {
        assert!((a - b).abs() <= 1.0 && b.abs() <= 1.0 + 1e-6);
    }
}

/// Methods that have no such samples, and a most that is no more than each pixel has, change nothing.
#[test]
fn where_samples_do_not_follow_noise_nothing_changes() {
    let scene = Scene::new(room()).expect("scene");
    for (method, spp, most) in
        [(Method::UNBIASED, 4, 64), (Method::Path, 4, 64), (Method::Standard, 4, 4), (Method::Standard, 1, 64)]
    {
        let even = exact().with(|o| (o.method, o.picture.spp) = (method, spp));
        let more = even.clone().with(|o| o.picture.most_spp = Some(most));
        assert_eq!(shoot(&scene, &room_camera(), &even).image, shoot(&scene, &room_camera(), &more).image);
    }
}

/// Bit for bit the same by one thread and by four, with a warm mesh, and with a viewer, who sees no dark pixel on the way.
#[test]
fn it_is_the_same_picture_however_it_is_made() {
    struct Watcher(Mutex<Vec<Image>>);
    impl Viewer for Watcher {
        fn wants_picture(&self) -> bool {
            true
        }
        fn show(&self, image: Image) {
            self.0.lock().expect("no panic").push(image);
        }
    }
    impl Progress for Watcher {
        fn viewer(&self) -> Option<&dyn Viewer> {
            Some(self)
        }
    }

    let scene = Scene::new(room()).expect("scene");
    let camera = Camera::look_at(Vec3::new(1.6, 1.5, 1.7), Vec3::new(-0.4, 0.8, -0.6), 1.1);
    let options = up_to(16).with(|o| (o.method, o.transport.bounces) = (Method::Hybrid, 1));
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let first = render(&scene, &camera, &options, &mut mesh, &()).expect("frame");
    assert_eq!(first.image, render(&scene, &camera, &options, &mut mesh, &()).expect("frame").image);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert_eq!(first.image, one.install(|| shoot(&scene, &camera, &options)).image);

    let watcher = Watcher(Mutex::default());
    let watched = render(&scene, &camera, &options, &mut mesh, &watcher).expect("frame");
    assert_eq!(watched.image, first.image);
    let shown = watcher.0.into_inner().expect("no panic");

    for image in shown.iter().rev().take(3) {
        let pairs = image.pixels.iter().zip(&first.image.pixels);
        let dark = pairs.filter(|(shown, last)| **shown == Vec3::ZERO && **last != Vec3::ZERO).count();
        assert!(dark == 0, "{dark} dark pixels");
    }
}
