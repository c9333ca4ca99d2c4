//! Layers beside the light: what they hold, and that asking for them changes nothing else.

use crate::common::*;
use glam::{Vec2, Vec3};
use lightmesh::geometry::Sphere;
use lightmesh::{
    Aov, Aovs, Camera, Error, Frame, LightMesh, Material, Method, Projection, RenderOptions, Scene, render,
};

const METHODS: [Method; 4] = [Method::Standard, Method::MESH, Method::PAPER, Method::Path];

/// All layers that a method has.
fn all(method: Method) -> Aovs {
    Aov::ALL.into_iter().filter(|aov| aov.is_known_to(method)).collect()
}

fn values(frame: &Frame, aov: Aov) -> &[f32] {
    &frame.layers.iter().find(|layer| layer.aov == aov).expect("a layer").values
}

fn colors(frame: &Frame, aov: Aov) -> Vec<Vec3> {
    values(frame, aov).chunks_exact(3).map(Vec3::from_slice).collect()
}

/// A room with a lamp of its own in view, so that its outline is sampled anew, and a mirror.
fn room_with_lamp_and_mirror() -> Scene {
    let mut data = room();
    data.materials.push(Material { emission: Vec3::new(900.0, 700.0, 500.0), ..Material::lambert(Vec3::ZERO) });
    data.materials.push(Material { metallic: 1.0, roughness: 0.0, ..Material::default() });
    let c = |x: f32, z: f32| Vec3::new(x, 2.2, z);
    place(&mut data, quad([c(-0.4, -1.6), c(0.4, -1.6), c(0.4, -0.9), c(-0.4, -0.9)], 2));
    data.spheres.push(Sphere { center: Vec3::new(1.1, 0.5, -0.8), radius: 0.4, material: 3 });
    Scene::new(data).expect("scene")
}

#[test]
fn asking_for_layers_changes_no_bit_of_the_picture() {
    let scene = room_with_lamp_and_mirror();
    for method in METHODS {
        let plain = options(method).with(|o| {
            o.picture.spp = 4;
            o.transport.bounces = 2;
            o.picture.width = 48;
            o.picture.height = 36;
            o.mesh.gather_rays = Some(16);
        });
        let layered = plain.clone().with(|o| o.picture.aovs = all(method));
        let (a, b) = (shoot(&scene, &room_camera(), &plain), shoot(&scene, &room_camera(), &layered));
        assert_eq!(a.image, b.image, "{method:?}");
        assert!(a.layers.is_empty() && b.layers.iter().map(|layer| layer.aov).eq(all(method).iter()));
        for layer in &b.layers {
            let channels = layer.aov.channels().len();
            assert_eq!(layer.values.len(), 48 * 36 * channels, "{method:?} {:?}", layer.aov);
            assert!(layer.values.iter().all(|value| value.is_finite()), "{method:?} {:?}", layer.aov);
        }
    }
}

#[test]
fn layers_do_not_depend_on_the_number_of_threads() {
    let scene = room_with_lamp_and_mirror();
    for method in METHODS {
        let options = options(method).with(|o| {
            o.picture.spp = 2;
            o.transport.bounces = 1;
            o.mesh.gather_rays = Some(16);
            o.picture.aovs = all(method);
        });
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
            pool.install(|| shoot(&scene, &room_camera(), &options).layers)
        };
        assert!(with_threads(1) == with_threads(3), "{method:?}");
    }
}

/// Both are sums of what the picture sums: rounding is 2⁻²⁴ of the pixel for each of some hundred terms.
#[test]
fn direct_and_indirect_light_are_the_picture() {
    let scene = room_with_lamp_and_mirror();
    for method in METHODS {
        let options = options(method).with(|o| {
            o.picture.spp = 4;
            o.transport.bounces = 2;
            o.mesh.gather_rays = Some(16);
            o.picture.aovs = all(method);
        });
        let frame = shoot(&scene, &room_camera(), &options);
        let (direct, indirect) = (colors(&frame, Aov::Direct), colors(&frame, Aov::Indirect));
        for ((&d, &i), &p) in direct.iter().zip(&indirect).zip(&frame.image.pixels) {
            assert!((d + i - p).abs().max_element() <= 1e-5 * p.max_element(), "{method:?}: {d} + {i}, not {p}");
        }
        let sum = |values: &[Vec3]| values.iter().map(|v| v.element_sum()).sum::<f32>();
        match method {
            Method::Standard => assert_eq!((sum(&indirect), &direct), (0.0, &frame.image.pixels)),
            _ => assert!(sum(&direct) > 0.0 && sum(&indirect) > 0.05 * sum(&direct), "{method:?}"),
        }
    }
}

/// Without bounces, the path tracer's light samples and the lamps that its rays find are all direct light.
#[test]
fn without_bounces_all_light_is_direct() {
    let scene = Scene::new(room()).expect("scene");
    for method in METHODS {
        let frame = shoot(&scene, &room_camera(), &options(method).with(|o| o.picture.aovs = all(method)));
        assert_eq!(colors(&frame, Aov::Direct), frame.image.pixels, "{method:?}");
        assert!(values(&frame, Aov::Indirect).iter().all(|&v| v == 0.0), "{method:?}");
    }
}

/// The floor y = 0 from above: albedo as it is, normal +y, and a depth along the camera's axis that solves
/// (eye + t · direction).y = 0, times the cosine of the ray with the axis. Above the horizon: nothing.
#[test]
fn a_floor_has_its_albedo_normal_and_depth() {
    let albedo = Vec3::new(0.6, 0.3, 0.1);
    let mut data = floor(albedo);
    data.lights.push(point_light(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(100.0)));
    let scene = Scene::new(data).expect("scene");
    let eye = Vec3::new(1.0, 2.0, 6.0);
    let pinhole = Camera::look_at(eye, Vec3::new(0.0, 1.0, 0.0), 1.0);
    let parallel = Camera { projection: Projection::Orthographic { xmag: 2.0, ymag: 1.5 }, ..pinhole.clone() };
    for camera in [pinhole, parallel] {
        for method in METHODS {
            let frame = shoot(&scene, &camera, &options(method).with(|o| o.picture.aovs = all(method)));
            let (mut hit, mut missed) = (0, 0);
            for (i, &depth) in values(&frame, Aov::Depth).iter().enumerate() {
                let rays = camera.film(64, 48);
                let ray = rays.ray((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5);
                let axis = rays.ray(32.0, 24.0).direction;
                let t = -ray.origin.y / ray.direction.y;
                let p = ray.at(t);
                let seen = (colors(&frame, Aov::Albedo)[i], colors(&frame, Aov::Normal)[i]);
                if t > 0.0 && Vec2::new(p.x, p.z).abs().max_element() < 9.9 {
                    hit += 1;
                    let wanted = t * ray.direction.dot(axis);
                    assert!((depth - wanted).abs() < 1e-4 * wanted, "{method:?}: {depth}, not {wanted}");
                    assert!((seen.0 - albedo).abs().max_element() < 1e-6 && (seen.1 - Vec3::Y).length() < 1e-6);
                } else if t <= 0.0 || Vec2::new(p.x, p.z).abs().max_element() > 10.1 {
                    missed += 1;
                    assert_eq!((depth, seen), (Aov::FAR_M, (Vec3::ZERO, Vec3::ZERO)), "{method:?}");
                }
            }
            assert!(hit > 500 && missed > 300, "{hit} {missed}");
        }
    }
}

/// A sphere's normal is (p − c) / r; a mirror counts with what it reflects, the red of a metal.
#[test]
fn a_mirrored_sphere_has_its_own_normal_and_colour() {
    let color = Vec3::new(0.9, 0.4, 0.2);
    let center = Vec3::new(0.0, 1.0, 0.0);
    let mut data = floor(Vec3::splat(0.5));
    data.materials.push(Material { base_color: color, metallic: 1.0, roughness: 0.0, ..Material::default() });
    data.spheres.push(Sphere { center, radius: 1.0, material: 1 });
    data.lights.push(point_light(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(100.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 5.0), center, 0.2);
    let frame = shoot(&scene, &camera, &options(Method::MESH).with(|o| o.picture.aovs = all(Method::MESH)));
    for (i, &depth) in values(&frame, Aov::Depth).iter().enumerate() {
        let ray = camera.film(64, 48).ray((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5);
        let p = ray.at(depth / -ray.direction.z);
        assert!((colors(&frame, Aov::Normal)[i] - (p - center)).length() < 1e-4);
        // Schlick: F0 + (1 − F0)(1 − cosθ)⁵.
        let m = 1.0 + ray.direction.dot(p - center);
        let fresnel = color + (Vec3::ONE - color) * (m * m * m * m * m);
        assert!((colors(&frame, Aov::Albedo)[i] - fresnel).abs().max_element() < 1e-4);
    }
}

/// Four samples of which some hit: colours are averaged with black, the depth is that of the floor at the horizon's
/// side.
#[test]
fn edges_do_not_average_depth_with_the_background() {
    let mut data = floor(Vec3::splat(0.5));
    data.lights.push(point_light(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(100.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 1.5, -8.0), 1.0);
    let options = options(Method::Standard).with(|o| {
        o.picture.spp = 16;
        o.picture.aovs = all(Method::Standard);
    });
    let frame = shoot(&scene, &camera, &options);
    let mut partly = 0;
    for (&depth, albedo) in values(&frame, Aov::Depth).iter().zip(colors(&frame, Aov::Albedo)) {
        assert!(depth == Aov::FAR_M || depth < 15.0, "{depth}");
        partly += usize::from(albedo.x > 0.0 && albedo.x < 0.49 && depth < 15.0);
    }
    assert!(partly > 30, "{partly}");
}

/// The outline of a lamp is sampled anew with 64 samples: layers are of those alone. The lamp, seen from straight
/// below, covers the same part of a pixel in each of them.
#[test]
fn outlines_of_lamps_have_the_layers_of_their_own_samples() {
    let mut data = floor(Vec3::splat(0.5));
    data.materials.push(Material { emission: Vec3::splat(1000.0), ..Material::lambert(Vec3::ZERO) });
    let c = |x: f32, z: f32| Vec3::new(x, 2.0, z);
    place(&mut data, quad([c(-0.51, -0.51), c(0.51, -0.51), c(0.51, 0.51), c(-0.51, 0.51)], 1));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 2.0, 0.0), 1.8);
    let options = options(Method::Standard).with(|o| {
        o.picture.spp = 4;
        o.picture.aovs = all(Method::Standard);
    });
    let frame = shoot(&scene, &camera, &options);
    let mut finer = 0;
    for ((p, normal), &depth) in
        frame.image.pixels.iter().zip(colors(&frame, Aov::Normal)).zip(values(&frame, Aov::Depth))
    {
        let covered = p.x / 1000.0;
        assert!((normal + Vec3::Y * covered).length() < 1e-5, "{normal} {covered}");
        assert!(if covered > 0.0 { (depth - 1.0).abs() < 1e-5 } else { depth == Aov::FAR_M }, "{depth} {covered}");
        finer += usize::from((covered * 4.0).fract() > 1e-3 && (covered * 4.0).fract() < 0.999);
    }
    assert!(finer > 10, "{finer}");
}

/// In an open room every point can be used, but in the cells at its edges and at the box in it.
#[test]
fn mesh_points_fail_near_obstacles_only() {
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH).with(|o| o.picture.aovs = all(Method::MESH));
    let frame = shoot(&scene, &room_camera(), &options);
    let (valid, depth) = (values(&frame, Aov::MeshValid), values(&frame, Aov::Depth));
    let (mut open, mut beside) = (0, 0);
    for (i, &valid) in valid.iter().enumerate() {
        assert!((0.0..=1.0).contains(&valid));
        let ray = room_camera().film(64, 48).ray((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5);
        let axis = room_camera().film(64, 48).ray(32.0, 24.0).direction;
        let p = ray.at(depth[i] / ray.direction.dot(axis));
        let to_box = (p.clamp(Vec3::new(-0.5, 0.0, -0.6), Vec3::new(0.6, 1.0, 0.5)) - p).length();
        let sides = [p.x + 2.0, 2.0 - p.x, p.y, 3.0 - p.y, p.z + 2.0, 2.0 - p.z];
        let at_an_edge = sides.iter().filter(|&&side| side < 0.41).count() > 1;
        if to_box > 0.41 && !at_an_edge {
            open += 1;
            assert_eq!(valid, 1.0, "{p}");
        } else {
            beside += usize::from(valid < 0.99);
        }
    }
    assert!(open > 500 && beside > 20, "{open} {beside}");
    assert!(values(&frame, Aov::MeshLevel).iter().all(|&level| level == 0.0));
}

/// Blocks beside a slit that is narrower than the mesh's spacing: points inside them are of no use.
#[test]
fn mesh_points_inside_solids_are_seen_and_fail() {
    let mut data = floor(Vec3::splat(0.5));
    // A slit of 0.1 m between two blocks, and a mesh of 0.2 m.
    place(&mut data, cuboid(Vec3::new(-3.0, -1.0, -3.0), Vec3::new(-0.05, 1.0, 3.0), 0));
    place(&mut data, cuboid(Vec3::new(0.05, -1.0, -3.0), Vec3::new(3.0, 1.0, 3.0), 0));
    data.lights.push(point_light(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(100.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 4.0, 0.01), Vec3::ZERO, 0.3);
    let options = options(Method::MESH).with(|o| o.picture.aovs = all(Method::MESH));
    let frame = shoot(&scene, &camera, &options);
    assert!(frame.stats.direct.points_invalid > 0);
    let least = values(&frame, Aov::MeshValid).iter().copied().fold(1.0, f32::min);
    assert!(least < 0.5, "{least}");
    let colors = colors(&frame, Aov::Points);
    let count = |is: fn(&&Vec3) -> bool| colors.iter().filter(is).count();
    assert!(count(|c| c.y > 2.0 * c.x.max(c.z)) > 50, "green points");
    assert!(count(|c| c.x > 2.0 * c.y.max(c.z)) > 5, "red points");
}

/// Points behind a wall are not drawn: the camera looks at a wall that nothing lights from a room full of points.
#[test]
fn points_behind_a_wall_are_not_seen() {
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH).with(|o| o.picture.aovs = all(Method::MESH));
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let drawn = |camera: &Camera, mesh: &mut LightMesh| {
        let frame = render(&scene, camera, &options, mesh, &()).expect("frame");
        colors(&frame, Aov::Points).iter().filter(|c| c.y > 2.0 * c.x.max(c.z)).count()
    };
    assert!(drawn(&room_camera(), &mut mesh) > 200);
    // From outside; the outer side faces no light, so it asks for no points.
    let outside = Camera::look_at(Vec3::new(9.0, 1.5, 0.0), Vec3::new(0.0, 1.5, 0.0), 0.1);
    assert_eq!(drawn(&outside, &mut mesh), 0);
}

#[test]
fn layers_of_a_mesh_need_one() {
    let scene = Scene::new(room()).expect("scene");
    for method in [Method::Standard, Method::Path] {
        for aov in [Aov::MeshLevel, Aov::MeshValid, Aov::Points] {
            let options = options(method).with(|o| o.picture.aovs = [aov].into_iter().collect());
            let mut mesh = LightMesh::new(&scene, &RenderOptions::default()).expect("mesh");
            let error = render(&scene, &room_camera(), &options, &mut mesh, &()).expect_err("no mesh").to_string();
            assert!(error.contains(aov.name()) && error.contains("standard and path do not"), "{error}");
        }
    }
}

/// 32 bytes a pixel for the picture, 12 more for a colour.
#[test]
fn layers_are_counted_before_they_are_allocated() {
    let plain = RenderOptions::default().with(|o| {
        o.picture.width = 1000;
        o.picture.height = 1000;
        o.limits.max_memory = 43_999_999;
    });
    plain.check_picture_memory().expect("32 MB fit");
    let layered = plain.with(|o| o.picture.aovs = [Aov::Albedo].into_iter().collect());
    assert!(matches!(layered.check_picture_memory(), Err(Error::OutOfMemory { needed_bytes: 44_000_000, .. })));
}
