//! Pictures of a render in progress, and renders whose time is limited.

use crate::common::*;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use glam::Vec3;
use lightmesh::{Aov, Error, Frame, Image, LightMesh, Method, Progress, RenderOptions, Scene, Viewer, render};

const METHODS: [Method; 4] = [Method::Standard, Method::MESH, Method::PAPER, Method::Path];

/// Keeps every picture it is shown.
#[derive(Default)]
struct Album(Mutex<Vec<Image>>);

impl Viewer for Album {
    fn show(&self, picture: Image) {
        self.0.lock().expect("album").push(picture);
    }
}

impl Progress for Album {
    fn viewer(&self) -> Option<&dyn Viewer> {
        Some(self)
    }
}

fn watched(scene: &Scene, options: &RenderOptions) -> (Frame, Vec<Image>) {
    let mut mesh = LightMesh::new(scene, options).expect("mesh");
    let album = Album::default();
    let frame = render(scene, &room_camera(), options, &mut mesh, &album).expect("frame");
    (frame, album.0.into_inner().expect("album"))
}

/// Looking changes nothing: the same picture, layers and mesh bit for bit, with every method.
#[test]
fn a_viewer_changes_nothing_and_sees_the_finished_picture_last() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    for method in METHODS {
        for spp in [1, 4, 20] {
            let aovs = [Aov::Normal, Aov::Depth, Aov::Direct].into_iter().collect();
            let options = options(method).with(|o| {
                o.picture.spp = spp;
                o.transport.bounces = 1;
                o.picture.aovs = aovs;
            });
            let alone = shoot(&scene, &room_camera(), &options);
            let (frame, album) = watched(&scene, &options);
            assert_eq!(frame.image, alone.image, "{method:?} {spp}");
            assert_eq!(frame.layers, alone.layers, "{method:?} {spp}");
            assert_eq!(frame.stats.direct, alone.stats.direct, "{method:?} {spp}");
            assert_eq!(frame.stats.spp, spp);
            assert!(!frame.stats.time_limit_reached);
            assert_eq!(album.last(), Some(&frame.image), "{method:?} {spp}");
            assert!(album.len() >= 4, "{method:?} {spp}: {} pictures", album.len());
        }
    }
}

/// The first picture is whole, in blocks, and already resembles the last; each next one is a picture too.
#[test]
fn sketches_come_first_and_resemble_the_picture() {
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        let options = options(method).with(|o| o.picture.spp = 4);
        let (frame, album) = watched(&scene, &options);
        let error = |image: &Image| {
            assert_eq!((image.width, image.height, image.pixels.len()), (64, 48, 64 * 48));
            assert!(image.pixels.iter().all(|p| p.is_finite()));
            let sum = |f: &dyn Fn(usize) -> Vec3| (0..64 * 48).map(|i| f(i).abs().element_sum()).sum::<f32>();
            sum(&|i| image.pixels[i] - frame.image.pixels[i]) / sum(&|i| frame.image.pixels[i])
        };
        let errors: Vec<f32> = album.iter().map(error).collect();
        for (stride, sketch) in [8, 4, 2].into_iter().zip(&album) {
            if stride == 2 && method == Method::Path {
                continue;
            }
            for (i, &pixel) in sketch.pixels.iter().enumerate() {
                let corner = i / 64 / stride * stride * 64 + i % 64 / stride * stride;
                assert_eq!(pixel, sketch.pixels[corner], "{method:?}, stride {stride}");
            }
        }
        assert!(errors[0] < 0.5 && errors[1] < errors[0], "{method:?}: {errors:?}");
        assert_eq!(errors.last(), Some(&0.0), "{method:?}");
    }
}

/// Who wants no picture on the way gets the finished one.
#[test]
fn nothing_but_the_end_for_who_wants_nothing() {
    #[derive(Default)]
    struct Patient(Album);
    impl Viewer for Patient {
        fn wants_picture(&self) -> bool {
            false
        }
        fn show(&self, picture: Image) {
            self.0.show(picture);
        }
    }
    impl Progress for Patient {
        fn viewer(&self) -> Option<&dyn Viewer> {
            Some(self)
        }
    }
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH);
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let patient = Patient::default();
    let frame = render(&scene, &room_camera(), &options, &mut mesh, &patient).expect("frame");
    assert_eq!(patient.0.0.into_inner().expect("album"), [frame.image]);
}

/// No time at all: one sample for every pixel, and pixels that are alike whether somebody looks or not.
#[test]
fn a_tiny_limit_takes_one_sample_per_pixel() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    for method in METHODS {
        let limited = options(method).with(|o| {
            o.picture.spp = 100;
            o.picture.time_limit = Some(Duration::from_nanos(1));
        });
        let frame = shoot(&scene, &room_camera(), &limited);
        assert_eq!((frame.stats.spp, frame.stats.time_limit_reached), (1, true), "{method:?}");
        assert_eq!(frame.stats.rays.primary, 64 * 48);
        assert!(frame.image.pixels.iter().any(|&p| p != Vec3::ZERO));
        let (watched, album) = watched(&scene, &limited);
        assert_eq!(watched.image, frame.image, "{method:?}");
        assert_eq!(album.last(), Some(&frame.image), "{method:?}");

        // The most is one: at the pixels' centres, as without a limit.
        let one = limited.with(|o| o.picture.spp = 1);
        let frame = shoot(&scene, &room_camera(), &one);
        assert!(!frame.stats.time_limit_reached);
        assert_eq!(frame.image, shoot(&scene, &room_camera(), &options(method)).image, "{method:?}");
    }
}

/// A limit that is not reached: all samples, and the picture that there is without it but for the rounding of sums. A
/// sum of n floats is off by at most n times 2⁻²⁴ of it, twice that between two orders; a pixel has fewer than 500.
#[test]
fn a_generous_limit_takes_all_samples() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    for method in METHODS {
        let free = options(method).with(|o| o.picture.spp = 4);
        let limited = free.clone().with(|o| o.picture.time_limit = Some(Duration::from_secs(3600)));
        let (free, limited) = (shoot(&scene, &room_camera(), &free), shoot(&scene, &room_camera(), &limited));
        assert_eq!((limited.stats.spp, limited.stats.time_limit_reached), (4, false), "{method:?}");
        assert_eq!(limited.stats.rays.primary, free.stats.rays.primary, "{method:?}");
        for (a, b) in limited.image.pixels.iter().zip(&free.image.pixels) {
            let off = (*a - *b).abs();
            assert!(off.cmple(b.abs() * 6e-5).all(), "{method:?}: {a} {b}");
        }
        if method == Method::Path {
            assert_eq!(limited.image, free.image);
        }
    }
}

/// Half a second is used, or four times what the first pass takes where that is more, for more samples than the first
/// pass, and not exceeded by much. Layers are means over the same samples as the light.
#[test]
fn the_limit_is_kept() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    // Threads that no other test has work for.
    let threads = rayon::ThreadPoolBuilder::new().build().expect("threads");
    let timed = |options: &RenderOptions| {
        let started = Instant::now();
        let frame = threads.install(|| shoot(&scene, &room_camera(), options));
        (frame, started.elapsed())
    };
    for method in METHODS {
        let aovs = [Aov::Direct, Aov::Indirect].into_iter().collect();
        let free = options(method).with(|o| {
            o.picture.spp = 1;
            o.transport.bounces = 1;
            o.mesh.gather_rays = Some(16);
            o.picture.aovs = aovs;
        });
        let limit = Duration::from_millis(500).max(4 * timed(&free).1);
        let (frame, time) = timed(&free.with(|o| {
            o.picture.spp = 65536;
            o.picture.time_limit = Some(limit);
        }));
        assert!(frame.stats.time_limit_reached && frame.stats.spp > 1, "{method:?}: {}", frame.stats.spp);
        assert!(time >= limit && time < 2 * limit + Duration::from_millis(1500), "{method:?}: {time:?} of {limit:?}");
        let layer = |i: usize| frame.layers[i].values.as_chunks().0.iter().map(|&rgb| Vec3::from_array(rgb));
        for ((pixel, direct), indirect) in frame.image.pixels.iter().zip(layer(0)).zip(layer(1)) {
            let off = (direct + indirect - *pixel).abs();
            assert!(off.cmple(*pixel * 1e-3).all(), "{method:?}: {pixel}, {direct} + {indirect}");
        }
    }
}

#[test]
fn no_time_is_no_limit_that_can_be_kept() {
    let options = options(Method::MESH).with(|o| o.picture.time_limit = Some(Duration::ZERO));
    assert!(matches!(options.validate(), Err(Error::InvalidOption { option: "time-limit", .. })));
}
