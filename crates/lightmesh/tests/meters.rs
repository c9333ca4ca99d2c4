//! Meters: closed forms, pictures of the same places, paths, and bits that depend on nothing but the place.

use std::f32::consts::PI;
use std::sync::Mutex;

use crate::common::*;
use glam::{Vec3, Vec3Swizzles};
use lightmesh::geometry::{Aabb, Sphere};
use lightmesh::{
    Camera, EmitterOptions, Error, LightMesh, Material, Measured, Meter, Method, Progress, RenderOptions, Scene,
    SceneData, Spacing, Stage, measure,
};

const METHODS: [Method; 6] =
    [Method::Standard, Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED, Method::Path];

fn meter(position: [f32; 3], normal: [f32; 3]) -> Meter {
    Meter { position: position.into(), normal: normal.into() }
}

fn read(scene: &Scene, meters: &[Meter], options: &RenderOptions) -> Measured {
    let mut mesh = LightMesh::new(scene, options).expect("mesh");
    measure(scene, meters, options, &mut mesh, &()).expect("measured")
}

fn with_bounces(method: Method, bounces: u32) -> RenderOptions {
    options(method).with(|o| {
        o.transport.bounces = bounces;
        o.mesh.indirect_spacing = Spacing::Metres(0.4);
    })
}

/// Meters on the floor, on a wall, in the air, on the box's lid, a few in the box, of every direction.
fn meters_in_the_room() -> Vec<Meter> {
    let mut meters = vec![
        meter([1.2, 0.0, 1.3], [0.0, 1.0, 0.0]),
        meter([-2.0, 1.1, 0.4], [1.0, 0.0, 0.0]),
        meter([0.1, 1.0, 0.0], [0.0, 2.0, 0.0]),
        meter([1.0, 0.85, -1.2], [0.0, 1e-30, 0.0]),
        meter([1.0, 0.85, -1.2], [0.0, -1.0, 0.0]),
    ];
    for i in 0..60_u16 {
        let (x, y, z) = (f32::from(i % 5), f32::from(i / 5 % 4), f32::from(i / 20));
        meters.push(meter([0.7 * x - 1.5, 0.3 + 0.7 * y, 1.2 * z - 1.3], [x - 2.1, y - 1.3, z - 0.8]));
    }
    meters
}

/// I cosθ / r², to 1e-5: a meter in free space that faces anywhere.
#[test]
fn a_point_light_gives_a_meter_intensity_times_cosine_over_squared_distance() {
    let mut data = floor(Vec3::splat(0.5));
    let (lamp, intensity) = (Vec3::new(0.3, 2.7, -0.2), Vec3::new(100.0, 50.0, 10.0));
    data.lights.push(point_light(lamp, intensity));
    // A roof, so that the meters are in the scene's box.
    place(&mut data, cuboid(Vec3::new(-9.0, 4.0, -9.0), Vec3::new(9.0, 4.1, 9.0), 0));
    let scene = Scene::new(data).expect("scene");
    let meters: Vec<_> = [[0.0, 1.0, 0.0], [0.3, 0.8, -0.4], [0.9, 0.1, 0.1], [0.0, -1.0, 0.0]]
        .into_iter()
        .flat_map(|n| [[0.0, 0.0, 0.0], [1.4, 0.85, 2.0], [-3.0, 1.5, 0.5]].map(|p| meter(p, n)))
        .collect();
    for method in [Method::Standard, Method::MESH, Method::Path] {
        let measured = read(&scene, &meters, &options(method));
        for (meter, e) in meters.iter().zip(&measured.direct) {
            let d = (lamp - meter.position).as_dvec3();
            let cos = meter.normal.as_dvec3().normalize().dot(d.normalize()).max(0.0);
            let expected = intensity * (cos / d.length_squared()) as f32;
            assert!((*e - expected).abs().max_element() <= 1e-5 * expected.max_element(), "{method:?} {meter:?}: {e}");
        }
        assert!(measured.indirect.iter().all(|&e| e == Vec3::ZERO));
    }
}

/// Irradiance from a polygon of radiance 1, its corners seen counter-clockwise, all above the meter's plane: Lambert's
/// formula, E = ½ Σ_i Θ_i n·Γ_i, Θ_i the angle that edge i spans and Γ_i the unit normal of the plane through it and
/// the meter (Lambert, "Photometria", 1760; Arvo, "Analytic Methods for Simulated Light Transport", 1995, eq. 2.21).
fn lambert(corners: &[Vec3], p: Vec3, n: Vec3) -> f32 {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let sum: f32 = edges.map(|(&a, &b)| (a - p).angle_between(b - p) * n.dot((a - p).cross(b - p).normalize())).sum();
    (0.5 * sum).abs()
}

/// A black lamp of 100 cd/m².
fn lamp() -> Material {
    Material { emission: Vec3::splat(100.0), ..Material::lambert(Vec3::ZERO) }
}

/// A rectangle, by Lambert's formula, and a sphere, E = π L (r/d)² cosθ where all of it is above the horizon; each
/// within 1%.
#[test]
fn lamps_of_a_size_have_closed_forms() {
    let emitters = EmitterOptions { light_samples: 4096, ..EmitterOptions::default() };
    let spacing = Spacing::Metres(0.25);
    let meters = [
        meter([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        meter([0.9, 0.85, -0.7], [0.0, 1.0, 0.0]),
        meter([-1.5, 0.3, 1.0], [0.5, 0.7, -0.3]),
    ];
    let check = |data: SceneData, expected: &dyn Fn(Vec3, Vec3) -> f32| {
        let scene = Scene::with_emitters(data, &emitters).expect("scene");
        for (method, spp) in [(Method::Standard, 1), (Method::MESH, 1), (Method::Path, 16384)] {
            let measured = read(
                &scene,
                &meters,
                &options(method).with(|o| {
                    o.picture.spp = spp;
                    o.mesh.spacing = spacing;
                }),
            );
            for (meter, e) in meters.iter().zip(&measured.direct) {
                let expected = 100.0 * expected(meter.position, meter.normal.normalize());
                assert!((e.x / expected - 1.0).abs() < 0.01, "{method:?}, {meter:?}: {e} {expected}");
            }
        }
    };
    let mut data = floor(Vec3::splat(0.5));
    data.materials.push(lamp());
    let c = |x: f32, z: f32| Vec3::new(x * 0.5, 2.0, z * 0.75);
    let corners = [c(-1.0, -1.0), c(1.0, -1.0), c(1.0, 1.0), c(-1.0, 1.0)];
    place(&mut data, quad(corners, 1));
    check(data, &|p, n| lambert(&corners, p, n));

    let mut data = floor(Vec3::splat(0.5));
    data.materials.push(lamp());
    let center = Vec3::new(0.0, 2.2, 0.0);
    data.spheres.push(Sphere { center, radius: 0.3, material: 1 });
    check(data, &|p, n| {
        let d = center - p;
        PI * 0.09 / d.length_squared() * n.dot(d.normalize())
    });
}

/// A closed box in which everything has albedo a and emits 1 cd/m²: π / (1 − a) on every plane, less a^(N+1) of it
/// after N bounces.
#[test]
fn a_furnace_shines_alike_on_every_meter() {
    for (a, bounces) in [(0.2_f32, 4), (0.6, 20)] {
        let glow = Material { emission: Vec3::ONE, ..Material::lambert(Vec3::splat(a)) };
        let mut data = SceneData { materials: vec![glow], ..SceneData::default() };
        place(&mut data, inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0)));
        place(&mut data, cuboid(Vec3::new(-0.5, 0.0, -0.6), Vec3::new(0.6, 1.0, 0.5), 0));
        let scene = Scene::new(data).expect("scene");
        let expected = PI * (1.0 - a.powi(bounces + 1)) / (1.0 - a);
        for (method, tolerance) in [(Method::MESH, 0.02), (Method::Path, 0.03)] {
            let options = with_bounces(method, bounces as u32).with(|o| o.picture.spp = 1024);
            // In the box it is dark.
            let mut meters = meters_in_the_room();
            meters.retain(|meter| meter.position.xz().abs().max_element() > 0.6 || meter.position.y > 1.0);
            let measured = read(&scene, &meters, &options);
            for ((meter, direct), indirect) in meters.iter().zip(&measured.direct).zip(&measured.indirect) {
                let off = ((*direct + *indirect) / expected - Vec3::ONE).abs().max_element();
                assert!(off < tolerance, "{method:?}, {meter:?}: {direct} {indirect} {expected}");
            }
        }
    }
}

/// What a Lambertian surface shows is a/π of what a meter on it reads: L = a E / π, to rounding.
#[test]
fn meters_read_what_pictures_show() {
    let albedo = Vec3::splat(0.7);
    let scene = Scene::new(room()).expect("scene");
    for method in [Method::Standard, Method::MESH, Method::PAPER, Method::Hybrid] {
        let bounces = if method == Method::Standard { 0 } else { 3 };
        let options = with_bounces(method, bounces).with(|o| {
            o.picture.width = 1;
            o.picture.height = 1;
            // Chosen by position, bit for bit: a hit is not quite the place.
            o.mesh.near_rays = 0;
        });
        for place in [Vec3::new(1.2, 0.0, 1.3), Vec3::new(-1.1, 0.0, -1.4), Vec3::new(0.9, 0.0, 0.0)] {
            // The picture's ray is along an axis: its hit is the place.
            let camera = Camera::look_at(place + Vec3::Y * 0.5, place, 1e-6);
            let shown = shoot(&scene, &camera, &options).image.pixels[0];
            let measured = read(&scene, &[Meter { position: place, normal: Vec3::Y }], &options);
            let expected = albedo / PI * (measured.direct[0] + measured.indirect[0]);
            let off = (shown - expected).abs().max_element() / expected.max_element();
            assert!(off < 1e-4 && expected != Vec3::ZERO, "{method:?} at {place}: {shown} {expected}");
        }
    }
}

/// The mesh against paths, as the mean over meters in a room: within 5%. Unbiased ones within noise.
#[test]
fn meters_agree_with_paths() {
    let scene = Scene::new(room()).expect("scene");
    // Off the walls and not in the box.
    let clear = |m: &Meter| m.position.abs().max_element() < 1.9 && m.position.y > 1.1;
    let meters: Vec<Meter> = meters_in_the_room().into_iter().filter(clear).collect();
    let sums = |method| {
        let options = with_bounces(method, 3).with(|o| o.picture.spp = 1024);
        let measured = read(&scene, &meters, &options);
        [measured.direct, measured.indirect].map(|e| e.into_iter().sum::<Vec3>())
    };
    let truth = sums(Method::Path);
    for (method, tolerances) in
        [(Method::MESH, [0.05, 0.05]), (Method::Hybrid, [0.01, 0.05]), (Method::unbiased(1024), [1e-4, 0.02])]
    {
        let found = sums(method);
        for i in 0..2 {
            let off = (found[i] / truth[i] - Vec3::ONE).abs().max_element();
            assert!(off < tolerances[i], "{method:?} {i}: {} {}", found[i], truth[i]);
        }
    }
}

/// The same bits on one thread and on three, alone and among others, first and last, in a fresh mesh and in a warm one.
#[test]
fn a_meter_depends_on_its_place_alone() {
    let scene = Scene::new(room()).expect("scene");
    let meters = meters_in_the_room();
    for method in METHODS {
        let options = with_bounces(method, 2).with(|o| o.picture.spp = 300);
        let on = |threads, meters: &[Meter]| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
            let Measured { direct, indirect, .. } = pool.install(|| read(&scene, meters, &options));
            direct.into_iter().zip(indirect).collect::<Vec<_>>()
        };
        let all = on(1, &meters);
        let mut backwards: Vec<Meter> = meters.repeat(3);
        backwards.reverse();
        let mut turned = on(3, &backwards);
        turned.reverse();
        assert_eq!(turned, all.repeat(3), "{method:?}");
        for i in [0, 4, 17] {
            assert_eq!(on(2, &meters[i..=i]), all[i..=i], "{method:?}");
        }
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        lightmesh::render(&scene, &room_camera(), &options.clone().with(|o| o.picture.spp = 1), &mut mesh, &())
            .expect("frame");
        let warm = measure(&scene, &meters, &options, &mut mesh, &()).expect("measured");
        assert_eq!(warm.direct.into_iter().zip(warm.indirect).collect::<Vec<_>>(), all, "{method:?}");
    }
}

/// Outside the scene's box there is no mesh: direct light is exact, and the indirect light of a lit wall arrives.
#[test]
fn meters_outside_the_scene_get_exact_light() {
    let mut data = floor(Vec3::splat(0.5));
    data.lights.push(point_light(Vec3::new(0.0, 30.0, 0.0), Vec3::splat(900.0)));
    let scene = Scene::new(data).expect("scene");
    let meters = [meter([0.0, 20.0, 0.0], [0.0, 1.0, 0.0]), meter([0.0, 5.0, 0.0], [0.0, -1.0, 0.0])];
    for method in [Method::MESH, Method::Hybrid, Method::PAPER, Method::unbiased(4096)] {
        let measured = read(&scene, &meters, &with_bounces(method, 1));
        assert!((measured.direct[0] / 9.0 - Vec3::ONE).abs().max_element() < 1e-5, "{method:?}: {:?}", measured.direct);
        assert_eq!((measured.direct[1], measured.indirect[0]), (Vec3::ZERO, Vec3::ZERO), "{method:?}");
        let path = read(&scene, &meters, &with_bounces(Method::Path, 1).with(|o| o.picture.spp = 4096));
        let off = (measured.indirect[1] / path.indirect[1] - Vec3::ONE).abs().max_element();
        assert!(off < 0.06, "{method:?}: {:?} {:?}", measured.indirect, path.indirect);
    }
}

#[test]
fn meters_that_make_no_sense_are_refused_by_their_index() {
    let scene = Scene::new(room()).expect("scene");
    let good = meter([0.0, 2.0, 0.0], [0.0, 1.0, 0.0]);
    for method in METHODS {
        let options = options(method);
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let mut error = |bad| measure(&scene, &[good, bad], &options, &mut mesh, &()).expect_err("refused").to_string();
        assert_eq!(
            error(meter([0.0; 3], [0.0; 3])),
            "meter 1: the normal is zero: it must say which way the meter faces"
        );
        let message = error(meter([0.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]));
        assert!(message.starts_with("meter 1: the position") && message.contains("not finite"), "{message}");
        assert!(error(meter([0.0; 3], [0.0, f32::INFINITY, 0.0])).starts_with("meter 1: the normal"));
        let none = measure(&scene, &[], &options, &mut mesh, &()).expect("nothing");
        assert!(none.direct.is_empty() && none.indirect.is_empty());
    }
}

#[test]
fn options_that_need_a_picture_are_refused() {
    let scene = Scene::new(room()).expect("scene");
    let base = options(Method::MESH);
    let refused = |options: RenderOptions| {
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        match measure(&scene, &meters_in_the_room(), &options, &mut mesh, &()) {
            Err(Error::InvalidOption { option, .. }) => option,
            other => panic!("{other:?}"),
        }
    };
    // An error is kept to in pictures: meters measure as *hybrid* does.
    let [bounded, hybrid] = [Method::with_error(0.05), Method::Hybrid]
        .map(|method| read(&scene, &meters_in_the_room(), &base.clone().with(|o| o.method = method)));
    assert_eq!((bounded.direct, bounded.indirect), (hybrid.direct, hybrid.indirect));
    assert_eq!(refused(base.clone().with(|o| o.mesh.refine = Some(1))), "refine");
    assert_eq!(refused(base.clone().with(|o| o.mesh.lod_distance = Some(2.0))), "lod-distance");
    assert_eq!(
        refused(base.clone().with(|o| o.picture.time_limit = Some(std::time::Duration::from_secs(1)))),
        "time-limit"
    );

    let mut mesh = LightMesh::new(&scene, &options(Method::PAPER)).expect("mesh");
    let other = measure(&scene, &meters_in_the_room(), &base, &mut mesh, &()).expect_err("another method's mesh");
    assert!(matches!(other, Error::IncompatibleMesh { .. }));
    let tight = options(Method::Path).with(|o| o.limits.max_memory = 1000);
    let full = measure(&scene, &meters_in_the_room(), &tight, &mut mesh, &()).expect_err("too much");
    assert!(matches!(full, Error::OutOfMemory { needed_bytes: 1560, .. }), "{full}");
}

/// A progress bar begins at nothing, never goes back and ends at the whole; cancelling ends every method.
#[test]
fn measuring_reports_and_stops() {
    #[derive(Default)]
    struct Log {
        reports: Mutex<Vec<(u64, u64, u64)>>,
        stop: bool,
    }
    impl Progress for Log {
        fn report(&self, stage: Stage, done: u64, total: u64, rays: u64) {
            assert_eq!(stage, Stage::Measure);
            self.reports.lock().expect("log").push((done, total, rays));
        }
        fn cancelled(&self) -> bool {
            self.stop
        }
    }
    let scene = Scene::new(room()).expect("scene");
    let meters = meters_in_the_room();
    for method in METHODS {
        let options = with_bounces(method, 1).with(|o| o.picture.spp = 3);
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let log = Log::default();
        let measured = measure(&scene, &meters, &options, &mut mesh, &log).expect("measured");
        let reports = log.reports.into_inner().expect("log");
        let total = meters.len() as u64 * if method == Method::Path { 3 } else { 1 };
        assert_eq!((reports[0].0, reports[0].1), (0, total), "{method:?}");
        assert_eq!(reports.last().map(|r| (r.0, r.1)), Some((total, total)), "{method:?}");
        assert!(reports.windows(2).all(|w| w[0].0 <= w[1].0), "{method:?}");
        assert!(measured.stats.rays.total() > 0 && measured.stats.seconds.render > 0.0);
        let stopped = measure(&scene, &meters, &options, &mut mesh, &Log { stop: true, ..Log::default() });
        assert!(matches!(stopped, Err(Error::Cancelled)), "{method:?}");
    }
}

/// A box that is filled ahead leaves a picture in it nothing to fill, and the picture is that of a cold mesh; what is
/// filled around places is what meters there read, whichever way they face.
#[test]
fn what_is_filled_ahead_is_only_read() {
    let scene = Scene::new(room()).expect("scene");
    // Surfaces read points beyond them, too.
    let grown = Aabb { min: scene.bounds().min - 0.4, max: scene.bounds().max + 0.4 };
    let fills = |rays: lightmesh::RayCounts| rays.gather;
    for (method, bounces) in [(Method::MESH, 2), (Method::PAPER, 2), (Method::MESH, 0), (Method::Hybrid, 1)] {
        // What short rays meet is nothing that could be filled ahead.
        let options = with_bounces(method, bounces).with(|o| o.mesh.near_rays = 0);
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let filled = mesh.prefill_box(&scene, &options, &grown, &()).expect("filled");
        assert!(filled.direct.points_used >= 20 * 15 * 20 && (filled.indirect.points_used > 0) == (bounces > 0));
        let frame = lightmesh::render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
        assert_eq!((frame.stats.fill_shadow_rays, fills(frame.stats.rays)), (0, 0), "{method:?}");
        assert_eq!(frame.image, shoot(&scene, &room_camera(), &options).image, "{method:?}");
        let again = mesh.prefill_box(&scene, &options, &grown, &()).expect("filled");
        assert_eq!((again.rays.total(), again.direct), (0, frame.stats.direct), "{method:?}");

        let meters = meters_in_the_room();
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let places: Vec<Vec3> = meters.iter().map(|m| m.position).collect();
        let filled = mesh.prefill_meters(&scene, &options, &places, &()).expect("filled");
        let turned: Vec<Meter> = meters.iter().map(|m| Meter { normal: m.normal.zxy() - 0.3, ..*m }).collect();
        for meters in [meters, turned] {
            let measured = measure(&scene, &meters, &options, &mut mesh, &()).expect("measured");
            assert_eq!(measured.stats.indirect, filled.indirect, "{method:?}");
            assert_eq!(measured.direct, read(&scene, &meters, &options).direct, "{method:?}");
        }
    }
}

#[test]
fn filling_ahead_checks_memory_and_stops() {
    struct Stop;
    impl Progress for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH).with(|o| {
        o.limits.max_memory = 8 << 20;
        o.mesh.spacing = Spacing::Metres(0.05);
    });
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let full = mesh.prefill_box(&scene, &options, &scene.bounds(), &()).expect_err("too much");
    assert!(matches!(full, Error::OutOfMemory { .. }) && mesh.stats().points_used == 0, "{full}");
    let stopped = mesh.prefill_meters(&scene, &options, &[Vec3::ONE], &Stop).expect_err("stopped");
    assert!(matches!(stopped, Error::Cancelled));
    let standard = RenderOptions { method: Method::Standard, ..options };
    let refused = mesh.prefill_meters(&scene, &standard, &[Vec3::ONE], &()).expect_err("no mesh");
    assert!(matches!(refused, Error::InvalidOption { option: "method", .. }));
}

/// A render that is stopped while it fills the indirect mesh leaves a mesh that later ones can go on with.
#[test]
fn a_mesh_survives_a_fill_that_was_stopped() {
    use std::sync::atomic::{AtomicU32, Ordering};
    struct After(AtomicU32);
    impl Progress for After {
        fn cancelled(&self) -> bool {
            self.0.fetch_sub(1, Ordering::Relaxed) == 0
        }
    }
    let scene = Scene::new(room()).expect("scene");
    let options = with_bounces(Method::MESH, 2);
    let expected = shoot(&scene, &room_camera(), &options).image;
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let mut stopped = 0;
    for calls in 0..12 {
        let after = After(AtomicU32::new(calls));
        stopped += u32::from(lightmesh::render(&scene, &room_camera(), &options, &mut mesh, &after).is_err());
    }
    assert!(stopped > 2, "{stopped}");
    assert_eq!(lightmesh::render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame").image, expected);
}
