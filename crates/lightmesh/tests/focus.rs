//! A mesh for cameras is fine about what they see: what is elsewhere changes nothing there, and costs next to nothing.

use crate::common::*;

use glam::{Quat, Vec3};
use lightmesh::geometry::Sphere;
use lightmesh::{
    Camera, Environment, Focus, Frame, Light, LightMesh, Material, Method, RenderOptions, Scene, SceneData, Spacing,
    render,
};

fn auto(method: Method) -> RenderOptions {
    options(method).with(|o| {
        (o.mesh.spacing, o.mesh.indirect_spacing) = (Spacing::Auto, Spacing::Auto);
        o.mesh.gather_rays = Some(32);
        o.transport.bounces = 2;
    })
}

/// A closed room with a camera in it.
fn closed_room(lamps: usize) -> SceneData {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.6))], ..SceneData::default() };
    place(&mut data, inside_out(cuboid(Vec3::new(-3.0, 0.0, -2.0), Vec3::new(3.0, 2.5, 2.0), 0)));
    place(&mut data, cuboid(Vec3::new(-3.1, -0.1, -2.1), Vec3::new(3.1, 2.6, 2.1), 0));
    place(&mut data, cuboid(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(-0.2, 0.9, -0.3), 0));
    for i in 0..lamps {
        let position = Vec3::new(-2.0 + 4.0 * i as f32 / lamps as f32, 2.2, 0.5);
        data.lights.push(point_light(position, Vec3::splat(60.0 / lamps as f32)));
    }
    data
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(2.5, 1.6, 1.7), Vec3::new(-1.0, 0.8, -1.0), 1.1)
}

fn shown(data: SceneData, method: Method) -> (Frame, Option<Focus>) {
    let scene = Scene::new(data).expect("scene");
    let options = auto(method);
    let mut mesh = LightMesh::for_cameras(&scene, &options, &[camera()]).expect("mesh");
    (render(&scene, &camera(), &options, &mut mesh, &()).expect("frame"), mesh.focus())
}

/// A ball that moves outside, a ground, a sky dome and other rooms: the picture is the same, bit for bit, by as many
/// points.
#[test]
fn what_is_outside_a_closed_room_changes_nothing_in_it() {
    let ball = |center: Vec3, radius: f32| {
        move |data: &mut SceneData| {
            data.spheres.push(Sphere { center, radius, material: 0 });
        }
    };
    let ground = |data: &mut SceneData| {
        let corner = |x: f32, z: f32| Vec3::new(500.0 * x, -0.2, 500.0 * z);
        place(data, quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)], 0));
    };
    let rooms = |data: &mut SceneData| {
        for x in [-7.0, 7.0, 14.0] {
            let by = Vec3::X * x;
            place(data, inside_out(cuboid(by + Vec3::new(-3.0, 0.0, -2.0), by + Vec3::new(3.0, 2.5, 2.0), 0)));
        }
    };
    type Outside<'a> = Box<dyn Fn(&mut SceneData) + 'a>;
    let outside: [Outside<'_>; 5] = [
        Box::new(ball(Vec3::new(6.0, 1.0, 0.0), 0.7)),
        Box::new(ball(Vec3::new(-250.0, 1.0, 3.0), 0.7)),
        Box::new(ball(Vec3::ZERO, 10_000.0)),
        Box::new(ground),
        Box::new(rooms),
    ];
    for (method, lamps) in [(Method::MESH, 3), (Method::Hybrid, 600)] {
        let (alone, focus) = shown(closed_room(lamps), method);
        let focus = focus.expect("focus");
        assert!((Vec3::from(focus.min) - Vec3::new(-3.0, 0.0, -2.0)).abs().max_element() < 1e-4, "{focus:?}");
        assert!((Vec3::from(focus.max) - Vec3::new(3.0, 2.5, 2.0)).abs().max_element() < 1e-4, "{focus:?}");
        for (i, add) in outside.iter().enumerate() {
            let mut data = closed_room(lamps);
            add(&mut data);
            let (frame, there) = shown(data, method);
            assert_eq!(there, Some(focus), "{i}");
            assert!(frame.image == alone.image, "{method} {i}");
            let points = |frame: &Frame| frame.stats.direct.points_used + frame.stats.indirect.points_used;
            assert!(points(&frame) * 10 <= points(&alone) * 12, "{method} {i}: {} {}", points(&frame), points(&alone));
        }
    }
}

/// Sun and sky of thousands of times the lamps' light outside a closed room: they are no noise in it, whatever rays are
/// shared out by, and no pixel is below 0. *Hybrid* knows the lights one by one (measured: 0.2%); `mesh` keeps suns
/// and sky for themselves (3e-8; 0.26 with all in one sum).
#[test]
fn daylight_outside_a_closed_room_is_no_noise_in_it() {
    for (method, most) in [(Method::MESH, 1e-4), (Method::Hybrid, 0.02)] {
        // As many points: the automatic spacing depends on the number of light samples.
        let shown = |data: SceneData| {
            let scene = Scene::new(data).expect("scene");
            let options = auto(method).with(|o| o.mesh.spacing = Spacing::Metres(0.08));
            let mut mesh = LightMesh::for_cameras(&scene, &options, &[camera()]).expect("mesh");
            render(&scene, &camera(), &options, &mut mesh, &()).expect("frame").image
        };
        let night = shown(closed_room(3));
        let mut data = closed_room(3);
        let sun = Vec3::new(0.5, -0.6, -0.7).normalize();
        data.lights.push(Light::Directional { direction: sun, illuminance_lux: Vec3::splat(60_000.0) });
        let radiance = Vec3::new(0.35, 0.5, 0.8) * 6000.0;
        data.environment = Some(Environment { map: None, radiance, world_from_map: Quat::IDENTITY });
        let day = shown(data);
        let mean = night.pixels.iter().sum::<Vec3>() / night.pixels.len() as f32;
        let squares: f32 = day.pixels.iter().zip(&night.pixels).map(|(d, n)| ((d - n) / mean).length_squared()).sum();
        let error = (squares / (3 * day.pixels.len()) as f32).sqrt();
        assert!(error < most, "{method}: {error}");
        assert!(day.pixels.iter().all(|p| p.min_element() >= 0.0), "{method}");
    }
}

/// Sunlight through a hole in a roof is as sharp by `mesh` as by a shadow ray to each light, beside a lamp or alone: no pixel
/// differs by 2% of the mean, where a mesh of 0.4 m would spread the edge over a cell.
#[test]
fn the_edge_of_sunlight_is_sharp() {
    for lamps in [0, 1] {
        let mut data = floor(Vec3::splat(0.5));
        place(&mut data, cuboid(Vec3::new(-4.0, 2.0, -4.0), Vec3::new(-0.3, 2.1, 4.0), 0));
        place(&mut data, cuboid(Vec3::new(0.4, 2.0, -4.0), Vec3::new(4.0, 2.1, 4.0), 0));
        let direction = Vec3::new(0.2, -1.0, 0.1).normalize();
        data.lights = vec![Light::Directional { direction, illuminance_lux: Vec3::splat(1000.0) }];
        data.lights.extend((0..lamps).map(|_| point_light(Vec3::new(0.0, 1.9, 0.0), Vec3::splat(20.0))));
        let scene = Scene::new(data).expect("scene");
        let camera = Camera::look_at(Vec3::new(0.0, 1.5, 2.0), Vec3::new(0.2, 0.0, 0.0), 0.9);
        let shown = |method| {
            let spacing = Spacing::Metres(0.4);
            let options = options(method).with(|o| (o.transport.bounces, o.mesh.spacing) = (0, spacing));
            shoot(&scene, &camera, &options).image.pixels
        };
        let (mesh, exact) = (shown(Method::MESH), shown(Method::Standard));
        let mean = exact.iter().sum::<Vec3>().x / exact.len() as f32;
        let lit = exact.iter().filter(|p| p.x > 2.0 * mean).count();
        assert!(lit > 50 && lit < exact.len() / 2, "{lit}");
        let most = mesh.iter().zip(&exact).map(|(m, e)| (m.x - e.x).abs() / mean).fold(0.0, f32::max);
        assert!(most < 0.02, "{lamps}: {most}");
    }
}

/// Through a door, the ground outside is read from coarser levels: a kilometre of it takes a bounded number of points, and
/// the light in the room stays.
#[test]
fn what_is_far_away_is_coarse() {
    let open = |size: f32| {
        let mut data = floor(Vec3::splat(0.5));
        data.meshes.clear();
        data.instances.clear();
        for (min, max) in [
            ([-3.0, 0.0, -2.0], [3.0, 2.5, -1.9]),
            ([-3.0, 0.0, 1.9], [3.0, 2.5, 2.0]),
            ([-3.0, 0.0, -2.0], [-2.9, 2.5, 2.0]),
            ([-3.0, 2.4, -2.0], [3.0, 2.5, 2.0]),
        ] {
            place(&mut data, cuboid(min.into(), max.into(), 0));
        }
        let corner = |x: f32, z: f32| Vec3::new(size * x, 0.0, size * z);
        place(&mut data, quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)], 0));
        data.lights = vec![point_light(Vec3::new(-1.0, 2.0, 0.3), Vec3::splat(80.0))];
        data
    };
    let camera = Camera::look_at(Vec3::new(-2.6, 1.6, -1.5), Vec3::new(2.0, 0.6, 1.0), 1.2);
    let shown = |size: f32| {
        let scene = Scene::new(open(size)).expect("scene");
        let options = auto(Method::MESH);
        let mut mesh = LightMesh::for_cameras(&scene, &options, std::slice::from_ref(&camera)).expect("mesh");
        render(&scene, &camera, &options, &mut mesh, &()).expect("frame")
    };
    let (near, far) = (shown(12.0), shown(2000.0));
    let points = |frame: &Frame| frame.stats.direct.points_used + frame.stats.indirect.points_used;
    assert!(points(&far) < 3 * points(&near), "{} {}", points(&near), points(&far));
    let mean = |frame: &Frame| {
        let pixels: Vec<f32> = frame.image.pixels.iter().map(|p| p.element_sum()).collect();
        pixels.iter().sum::<f32>() / pixels.len() as f32
    };
    assert!((mean(&near) / mean(&far) - 1.0).abs() < 0.05, "{} {}", mean(&near), mean(&far));
}

/// Whoever comes first: pictures of a mesh for several cameras do not depend on it, and a mesh with its focus is the
/// same mesh.
#[test]
fn a_mesh_for_cameras_is_one_mesh() {
    let scene = Scene::new(closed_room(3)).expect("scene");
    let options = auto(Method::MESH);
    let other = Camera::look_at(Vec3::new(-2.5, 1.2, 1.0), Vec3::new(2.0, 1.0, -1.0), 0.9);
    let mut first = LightMesh::for_cameras(&scene, &options, &[camera(), other.clone()]).expect("mesh");
    let mut second = LightMesh::with_focus(&scene, &options, first.focus()).expect("mesh");
    let picture =
        |camera: &Camera, mesh: &mut LightMesh| render(&scene, camera, &options, mesh, &()).expect("frame").image;
    let (a, b) = (picture(&camera(), &mut first), picture(&other, &mut first));
    assert!(picture(&other, &mut second) == b && picture(&camera(), &mut second) == a);

    // Its points go to a mesh of the same focus alone.
    let all = first.snapshot_since(&Default::default());
    assert_eq!(all.focus(), first.focus());
    let mut merged = LightMesh::with_focus(&scene, &options, all.focus()).expect("mesh");
    merged.merge(&all).expect("same focus");
    assert!(picture(&camera(), &mut merged) == a);
    let error = LightMesh::new(&scene, &options).expect("mesh").merge(&all).expect_err("no focus");
    assert!(error.to_string().contains("focus"), "{error}");
    let nowhere = Focus { min: [1.0; 3], max: [f32::NAN; 3], scale: 1.0 };
    let error = LightMesh::with_focus(&scene, &options, Some(nowhere)).expect_err("no box");
    assert!(error.to_string().contains("focus"), "{error}");
}
