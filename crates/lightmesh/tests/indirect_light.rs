//! Indirect light: closed forms, an independent radiosity solution, energy, and frames that share a mesh.

use crate::common::*;
use glam::Vec3;
use lightmesh::metrics::difference;
use lightmesh::{
    Camera, Frame, Light, LightMesh, Material, Meter, Method, RenderOptions, Scene, SceneData, Spacing, measure, render,
};

fn gi(method: Method, bounces: u32) -> RenderOptions {
    options(method).with(|o| {
        o.transport.bounces = bounces;
        o.mesh.spacing = Spacing::Metres(0.2);
        o.mesh.indirect_spacing = Spacing::Metres(0.4);
    })
}

/// A closed box of 4 × 3 × 4 m in which everything has albedo `a` and emits 1 cd/m², with a box that stands on its
/// floor against a wall and a sheet of 1 cm in the middle.
fn furnace(a: f32) -> SceneData {
    let glow = Material { emission: Vec3::ONE, ..Material::lambert(Vec3::splat(a)) };
    let mut data = SceneData { materials: vec![glow], ..SceneData::default() };
    place(&mut data, inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0)));
    place(&mut data, cuboid(Vec3::new(-1.9, 0.0, -1.7), Vec3::new(-0.9, 0.8, -0.7), 0));
    place(&mut data, cuboid(Vec3::new(0.5, 0.2, -0.6), Vec3::new(0.51, 1.6, 0.9), 0));
    data
}

/// e / (1 − a) everywhere (less a^(N+1) of it after N bounces): room corners, the foot of the box, both sides of the
/// sheet. No dark lines, no light lines: no pixel is 2% off.
#[test]
fn a_furnace_is_one_over_one_minus_albedo() {
    for (a, bounces) in [(0.2_f32, 4), (0.5, 9), (0.8, 30)] {
        let scene = Scene::new(furnace(a)).expect("scene");
        let expected = (1.0 - a.powi(bounces + 1)) / (1.0 - a);
        let image = shoot(&scene, &room_camera(), &gi(Method::MESH, bounces as u32)).image;
        for (i, pixel) in image.pixels.iter().enumerate() {
            let off = (*pixel / expected - Vec3::ONE).abs().max_element();
            assert!(off < 0.02, "albedo {a}, pixel {} {}: {pixel}, {expected}", i % 64, i / 64);
        }
        // Paths: the mean of 64 × 48 pixels of 64 samples.
        let path = shoot(&scene, &room_camera(), &gi(Method::Path, bounces as u32).with(|o| o.picture.spp = 64));
        let mean = path.image.pixels.iter().sum::<Vec3>() / path.image.pixels.len() as f32;
        assert!((mean / expected - Vec3::ONE).abs().max_element() < 0.01, "albedo {a}: {mean} {expected}");
    }
}

/// A mirror on a wall of the furnace shows e / (1 − a) as the walls do, and gather rays that meet it go on to a wall.
#[test]
fn a_furnace_with_a_mirror_is_the_same() {
    let mut data = furnace(0.5);
    data.materials.push(Material { base_color: Vec3::ONE, metallic: 1.0, roughness: 0.0, ..Material::default() });
    let c = |x: f32, y: f32| Vec3::new(x, y, -1.99);
    place(&mut data, quad([c(-0.8, 0.3), c(1.9, 0.3), c(1.9, 2.8), c(-0.8, 2.8)], 1));
    let scene = Scene::new(data).expect("scene");
    let image = shoot(&scene, &room_camera(), &gi(Method::MESH, 12)).image;
    for pixel in &image.pixels {
        assert!((*pixel / 2.0 - Vec3::ONE).abs().max_element() < 0.02, "{pixel}");
    }
}

/// At the foot of a black screen, within 15 cm of it, the mesh, whose points are 40 cm apart, gives the floor too much
/// indirect light; short rays find the shade. Against paths, the mean over meters in front of the middle of the screen.
#[test]
fn short_rays_find_the_shade_of_a_screen() {
    let mut data = room();
    data.materials.push(Material::lambert(Vec3::ZERO));
    let black = data.materials.len() - 1;
    place(&mut data, cuboid(Vec3::new(0.93, 0.0, 0.4), Vec3::new(0.95, 0.9, 1.6), black));
    let scene = Scene::new(data).expect("scene");
    let meter = |i: i32| Vec3::new(0.78 + 0.02 * (i % 8) as f32, 0.0, 0.82 + 0.05 * (i / 8) as f32);
    let meters: Vec<Meter> = (0..64).map(|i| Meter { position: meter(i), normal: Vec3::Y }).collect();
    let read = |options: &RenderOptions| {
        let mut mesh = LightMesh::new(&scene, options).expect("mesh");
        let measured = measure(&scene, &meters, options, &mut mesh, &()).expect("measured");
        measured.indirect.iter().sum::<Vec3>().element_sum() / 192.0
    };
    let truth = read(&gi(Method::Path, 3).with(|o| o.picture.spp = 1024));
    let off = |near_rays| read(&gi(Method::Hybrid, 3).with(|o| o.mesh.near_rays = near_rays)) / truth - 1.0;
    let (without, with) = (off(0), off(64));
    assert!(without > 0.2 && with.abs() < 0.4 * without, "{without} {with}");
}

/// A convex box of 2 × 2 × 2 m with a lamp in it, solved as radiosity: patches, form factors and Jacobi's iteration.
mod radiosity {
    use std::f64::consts::PI;

    use glam::DVec3;

    pub(super) const SIDE: usize = 8;
    const SUB: usize = 4;

    /// The walls: a corner, two edges, the inward normal.
    pub(super) fn walls() -> [[DVec3; 4]; 6] {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        [
            [DVec3::ZERO, y * 2.0, z * 2.0, x],
            [x * 2.0, y * 2.0, z * 2.0, -x],
            [DVec3::ZERO, x * 2.0, z * 2.0, y],
            [y * 2.0, x * 2.0, z * 2.0, -y],
            [DVec3::ZERO, x * 2.0, y * 2.0, z],
            [z * 2.0, x * 2.0, y * 2.0, -z],
        ]
    }

    /// Centre of cell (i, j) of n × n on a wall.
    pub(super) fn centre(wall: usize, n: usize, i: usize, j: usize) -> DVec3 {
        let [corner, u, v, _] = walls()[wall];
        corner + u * ((i as f64 + 0.5) / n as f64) + v * ((j as f64 + 0.5) / n as f64)
    }

    /// Radiance of every patch, wall by wall, of `albedos` and a lamp of `intensity` at `lamp`: B = ρ (E + F B), L = B
    /// / π. Form factors by SUB² points on the sending patch, rows scaled to the sum 1 that they have in a closed room.
    pub(super) fn solve(albedos: &[DVec3; 6], lamp: DVec3, intensity: DVec3) -> Vec<DVec3> {
        let patches: Vec<(usize, usize, usize)> =
            (0..6).flat_map(|w| (0..SIDE * SIDE).map(move |k| (w, k % SIDE, k / SIDE))).collect();
        let area = 4.0 / (SIDE * SUB).pow(2) as f64;
        let factor = |p: DVec3, n: DVec3, (w, i, j): (usize, usize, usize)| -> f64 {
            let m = walls()[w][3];
            (0..SUB * SUB)
                .map(|k| {
                    let d = centre(w, SIDE * SUB, i * SUB + k % SUB, j * SUB + k / SUB) - p;
                    let r2 = d.length_squared();
                    n.dot(d).max(0.0) * (-m.dot(d)).max(0.0) / (PI * r2 * r2) * area
                })
                .sum()
        };
        let rows: Vec<Vec<f64>> = patches
            .iter()
            .map(|&(w, i, j)| {
                let (p, n) = (centre(w, SIDE, i, j), walls()[w][3]);
                let row: Vec<f64> = patches.iter().map(|&q| if q.0 == w { 0.0 } else { factor(p, n, q) }).collect();
                let sum: f64 = row.iter().sum();
                row.iter().map(|f| f / sum).collect()
            })
            .collect();
        let direct: Vec<DVec3> = patches
            .iter()
            .map(|&(w, i, j)| {
                let n = walls()[w][3];
                let at = |k: usize| lamp - centre(w, SIDE * SUB, i * SUB + k % SUB, j * SUB + k / SUB);
                let sum: f64 = (0..SUB * SUB).map(|k| n.dot(at(k)) / at(k).length().powi(3)).sum();
                intensity * (sum / (SUB * SUB) as f64)
            })
            .collect();
        let mut b = vec![DVec3::ZERO; patches.len()];
        for _ in 0..100 {
            b = rows
                .iter()
                .zip(&direct)
                .zip(&patches)
                .map(|((row, e), &(w, ..))| albedos[w] * (*e + row.iter().zip(&b).map(|(f, b)| *b * *f).sum::<DVec3>()))
                .collect();
        }
        b.iter().map(|b| *b / PI).collect()
    }
}

/// Mesh and path tracer against radiosity, mean of a wall by wall: a red, a green and four white ones. A mesh reads points
/// off the wall, in the brighter middle of the room: the error that their shifted faces leave falls with the spacing.
#[test]
fn a_coloured_box_agrees_with_radiosity() {
    let albedos = [
        Vec3::new(0.7, 0.1, 0.1),
        Vec3::new(0.1, 0.6, 0.1),
        Vec3::splat(0.7),
        Vec3::splat(0.8),
        Vec3::splat(0.6),
        Vec3::splat(0.75),
    ];
    let (lamp, intensity) = (Vec3::new(1.1, 1.3, 0.8), Vec3::new(10.0, 8.0, 6.0));
    let truth = radiosity::solve(&albedos.map(|a| a.as_dvec3()), lamp.as_dvec3(), intensity.as_dvec3());

    let mut data = SceneData { materials: albedos.map(Material::lambert).to_vec(), ..SceneData::default() };
    data.lights.push(point_light(lamp, intensity));
    for (wall, [corner, u, v, n]) in radiosity::walls().into_iter().enumerate() {
        let (u, v) = if u.cross(v).dot(n) > 0.0 { (u, v) } else { (v, u) };
        let corners = [corner, corner + u, corner + u + v, corner + v].map(|p| p.as_vec3());
        place(&mut data, quad(corners, wall));
    }
    let scene = Scene::new(data).expect("scene");
    let middle = Vec3::ONE;
    let rungs = [(Method::MESH, 0.2, 1, 0.015), (Method::MESH, 0.1, 1, 0.008), (Method::Path, 0.2, 4096, 0.015)];
    for (method, h, spp, tolerance) in rungs {
        // One small picture at the middle of each patch, the mesh shared.
        let options = gi(method, 30).with(|o| {
            o.picture.width = 1;
            o.picture.height = 1;
            o.picture.spp = spp;
        });
        let options = options.with(|o| {
            o.mesh.spacing = Spacing::Metres(0.1);
            o.mesh.indirect_spacing = Spacing::Metres(h);
        });
        let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
        for wall in 0..6 {
            let (mut sum, mut expected) = (Vec3::ZERO, Vec3::ZERO);
            for k in 0..radiosity::SIDE * radiosity::SIDE {
                let (i, j) = (k % radiosity::SIDE, k / radiosity::SIDE);
                let target = radiosity::centre(wall, radiosity::SIDE, i, j).as_vec3();
                let camera = Camera::look_at(middle, target, 0.001);
                let frame = render(&scene, &camera, &options, &mut mesh, &()).expect("frame");
                sum += frame.image.pixels[0];
                expected += truth[wall * radiosity::SIDE * radiosity::SIDE + k].as_vec3();
            }
            let off = (sum / expected - Vec3::ONE).abs().max_element();
            assert!(off < tolerance, "{method:?}, wall {wall}: {sum} {expected}");
        }
    }
}

/// Every bounce adds light, and less than the one before.
#[test]
fn energy_never_grows_with_bounces() {
    let scene = Scene::new(room()).expect("scene");
    let mean = |bounces| {
        let image = shoot(&scene, &room_camera(), &gi(Method::MESH, bounces)).image;
        image.pixels.iter().map(|p| p.as_dvec3()).sum::<glam::DVec3>() / image.pixels.len() as f64
    };
    let means: Vec<_> = (0..7).map(mean).collect();
    let added: Vec<_> = means.windows(2).map(|m| m[1] - m[0]).collect();
    for pair in added.windows(2) {
        assert!(pair[0].min_element() > 0.0 && pair[1].min_element() > 0.0, "{added:?}");
        assert!((pair[1] / pair[0]).max_element() < 1.0, "{added:?}");
    }
}

/// What is said to be left out is what more bounces bring, within a quarter of it: it is known for the mesh points, not
/// for the picture.
#[test]
fn the_light_that_is_left_out_is_estimated() {
    let scene = Scene::new(room()).expect("scene");
    let few = shoot(&scene, &room_camera(), &gi(Method::MESH, 2));
    let many = shoot(&scene, &room_camera(), &gi(Method::MESH, 40));
    let sum = |frame: &Frame| frame.image.pixels.iter().sum::<Vec3>().element_sum();
    let truth = 1.0 - sum(&few) / sum(&many);
    let said = few.stats.truncated_light.expect("an estimate") as f32;
    assert!((said / truth - 1.0).abs() < 0.25, "{said} {truth}");
    assert!(many.stats.truncated_light.expect("an estimate") < 1e-3);
}

fn both_points(frame: &Frame) -> u64 {
    frame.stats.direct.points_used + frame.stats.indirect.points_used
}

/// A second frame from another camera fills what is new, at most 40% of what the first one filled, shows what a mesh of
/// its own would, and a third from the first camera fills nothing.
#[test]
fn a_second_frame_fills_only_what_is_new() {
    let scene = Scene::new(room()).expect("scene");
    second_frame(&scene, 0);
    second_frame(&scene, 3);
}

fn second_frame(scene: &Scene, bounces: u32) {
    let options = gi(Method::MESH, bounces).with(|o| {
        o.picture.width = 160;
        o.picture.height = 120;
        o.mesh.near_rays = 0;
    });
    let mut mesh = LightMesh::new(scene, &options).expect("mesh");
    let mut shot = |camera| render(scene, &camera, &options, &mut mesh, &()).expect("frame");
    let other = Camera::look_at(Vec3::new(-1.2, 1.5, 1.6), Vec3::new(0.3, 0.8, -0.6), 1.0);

    let first = shot(room_camera());
    let second = shot(other.clone());
    let new = both_points(&second) - both_points(&first);
    // With bounces the first frame's gather rays have been everywhere in this room.
    assert!((new > 0 || bounces > 0) && new * 10 <= both_points(&first) * 4, "{new} new of {}", both_points(&first));
    let fill = |frame: &Frame| frame.stats.rays.gather + frame.stats.rays.shadow;
    assert!(fill(&second) * 10 <= fill(&first) * 4, "{} rays after {}", fill(&second), fill(&first));
    assert_eq!(second.image, shoot(scene, &other, &options).image);

    let third = shot(room_camera());
    assert_eq!(third.image, first.image);
    assert_eq!(fill(&third), 0);
}

/// The same picture on one thread and on three, for every method that gathers.
#[test]
fn threads_do_not_change_a_picture() {
    let scene = Scene::new(room()).expect("scene");
    for method in [Method::MESH, Method::PAPER, Method::Path] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
            pool.install(|| shoot(&scene, &room_camera(), &gi(method, 3).with(|o| o.picture.spp = 2)).image)
        };
        assert_eq!(on(1), on(3), "{method:?}");
    }
}

/// Two rooms with open fronts side by side, a wall of 5 cm between them, two lamps in the left one. The right one stays
/// black: below a thousandth of the picture's mean, whatever the spacing does to the wall; the left one is what paths
/// find.
#[test]
fn a_thin_wall_does_not_leak() {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.7))], ..SceneData::default() };
    let mut panel = |min: [f32; 3], max: [f32; 3]| place(&mut data, cuboid(min.into(), max.into(), 0));
    panel([-4.05, -0.05, -3.05], [4.05, 0.0, 0.0]);
    panel([-4.05, 3.0, -3.05], [4.05, 3.05, 0.0]);
    panel([-4.05, 0.0, -3.05], [4.05, 3.0, -3.0]);
    for x in [-4.05, -0.025, 4.0] {
        panel([x, 0.0, -3.0], [x + 0.05, 3.0, 0.0]);
    }
    data.lights.push(point_light(Vec3::new(-1.0, 2.0, -1.5), Vec3::splat(50.0)));
    data.lights.push(point_light(Vec3::new(-3.0, 1.0, -2.0), Vec3::new(50.0, 20.0, 10.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.5, 5.0), Vec3::new(0.0, 1.5, -2.0), 1.0);
    for h in [0.25, 0.2, 0.13] {
        let mesh = gi(Method::MESH, 4);
        let mesh = mesh.with(|o| {
            o.picture.width = 160;
            o.picture.height = 90;
            o.mesh.spacing = Spacing::Metres(h);
            o.mesh.indirect_spacing = Spacing::Metres(2.0 * h);
        });
        let image = shoot(&scene, &camera, &mesh).image;
        let mean = |pixels: &mut dyn Iterator<Item = Vec3>| {
            let (sum, n) = pixels.fold((0.0, 0.0), |(s, n), p| (s + f64::from(p.element_sum()), n + 1.0));
            sum / n
        };
        let all = mean(&mut image.pixels.iter().copied());
        let right = mean(&mut (0..90 * 160).filter(|i| i % 160 > 84).map(|i| image.pixels[i]));
        assert!(right < 1e-3 * all, "{h} m: {right} of {all}");

        let path = shoot(
            &scene,
            &camera,
            &mesh.with(|o| {
                o.method = Method::Path;
                o.picture.spp = 64;
            }),
        );
        let off = difference(&image.pixels, &path.image.pixels);
        assert!(off.bias.abs() < 0.05 && off.relrmse < 0.25, "{h} m: {off:?}");
    }
}

/// A lamp 4 cm below a ceiling: two meshes whose gather rays differ are alike. With even rays alone they differ by 20%
/// and more.
#[test]
fn a_lamp_close_to_a_ceiling_makes_no_fireflies() {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.6))], ..SceneData::default() };
    place(&mut data, inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0)));
    data.lights.push(point_light(Vec3::new(0.5, 2.96, -0.3), Vec3::splat(20.0)));
    let scene = Scene::new(data).expect("scene");
    let picture = |seed| shoot(&scene, &room_camera(), &gi(Method::MESH, 1).with(|o| o.seed = seed)).image.pixels;
    let d = difference(&picture(1), &picture(2));
    assert!(d.relrmse < 0.04, "{d:?}");
}

/// The sun through a hole of 0.8 × 0.8 m in a ceiling lights all of a room by a patch on its floor: two meshes whose gather
/// rays differ are alike (0.07). With even rays alone they differ by 0.31.
#[test]
fn a_patch_of_sunlight_makes_no_fireflies() {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.7))], ..SceneData::default() };
    for (min, max) in [
        ([-2.2, -0.2, -2.2], [2.2, 0.0, 2.2]),
        ([-2.2, 0.0, -2.2], [-2.0, 3.0, 2.2]),
        ([2.0, 0.0, -2.2], [2.2, 3.0, 2.2]),
        ([-2.0, 0.0, -2.2], [2.0, 3.0, -2.0]),
        ([-2.0, 0.0, 2.0], [2.0, 3.0, 2.2]),
        ([-2.2, 3.0, -2.2], [0.2, 3.2, 2.2]),
        ([1.0, 3.0, -2.2], [2.2, 3.2, 2.2]),
        ([0.2, 3.0, -2.2], [1.0, 3.2, -0.4]),
        ([0.2, 3.0, 0.4], [1.0, 3.2, 2.2]),
    ] {
        place(&mut data, cuboid(min.into(), max.into(), 0));
    }
    let direction = Vec3::new(-0.2, -1.0, 0.1).normalize();
    data.lights = vec![Light::Directional { direction, illuminance_lux: Vec3::splat(60_000.0) }];
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(-1.5, 1.5, 1.6), Vec3::new(0.5, 1.6, -1.0), 1.0);
    let shown = |seed| shoot(&scene, &camera, &gi(Method::MESH, 2).with(|o| o.seed = seed)).image;
    // The noise of the walls, not of the patch's edge.
    let (a, b) = (shown(1), shown(2));
    let mean = a.pixels.iter().sum::<Vec3>() / a.pixels.len() as f32;
    let dim = a.pixels.iter().zip(&b.pixels).filter(|(p, _)| p.max_element() < 2.0 * mean.max_element());
    let (mut sum, mut square, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for (p, q) in dim {
        (sum, square, count) = (sum + p, square + (p - q) * (p - q), count + 1.0);
    }
    let noise = ((square.element_sum() / 3.0 / count).sqrt()) / (sum.element_sum() / 3.0 / count);
    assert!(noise < 0.1, "{noise}");
}

/// A room whose faces are turned inside out, so that the mesh takes its inside for a solid: as bright as by paths, and
/// not many times as many rays.
#[test]
fn a_room_inside_out_does_not_run_away() {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.6))], ..SceneData::default() };
    place(&mut data, cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0));
    data.lights.push(point_light(Vec3::new(0.5, 2.0, -0.3), Vec3::splat(20.0)));
    let scene = Scene::new(data).expect("scene");
    let mesh = shoot(&scene, &room_camera(), &gi(Method::MESH, 3).with(|o| o.picture.spp = 4));
    let path = shoot(&scene, &room_camera(), &gi(Method::Path, 3).with(|o| o.picture.spp = 16));
    let mean = |pixels: &[Vec3]| pixels.iter().map(|p| p.x).sum::<f32>() / pixels.len() as f32;
    let (a, b) = (mean(&mesh.image.pixels), mean(&path.image.pixels));
    assert!((a / b - 1.0).abs() < 0.03, "{a} {b}");
    let rays = mesh.stats.rays;
    assert!(rays.total() < 40 * 4 * 64 * 48 && mesh.stats.gather_fallbacks > 64 * 48, "{rays:?}");
}
