//! Same input, same picture; warm or cold, one thread or two; cancelled or out of memory without a crash.

use crate::common::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use glam::Vec3;
use lightmesh::{Camera, Error, LightMesh, Method, Progress, RenderOptions, Scene, Spacing, Stage, render};

const METHODS: [Method; 6] =
    [Method::Standard, Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED, Method::Path];

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool").install(work)
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        let options = options(method).with(|o| {
            o.picture.spp = 2;
            o.transport.bounces = 2;
        });
        let one = with_threads(1, || shoot(&scene, &room_camera(), &options));
        let three = with_threads(3, || shoot(&scene, &room_camera(), &options));
        assert_eq!(one.image, three.image, "{method:?}");
    }
}

/// A warm mesh gives the picture of a cold one, and is not filled again.
#[test]
fn a_second_frame_only_reads() {
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH);
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let first = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
    let second = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
    assert_eq!(first.image, second.image);
    assert!(first.stats.rays.shadow > 0);
    assert_eq!(second.stats.rays.shadow, 0);
    assert_eq!(first.stats.direct, second.stats.direct);

    // Which frame asked first does not matter: another camera's frame before it changes nothing.
    let elsewhere = Camera::look_at(Vec3::new(-1.5, 2.5, -1.5), Vec3::new(0.0, 0.5, 0.5), 1.0);
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    render(&scene, &elsewhere, &options, &mut mesh, &()).expect("frame");
    let third = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
    assert_eq!(first.image, third.image);
}

#[test]
fn a_mesh_refuses_options_that_it_was_not_made_for() {
    let scene = Scene::new(room()).expect("scene");
    let mut mesh = LightMesh::new(&scene, &options(Method::MESH)).expect("mesh");
    let error = render(&scene, &room_camera(), &options(Method::PAPER), &mut mesh, &()).expect_err("other method");
    assert_eq!(error.to_string(), "the mesh was made with method mesh, and the options ask for paper");

    // Gather rays that follow mirrors less far bring other light.
    let deep = options(Method::MESH).with(|o| o.transport.bounces = 1);
    let mut mesh = LightMesh::new(&scene, &deep).expect("mesh");
    assert!(mesh.is_compatible(&deep));
    assert!(!mesh.is_compatible(&deep.clone().with(|o| o.transport.depth = 2)));
    // Where the error is bounded, the indirect mesh is finer by default.
    let bounded = deep.clone().with(|o| o.method = Method::with_error(0.05));
    mesh = LightMesh::new(&scene, &bounded).expect("mesh");
    assert!(mesh.is_compatible(&bounded) && !mesh.is_compatible(&RenderOptions { method: Method::Hybrid, ..deep }));
}

struct Stop;

impl Progress for Stop {
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn cancelling_ends_every_method() {
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        let options = options(method);
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let result = render(&scene, &room_camera(), &options, &mut mesh, &Stop);
        assert!(matches!(result, Err(Error::Cancelled)), "{method:?}");
    }
}

/// Says that the work should stop from the n-th time on that it is asked.
struct StopAt(AtomicU32);

impl Progress for StopAt {
    fn cancelled(&self) -> bool {
        self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| Some(n.saturating_sub(1))) == Ok(0)
    }
}

/// Wherever a frame was stopped, the next one with its mesh is the picture.
#[test]
fn a_mesh_outlives_frames_that_were_cancelled() {
    let scene = Scene::new(room()).expect("scene");
    for method in [Method::MESH, Method::PAPER, Method::Hybrid] {
        let options = options(method).with(|o| {
            o.transport.bounces = 2;
            o.mesh.gather_rays = Some(32);
        });
        let truth = shoot(&scene, &room_camera(), &options).image;
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let mut cancelled = 0;
        for n in 0..32 {
            let stop = StopAt(AtomicU32::new(1 << n));
            match render(&scene, &room_camera(), &options, &mut mesh, &stop) {
                Err(Error::Cancelled) => cancelled += 1,
                other => {
                    assert_eq!(other.expect("frame").image, truth, "{method:?}");
                    break;
                }
            }
        }
        assert!(cancelled > 3, "{method:?}: {cancelled}");
    }
}

/// A fill that takes long ends soon after it was cancelled, not when all of its points are evaluated.
#[test]
fn a_fill_that_is_cancelled_ends_early() {
    /// Stops from the third time on that it is asked, and counts the rays.
    struct Third {
        stop: StopAt,
        rays: AtomicU64,
    }
    impl Progress for Third {
        fn report(&self, _: Stage, _: u64, _: u64, rays: u64) {
            self.rays.store(rays, Ordering::Relaxed);
        }
        fn cancelled(&self) -> bool {
            self.stop.cancelled()
        }
    }

    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH).with(|o| o.mesh.spacing = Spacing::Metres(0.1));
    let mesh = || LightMesh::new(&scene, &options).expect("mesh");
    let whole = mesh().prefill_box(&scene, &options, &scene.bounds(), &()).expect("fill");
    let third = Third { stop: StopAt(AtomicU32::new(2)), rays: AtomicU64::new(0) };
    let result = mesh().prefill_box(&scene, &options, &scene.bounds(), &third);
    assert!(matches!(result, Err(Error::Cancelled)));
    let (traced, all) = (third.rays.into_inner(), whole.rays.total());
    assert!(4 * traced < all, "{traced} of {all} rays");
}

#[test]
fn memory_is_checked_before_it_is_taken() {
    let scene = Scene::new(room()).expect("scene");
    let message = |options: &RenderOptions| {
        let mut mesh = match LightMesh::new(&scene, options) {
            Ok(mesh) => mesh,
            Err(error) => return error.to_string(),
        };
        render(&scene, &room_camera(), options, &mut mesh, &()).expect_err("too much").to_string()
    };
    let huge = options(Method::MESH).with(|o| {
        o.picture.width = 60_000;
        o.picture.height = 60_000;
    });
    assert!(message(&huge).contains("memory") && message(&huge).contains("--size"));
    let fine = options(Method::MESH).with(|o| o.mesh.spacing = Spacing::Metres(1e-9));
    assert!(message(&fine).contains("spacing") && message(&fine).contains("mesh points"), "{}", message(&fine));
    let tight = options(Method::MESH).with(|o| {
        o.mesh.spacing = Spacing::Metres(0.02);
        o.limits.max_memory = 1 << 20;
    });
    assert!(message(&tight).contains("memory") && message(&tight).contains("--spacing"), "{}", message(&tight));
}

#[test]
fn no_light_is_black_and_no_surface_is_an_error() {
    let mut data = room();
    data.lights.clear();
    let scene = Scene::new(data).expect("scene");
    for method in METHODS {
        assert!(shoot(&scene, &room_camera(), &options(method)).image.pixels.iter().all(|&p| p == Vec3::ZERO));
    }
    assert!(matches!(Scene::new(lightmesh::SceneData::default()), Err(Error::EmptyScene)));
}

/// What a progress bar sees: it begins at nothing, never goes back and ends at the whole.
#[test]
fn progress_begins_at_zero_and_ends_at_all() {
    #[derive(Default)]
    struct Log(Mutex<Vec<(u64, u64, u64)>>);
    impl Progress for Log {
        fn report(&self, _: Stage, done: u64, total: u64, rays: u64) {
            self.0.lock().expect("log").push((done, total, rays));
        }
    }
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        let options = options(method);
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let log = Log::default();
        let frame = render(&scene, &room_camera(), &options, &mut mesh, &log).expect("frame");
        let log = log.0.into_inner().expect("log");
        let total = 64 * 48;
        assert_eq!(log.first(), Some(&(0, total, 0)), "{method:?}");
        assert_eq!(log.last(), Some(&(total, total, frame.stats.rays.total())), "{method:?}");
        assert!(log.windows(2).all(|w| w[0].0 <= w[1].0), "{method:?}");
    }
}
