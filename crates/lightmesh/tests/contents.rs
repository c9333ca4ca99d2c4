//! Contents of a mesh: what they say, and that a mesh which takes them in renders bit for bit as one that evaluated all
//! by itself.

use std::f32::consts::PI;

use crate::common::*;
use glam::Vec3;
use lightmesh::{
    Camera, Cursor, DirectValues, Error, Frame, Image, Light, LightMesh, Material, MeshStats, Method, RayCounts,
    RenderOptions, Scene, SceneData, Snapshot, Spacing, render,
};

const METHODS: [Method; 4] = [Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED];

fn with_bounces(method: Method, bounces: u32) -> RenderOptions {
    options(method).with(|o| {
        o.transport.bounces = bounces;
        o.mesh.gather_rays = Some(64);
        o.mesh.spacing = Spacing::Metres(0.3);
        o.mesh.indirect_spacing = Spacing::Metres(0.6);
    })
}

fn other_camera() -> Camera {
    Camera::look_at(Vec3::new(-1.2, 1.5, 1.6), Vec3::new(0.3, 0.8, -0.6), 1.0)
}

/// The room with a lamp for each of 700 places under its ceiling.
fn room_with_many_lights() -> SceneData {
    let mut data = room();
    data.lights.clear();
    for i in 0..700_u16 {
        let (x, z) = (f32::from(i % 28), f32::from(i / 28));
        let color = Vec3::new(1.0, 0.5 + 0.5 * f32::from(i % 2), 0.2 + 0.4 * f32::from(i % 3)) * 0.1;
        data.lights
            .push(point_light(Vec3::new(-1.9 + 0.14 * x, 2.9 - 0.003 * f32::from(i % 50), -1.8 + 0.15 * z), color));
    }
    data
}

fn shot(scene: &Scene, camera: &Camera, options: &RenderOptions, mesh: &mut LightMesh) -> Frame {
    render(scene, camera, options, mesh, &()).expect("frame")
}

/// One camera fills a mesh; a fresh one takes its contents in and shows the other camera's picture: the same bits as by
/// a mesh of its own, and nothing is evaluated that came with the contents.
fn check_shared(scene: &Scene, options: &RenderOptions) -> (Image, Snapshot) {
    let mut first = LightMesh::new(scene, options).expect("mesh");
    shot(scene, &room_camera(), options, &mut first);
    let contents = first.snapshot_since(&Cursor::default());
    let what =
        || format!("{:?}, {} bounces, refined {:?}", options.method, options.transport.bounces, options.mesh.refine);

    let mut second = LightMesh::new(scene, options).expect("mesh");
    second.merge(&contents).expect("absorbed");
    assert_eq!(second.snapshot_since(&Cursor::default()), contents, "{}", what());
    // Cuts through a tree of lights are made anew, and points behind walls are probed anew.
    let counts = |stats: MeshStats| MeshStats { bytes: 0, ..stats };
    assert_eq!(counts(second.stats()), counts(first.stats()));
    assert_eq!(counts(second.indirect_stats()), counts(first.indirect_stats()));
    let shared = shot(scene, &other_camera(), options, &mut second);
    let local = shot(scene, &other_camera(), options, &mut first);
    let own = shoot(scene, &other_camera(), options);
    assert!(shared.image == own.image && local.image == own.image, "{}", what());
    let but_probes = |rays: RayCounts| RayCounts { secondary: 0, ..rays };
    assert_eq!(but_probes(shared.stats.rays), but_probes(local.stats.rays), "{}", what());
    // What the second camera asked for lies after what came in, as it does in the first mesh.
    assert_eq!(counts(shared.stats.direct), counts(local.stats.direct));
    assert_eq!(counts(shared.stats.indirect), counts(local.stats.indirect));
    (own.image, contents)
}

#[test]
fn absorbed_points_are_as_good_as_own_ones() {
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        for bounces in [0, 3] {
            let (_, contents) = check_shared(&scene, &with_bounces(method, bounces));
            assert!(!contents.direct.points.addresses.is_empty() && contents.indirect.is_some() == (bounces > 0));
        }
    }
}

/// Where there are no lights, points know of none.
#[test]
fn darkness_travels_too() {
    let scene = Scene::new(SceneData { lights: Vec::new(), ..room() }).expect("scene");
    for method in METHODS {
        let (image, _) = check_shared(&scene, &with_bounces(method, 1));
        assert!(image.pixels.iter().all(|&pixel| pixel == Vec3::ZERO));
    }
}

/// With a sun and lamps, points keep both for themselves.
#[test]
fn parts_of_the_light_travel_too() {
    let mut data = room();
    data.lights.push(Light::Directional { direction: Vec3::NEG_Y, illuminance_lux: Vec3::new(9.0, 8.0, 7.0) });
    let (_, contents) = check_shared(&Scene::new(data).expect("scene"), &with_bounces(Method::MESH, 2));
    let DirectValues::SixAxisParts(values) = &contents.direct.values else { panic!("{:?}", contents.direct.values) };
    assert_eq!(values.len(), contents.direct.points.addresses.len() * 108);
}

#[test]
fn clusters_of_lights_travel_too() {
    let scene = Scene::new(room_with_many_lights()).expect("scene");
    for method in METHODS {
        for bounces in [0, 2] {
            let (_, contents) = check_shared(&scene, &with_bounces(method, bounces));
            let by_light = matches!(method, Method::Hybrid | Method::Unbiased { .. });
            assert_eq!(matches!(contents.direct.values, DirectValues::Runs { .. }), by_light, "{method:?}");
        }
    }
}

#[test]
fn finer_levels_travel_too() {
    let scene = Scene::new(room()).expect("scene");
    for (method, refine) in [(Method::MESH, Some(2)), (Method::Hybrid, Some(1)), (Method::with_error(0.05), Some(1))] {
        let (_, contents) = check_shared(&scene, &with_bounces(method, 2).with(|o| o.mesh.refine = refine));
        let levels = contents.direct.points.lattices.len();
        assert_eq!(levels, 1 + refine.unwrap_or(0) as usize);
        let finest = |points: &lightmesh::PointSnapshot| points.addresses.iter().map(|a| a[0]).max();
        let indirect = contents.indirect.map(|indirect| finest(&indirect.points));
        assert!(finest(&contents.direct.points) > Some(0) || indirect.flatten() > Some(0), "{method:?}");
    }
}

/// A mesh tells what it learned since; pieces go together in any order, once or twice, whatever the mesh knew before.
#[test]
fn pieces_make_a_whole() {
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        let options = with_bounces(method, 1);
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        let mut pieces = Vec::new();
        let views = [room_camera(), other_camera(), Camera::look_at(Vec3::new(1.7, 2.5, -1.7), Vec3::ZERO, 1.2)];
        for camera in &views {
            let before = mesh.cursor();
            shot(&scene, camera, &options, &mut mesh);
            pieces.push(mesh.snapshot_since(&before));
        }
        assert_eq!(mesh.snapshot_since(&mesh.cursor()).point_count(), 0);
        let all = mesh.snapshot_since(&Cursor::default());
        assert_eq!(pieces.iter().map(Snapshot::point_count).sum::<u64>(), all.point_count());

        let mut other = LightMesh::new(&scene, &options).expect("mesh");
        shot(&scene, &views[1], &options, &mut other);
        for i in [2, 0, 1, 0, 2] {
            other.merge(&pieces[i]).expect("absorbed");
        }
        other.merge(&all).expect("absorbed");
        assert_eq!(other.stats().points_used, mesh.stats().points_used);
        let sorted = |contents: Snapshot| {
            let mut addresses = contents.direct.points.addresses;
            addresses.sort_unstable();
            addresses
        };
        assert_eq!(sorted(other.snapshot_since(&Cursor::default())), sorted(all));
        for camera in &views {
            let frame = shot(&scene, camera, &options, &mut other);
            assert_eq!(frame.image, shoot(&scene, camera, &options).image);
            assert_eq!(frame.stats.fill_shadow_rays, 0);
        }
    }
}

/// Shapes and units. A lamp over a floor: I cosθ/r² on each of the six planes, all of it arriving above the floor. In a
/// furnace: what arrives after N reflections is π (1 − a^(N+1)) / (1 − a).
#[test]
fn numbers_are_what_the_documentation_says() {
    let mut data = floor(Vec3::splat(0.5));
    let lamp = Vec3::new(0.3, 2.0, 0.2);
    data.lights.push(point_light(lamp, Vec3::new(100.0, 50.0, 25.0)));
    let scene = Scene::new(data).expect("scene");
    let options = options(Method::MESH).with(|o| o.mesh.spacing = Spacing::Metres(1.0));
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    shot(&scene, &Camera::look_at(Vec3::new(0.0, 5.0, 0.1), Vec3::ZERO, 1.0), &options, &mut mesh);
    let contents = mesh.snapshot_since(&Cursor::default()).direct;
    let DirectValues::SixAxis(values) = &contents.values else { panic!("{:?}", contents.values) };
    let positions = contents.points.positions();
    assert!(positions.len() > 50 && values.len() == positions.len() * 36);
    let planes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    for (p, values) in positions.iter().zip(values.chunks_exact(36)) {
        let d = lamp - Vec3::from_array(*p);
        for (n, pair) in planes.iter().zip(values.chunks_exact(6)) {
            let expected = Vec3::new(100.0, 50.0, 25.0) * n.dot(d.normalize()).max(0.0) / d.length_squared();
            let (arriving, unshadowed) = (Vec3::from_slice(&pair[..3]), Vec3::from_slice(&pair[3..]));
            assert!((unshadowed - expected).abs().max_element() <= 1e-4 * expected.max_element(), "{p:?} {n}");
            assert_eq!(arriving, if p[1] > 0.0 { unshadowed } else { Vec3::ZERO });
        }
    }

    let a = 0.5_f32;
    let glow = Material { emission: Vec3::ONE, ..Material::lambert(Vec3::splat(a)) };
    let mut data = SceneData { materials: vec![glow], ..SceneData::default() };
    place(&mut data, inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0)));
    place(&mut data, cuboid(Vec3::new(-0.5, 0.0, -0.6), Vec3::new(0.6, 1.0, 0.5), 0));
    let scene = Scene::new(data).expect("scene");
    let options = with_bounces(Method::MESH, 4);
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    shot(&scene, &room_camera(), &options, &mut mesh);
    let contents = mesh.snapshot_since(&Cursor::default()).indirect.expect("indirect");
    assert_eq!((contents.bounces, contents.faces), (4, 6));
    for n in 0..=4 {
        let values = contents.after(n);
        assert_eq!(values.len(), contents.points.addresses.len() * 18);
        let expected = PI * (1.0 - a.powi(n as i32 + 1)) / (1.0 - a);
        for (p, values) in contents.points.positions().iter().zip(values.chunks_exact(18)) {
            // Beyond a corner of the room, no ray may tell that it is outside.
            let is_outside = p[0].abs() > 2.0 || p[1] < 0.0 || p[1] > 3.0 || p[2].abs() > 2.0;
            assert!(is_outside || values.iter().all(|e| (e / expected - 1.0).abs() < 0.02), "{p:?} {n}: {values:?}");
        }
    }
    assert!(contents.after(5).is_empty() && contents.after(u32::MAX).is_empty());
    // The points in the box are among those that give none, all of them on the lattice.
    let inside = |p: &&[f32; 3]| p[0].abs() < 0.4 && p[1] > 0.1 && p[1] < 0.9 && p[2].abs() < 0.4;
    assert!(contents.points.invalid_positions().iter().any(|p| inside(&p)));
    assert!(!contents.points.positions().iter().any(|p| inside(&p)));
}

/// Whatever is wrong with contents, the message says where, and the mesh stays as it was.
#[test]
fn contents_that_do_not_fit_change_nothing() {
    let scene = Scene::new(room()).expect("scene");
    let many = Scene::new(room_with_many_lights()).expect("scene");
    let contents = |scene: &Scene, options: &RenderOptions| {
        let mut mesh = LightMesh::new(scene, options).expect("mesh");
        shot(scene, &room_camera(), options, &mut mesh);
        mesh.snapshot_since(&Cursor::default())
    };
    let check = |scene: &Scene, options: &RenderOptions, change: &dyn Fn(&mut Snapshot), words: &str| {
        let mut bad = contents(scene, options);
        change(&mut bad);
        let mut mesh = LightMesh::new(scene, options).expect("mesh");
        shot(
            scene,
            &other_camera(),
            &options.clone().with(|o| {
                o.picture.width = 8;
                o.picture.height = 6;
            }),
            &mut mesh,
        );
        let before = mesh.snapshot_since(&Cursor::default());
        let error = mesh.merge(&bad).expect_err(words);
        assert!(matches!(error, Error::InvalidContents { .. }), "{error}");
        assert!(error.to_string().contains(words), "{error}, not {words}");
        assert_eq!(mesh.snapshot_since(&Cursor::default()), before, "{words}");
    };
    let mesh = with_bounces(Method::MESH, 2);
    let by_mesh = |change: &dyn Fn(&mut Snapshot), words| check(&scene, &mesh, change, words);
    by_mesh(&|c| c.direct.points.lattices[0].spacing *= 2.0, "direct lattice, level 0: is");
    by_mesh(&|c| c.direct.points.lattices[0].origin[1] = f32::NAN, "direct lattice, level 0: is");
    by_mesh(&|c| c.direct.points.lattices.clear(), "direct lattices: there are 0");
    by_mesh(&|c| c.direct.points.addresses[5][2] = 4096, "direct addresses, point 5: (");
    by_mesh(&|c| c.direct.points.addresses[7] = [1, 0, 0, 0], "direct addresses, point 7: (0, 0, 0) of level 1");
    by_mesh(&|c| c.direct.points.invalid.push([0, -1, 0, 0]), "direct invalid points, point");
    by_mesh(&|c| c.direct.points.clearances.truncate(3), "direct clearances: has");
    by_mesh(&|c| c.direct.points.addresses.truncate(3), "direct clearances: has");
    let numbers = |c: &mut Snapshot, change: &dyn Fn(&mut Vec<f32>)| match &mut c.direct.values {
        DirectValues::SixAxis(numbers) => change(numbers),
        other => panic!("{other:?}"),
    };
    by_mesh(&|c| numbers(c, &|n| n[100] = f32::NAN), "direct values: number 100 is NaN");
    by_mesh(&|c| numbers(c, &|n| n.truncate(7)), "direct values: has");
    by_mesh(&|c| c.direct.values = DirectValues::Scalar(Vec::new()), "of another method; this mesh keeps six axes");
    by_mesh(&|c| c.indirect = None, "indirect: is missing");
    let indirect = |change: &dyn Fn(&mut lightmesh::IndirectSnapshot), words| {
        by_mesh(&|c| change(c.indirect.as_mut().expect("indirect")), words);
    };
    indirect(&|c| c.bounces = 1, "up to 1 bounces; this mesh was made for 2");
    indirect(&|c| c.faces = 1, "1 sides; this mesh keeps 6");
    indirect(&|c| c.values[3] = f32::INFINITY, "indirect values: number 3 is inf");
    indirect(&|c| c.values.extend([0.0; 18]), "indirect values: has");
    indirect(&|c| c.points.addresses[0][3] = 1000, "indirect addresses, point 0");
    indirect(&|c| c.hit_irradiance = f64::NAN, "the sum at gather hits is NaN");
    let direct = with_bounces(Method::MESH, 0);
    let indirect_of = |c: &mut Snapshot| c.indirect = contents(&scene, &mesh).indirect;
    check(&scene, &direct, &indirect_of, "indirect: is given");

    let hybrid = with_bounces(Method::Hybrid, 0);
    let by_light = |change: &dyn Fn(&mut u32, &mut Vec<u64>), words| {
        let change = |c: &mut Snapshot| match &mut c.direct.values {
            DirectValues::Lights { words, bits } => change(words, bits),
            other => panic!("{other:?}"),
        };
        check(&scene, &hybrid, &change, words);
    };
    by_light(&|words, _| *words = 2, "2 words of bits");
    by_light(&|_, bits| bits.truncate(3), "direct values: has");
    by_light(&|_, bits| (bits[4], bits[5]) = (1, 0), "point 2: its bits contradict each other");
    by_light(&|_, bits| bits[5] |= 1 << 63, "point 2: its bits contradict each other");

    let by_runs = |change: &dyn Fn(&mut Vec<u64>, &mut Vec<u32>), words| {
        let change = |c: &mut Snapshot| match &mut c.direct.values {
            DirectValues::Runs { ends, runs } => change(ends, runs),
            other => panic!("{other:?}"),
        };
        check(&many, &hybrid, &change, words);
    };
    by_runs(&|ends, _| ends[3] = u64::MAX, "ends: do not ascend");
    by_runs(&|ends, _| ends[3] = 0, "ends: do not ascend");
    by_runs(&|_, runs| runs.push(0), "ends: do not ascend");
    by_runs(&|_, runs| runs[0] = 4, "point 0: its runs");
    by_runs(&|_, runs| *runs.last_mut().expect("runs") = 701 << 2, "its runs");

    // Memory is checked before any of it is taken.
    let all = contents(&scene, &mesh);
    let tight = mesh.with(|o| o.limits.max_memory = 100_000);
    let mut small = LightMesh::new(&scene, &tight).expect("mesh");
    assert!(matches!(small.merge(&all), Err(Error::OutOfMemory { .. })) && small.stats().points_used == 0);
}
