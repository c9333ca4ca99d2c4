//! Mirror, glass, transparency and emission.

use std::f32::consts::PI;

use crate::common::*;
use glam::{Vec2, Vec3, Vec4};
use lightmesh::geometry::{Sphere, TriangleMesh};
use lightmesh::metrics::difference;
use lightmesh::{
    AlphaMode, Camera, Filter, ImageData, Light, Material, Method, RenderOptions, Scene, SceneData, Texels, Texture,
    TextureRef, UvTransform, Wrap,
};

const TRACERS: [Method; 3] = [Method::Standard, Method::MESH, Method::Path];

fn sun(lux: f32) -> Light {
    Light::Directional { direction: Vec3::NEG_Y, illuminance_lux: Vec3::splat(lux) }
}

fn middle(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Vec3 {
    shoot(scene, camera, options).image.pixels[24 * 64 + 32]
}

fn panel(data: &mut SceneData, y: f32, material: Material) {
    data.materials.push(material);
    let c = |x: f32, z: f32| Vec3::new(x, y, z);
    let mesh = quad([c(-2.0, 2.0), c(2.0, 2.0), c(2.0, -2.0), c(-2.0, -2.0)], data.materials.len() - 1);
    place(data, mesh);
}

/// A BLEND panel over a white floor: shadow rays keep (1 − α) mix(1, base, α), the eye sees α · panel + (1 − α) ·
/// floor.
#[test]
fn a_blended_panel_casts_a_coloured_shadow_and_is_seen_through() {
    let mut data = floor(Vec3::ONE);
    data.lights.push(sun(PI));
    let (base, alpha) = (Vec3::new(1.0, 0.5, 0.0), 0.4);
    panel(&mut data, 1.0, Material { alpha, alpha_mode: AlphaMode::Blend, ..Material::lambert(base) });
    let scene = Scene::new(data).expect("scene");
    let shadow = (1.0 - alpha) * Vec3::ONE.lerp(base, alpha);
    for method in TRACERS {
        let options = options(method).with(|o| o.picture.spp = if method == Method::Path { 4096 } else { 1 });
        let options = options.with(|o| {
            o.picture.width = 1;
            o.picture.height = 1;
        });
        let below = Camera::look_at(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO, 0.01);
        let above = Camera::look_at(Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO, 0.01);
        let seen = |camera| shoot(&scene, camera, &options).image.pixels[0];
        assert!((seen(&below) - shadow).length() < 1e-4, "{method:?}: {}", seen(&below));
        let over = alpha * base + (1.0 - alpha) * shadow;
        let tolerance = if method == Method::Path { 0.03 } else { 1e-4 };
        assert!((seen(&above) - over).length() < tolerance, "{method:?}: {} {over}", seen(&above));
    }
}

/// MASK below its cutoff is not there, above it is solid.
#[test]
fn a_mask_is_there_or_not() {
    for (alpha, lit) in [(0.4, true), (0.6, false)] {
        let mut data = floor(Vec3::ONE);
        data.lights.push(sun(PI));
        panel(&mut data, 1.0, Material { alpha, alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..Material::default() });
        let scene = Scene::new(data).expect("scene");
        for method in TRACERS {
            let below = Camera::look_at(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO, 0.01);
            assert_eq!(middle(&scene, &below, &options(method)).x > 0.5, lit, "{method:?} {alpha}");
        }
    }
}

/// A metal with roughness 0 shows what it mirrors, times its base colour (Schlick at normal incidence).
#[test]
fn a_metal_mirror_shows_the_emitter_times_its_colour() {
    let mut data = SceneData::default();
    let gold = Vec3::new(1.0, 0.7, 0.3);
    panel(&mut data, 0.0, Material { base_color: gold, metallic: 1.0, roughness: 0.0, ..Material::default() });
    let lamp = Material { base_color: Vec3::ZERO, emission: Vec3::splat(5.0), ..Material::default() };
    panel(&mut data, 4.0, Material { double_sided: true, ..lamp });
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 0.01);
    for method in TRACERS {
        assert!((middle(&scene, &camera, &options(method)) - 5.0 * gold).length() < 1e-2, "{method:?}");
    }
    let flat = options(Method::Standard).with(|o| o.transport.depth = 0);
    assert_eq!(middle(&scene, &camera, &flat), Vec3::ZERO);
}

/// A smooth dielectric reflects F0 = ((1.5 − 1) / (1.5 + 1))² = 0.04 at normal incidence, and diffuses the rest.
#[test]
fn a_smooth_dielectric_splits_by_fresnel() {
    let mut data = SceneData::default();
    panel(&mut data, 0.0, Material { base_color: Vec3::splat(0.5), roughness: 0.0, ..Material::default() });
    // Unlit: it shows, and lights nothing.
    panel(&mut data, 4.0, Material { base_color: Vec3::ONE, unlit: true, ..Material::default() });
    data.lights.push(point_light(Vec3::new(0.0, 2.0, 0.0), Vec3::splat(4.0 * PI)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 0.01);
    let expected = 0.04 + 0.96 * 0.5;
    assert!((middle(&scene, &camera, &options(Method::Standard)).x - expected).abs() < 2e-3);
}

/// Through the middle of a glass sphere a ray goes straight: (1 − F0)² of what is behind; and Snell's law holds at a
/// block's upper face: sinθt = sinθ / 1.5 shifts what is seen below.
#[test]
fn glass_refracts() {
    let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
    let mut data = SceneData { materials: vec![glass], ..SceneData::default() };
    data.spheres.push(Sphere { center: Vec3::new(0.0, 2.0, 0.0), radius: 0.5, material: 0 });
    panel(&mut data, 0.0, Material { base_color: Vec3::ZERO, emission: Vec3::splat(10.0), ..Material::default() });
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 4.0, 0.0), Vec3::ZERO, 0.01);
    let through = middle(&scene, &camera, &options(Method::Standard)).x;
    // Between its faces the light bounces on: 0.96² (1 + 0.04² + ...) with F0 = 0.04.
    let expected = 10.0 * 0.96 * 0.96 / (1.0 - 0.04 * 0.04);
    assert!((through - expected).abs() < 0.02, "{through} {expected}");

    // A block of glass, 1 m thick, on a floor whose left half emits. Seen at 45°, the ray lands sinθt / cosθt behind
    // its entry.
    let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
    let mut data = SceneData { materials: vec![glass], ..SceneData::default() };
    place(&mut data, cuboid(Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 1.0, 3.0), 0));
    data.materials.push(Material { base_color: Vec3::ZERO, emission: Vec3::splat(10.0), ..Material::default() });
    let edge = 1.0 + (0.5_f32.sqrt() / 1.5).asin().tan();
    let strip = |x0: f32, x1: f32| {
        let c = |x: f32, z: f32| Vec3::new(x, -0.001, z);
        quad([c(x0, 5.0), c(x1, 5.0), c(x1, -5.0), c(x0, -5.0)], 1)
    };
    for (from, seen) in [(edge + 0.05, false), (edge - 0.05, true)] {
        let mut data = data.clone();
        place(&mut data, strip(from, 9.0));
        let scene = Scene::new(data).expect("scene");
        // From (0, 2) at 45° down: enters the block at x = 1.
        let camera = Camera::look_at(Vec3::new(0.0, 2.0, 0.0), Vec3::new(1.0, 1.0, 0.0), 0.01);
        assert_eq!(middle(&scene, &camera, &options(Method::Standard)).x > 5.0, seen, "{from}");
    }
}

/// The sun through a clear pane that covers everything: Fresnel's share with all inner reflections, at every angle, for
/// a closed block, its two large faces alone, and a sheet of either side, single- or double-sided; times the base
/// colour, once per face.
#[test]
fn panes_pass_what_fresnel_says() {
    let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
    let tinted = Material { base_color: Vec3::new(0.5, 1.0, 0.25), ..glass.clone() };
    let corners =
        |y: f32| [(-90.0, 90.0), (90.0, 90.0), (90.0, -90.0), (-90.0, -90.0)].map(|(x, z)| Vec3::new(x, y, z));
    let (up, block) = (quad(corners(1.0), 1), cuboid(Vec3::new(-90.0, 1.0, -90.0), Vec3::new(90.0, 1.01, 90.0), 1));
    let (upper, lower) = (quad(corners(1.01), 1), inside_out(quad(corners(1.0), 1)));
    let sheet = Material { double_sided: true, ..glass.clone() };
    for (meshes, material, faces) in [
        (vec![block.clone()], &glass, 2),
        (vec![upper, lower], &glass, 2),
        (vec![up.clone()], &glass, 1),
        (vec![inside_out(up.clone())], &glass, 1),
        (vec![up.clone()], &sheet, 1),
        (vec![block.clone()], &sheet, 2),
        (vec![block], &tinted, 2),
        (vec![up], &tinted, 1),
    ] {
        for (degrees, passed) in [(0.0_f32, 0.923), (40.0, 0.914), (60.0, 0.848), (75.0, 0.618)] {
            let mut data = floor(Vec3::ONE);
            data.materials.push(material.clone());
            meshes.iter().for_each(|mesh| place(&mut data, mesh.clone()));
            let (sin, cos) = degrees.to_radians().sin_cos();
            let light = Light::Directional { direction: -Vec3::new(sin, cos, 0.0), illuminance_lux: Vec3::splat(PI) };
            data.lights.push(light);
            let scene = Scene::new(data).expect("scene");
            let below = Camera::look_at(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO, 0.01);
            let expected = material.base_color.powf(faces as f32) * (passed * cos);
            for method in TRACERS {
                let seen = middle(&scene, &below, &options(method).with(|o| o.transport.bounces = 0));
                assert!((seen - expected).length() < 2e-3, "{method:?} {degrees}: {seen} {expected}");
            }
        }
    }
}

/// A pane seen at 60° shows Fresnel's share of what is behind it, whether it is a block or a sheet of either side. Rays
/// carry no polarisation: (1 − R) / (1 + R) of the mean reflectance, 0.836, where a block's two faces are met one by
/// one, and 0.848 where they are one sheet.
#[test]
fn panes_are_seen_through_alike() {
    let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
    let corners = [(-9.0, 9.0), (9.0, 9.0), (9.0, -9.0), (-9.0, -9.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
    let block = cuboid(Vec3::new(-9.0, 1.0, -9.0), Vec3::new(9.0, 1.01, 9.0), 1);
    for (mesh, expected) in [(block, 0.836), (quad(corners, 1), 0.848), (inside_out(quad(corners, 1)), 0.848)] {
        let mut data = floor(Vec3::ZERO);
        data.materials[0].emission = Vec3::ONE;
        data.materials.push(glass.clone());
        place(&mut data, mesh);
        let scene = Scene::new(data).expect("scene");
        let camera = Camera::look_at(Vec3::new(-3.0_f32.sqrt(), 2.0, 0.0), Vec3::new(0.0, 1.0, 0.0), 0.01);
        // Weak reflections within the block go on by chance.
        let options = options(Method::Standard).with(|o| o.picture.spp = 1024);
        let seen = middle(&scene, &camera, &options).x;
        assert!((seen - expected).abs() < 4e-3, "{seen}");
    }
}

/// A ball of 12 × 6 quads with smooth normals: E n · l at the edge of the shade too, where a facet faces away from the
/// sun; nothing where n · l < 0.
#[test]
fn smooth_balls_of_few_triangles_have_no_black_facets() {
    let mut mesh = TriangleMesh::default();
    for i in 0..=6 {
        for j in 0..12 {
            let (t, p) = (PI * i as f32 / 6.0, PI * j as f32 / 6.0);
            mesh.positions.push(Vec3::new(t.sin() * p.cos(), t.cos(), -t.sin() * p.sin()));
            let at = |i: u32, j: u32| i * 12 + j % 12;
            if i < 6 {
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                mesh.triangles.push([at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]);
            }
        }
    }
    mesh.normals = mesh.positions.clone();
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::ONE)], ..SceneData::default() };
    place(&mut data, mesh);
    let light = Vec3::new(3.0, 0.6, 0.6).normalize();
    data.lights.push(Light::Directional { direction: -light, illuminance_lux: Vec3::splat(PI) });
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 0.5);
    let image = shoot(&scene, &camera, &options(Method::Standard).with(|o| o.transport.bounces = 0)).image;
    let mut lit = 0;
    for (i, pixel) in image.pixels.iter().enumerate() {
        let ray = camera.film(64, 48).ray((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5);
        let b = -ray.origin.dot(ray.direction);
        let discriminant = b * b - ray.origin.length_squared() + 1.0;
        // Not at the outline, where facets cut off the ball.
        if discriminant > 0.15 {
            let cos = ray.at(b - discriminant.sqrt()).dot(light);
            lit += usize::from(cos > 0.08);
            assert!(cos < 0.08 || pixel.x > 0.02, "{i}: {} {cos}", pixel.x);
            assert!(cos > -0.15 || pixel.x == 0.0, "{i}: {} {cos}", pixel.x);
        }
    }
    assert!(lit > 300, "{lit}");
}

/// Emission and unlit colours are seen as they are, whatever the light.
#[test]
fn emission_and_unlit_are_seen_directly() {
    let mut data = SceneData::default();
    panel(
        &mut data,
        0.0,
        Material { emission: Vec3::new(1.0, 2.0, 3.0), base_color: Vec3::ZERO, ..Material::default() },
    );
    panel(&mut data, -1.0, Material { base_color: Vec3::new(0.1, 0.2, 0.3), unlit: true, ..Material::default() });
    data.lights.push(sun(100.0));
    let scene = Scene::new(data).expect("scene");
    for method in TRACERS {
        let above = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::ZERO, 0.01);
        assert_eq!(middle(&scene, &above, &options(method)), Vec3::new(1.0, 2.0, 3.0));
        let below = Camera::look_at(Vec3::new(0.0, -2.0, 0.0), Vec3::NEG_Y, 0.01);
        assert_eq!(middle(&scene, &below, &options(method)), Vec3::new(0.1, 0.2, 0.3));
    }
}

/// Furnace: inside a closed box of albedo a and emission e the radiance is e / (1 − a) everywhere. Path tracing with 64
/// bounces leaves out a⁶⁴.
#[test]
fn path_passes_the_furnace() {
    for albedo in [0.2, 0.5, 0.8] {
        let material = Material { emission: Vec3::ONE, ..Material::lambert(Vec3::splat(albedo)) };
        let mut data = SceneData { materials: vec![material], ..SceneData::default() };
        place(&mut data, inside_out(cuboid(Vec3::splat(-1.0), Vec3::splat(1.0), 0)));
        let scene = Scene::new(data).expect("scene");
        let options = options(Method::Path).with(|o| {
            o.transport.bounces = 64;
            o.picture.spp = 64;
            o.picture.width = 16;
            o.picture.height = 16;
        });
        let frame = shoot(&scene, &Camera::look_at(Vec3::ZERO, Vec3::new(0.3, 0.2, -1.0), 1.0), &options);
        let mean = frame.image.pixels.iter().map(|p| f64::from(p.x)).sum::<f64>() / 256.0;
        let expected = 1.0 / (1.0 - f64::from(albedo));
        // 16,384 paths with a fixed seed; only roulette, after four bounces, makes them differ.
        assert!((mean / expected - 1.0).abs() < 0.01, "{albedo}: {mean} {expected}");
    }
}

/// A normal map's green is up in the picture, its red to the right: (½ ± x, ½ ± y) lean the normal that way. The panel
/// faces +Y with u along +X and v along +Z (down in the picture), so "up" is −Z. From both sides of the panel, with
/// given tangents and with those derived from the texture coordinates.
#[test]
fn normal_maps_lean_the_way_they_are_painted() {
    let lean = 0.6_f32;
    for (texel, toward) in [([204, 128, 230, 255], Vec3::X), ([128, 204, 230, 255], Vec3::NEG_Z)] {
        for with_tangents in [false, true] {
            let image = ImageData { name: String::new(), width: 1, height: 1, texels: Texels::Rgba8([texel].into()) };
            let texture = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Nearest };
            let map = TextureRef { texture: 0, uv_set: 0, transform: UvTransform::default() };
            let mut data = SceneData { images: vec![image], textures: vec![texture], ..SceneData::default() };
            panel(&mut data, 0.0, Material { normal_texture: Some(map), ..Material::lambert(Vec3::ONE) });
            let mesh = &mut data.meshes[0];
            mesh.uvs[0] = mesh.positions.iter().map(|p| Vec2::new(p.x, p.z)).collect();
            if with_tangents {
                // glTF: bitangent = (n × t) · w; Y × X = −Z, which is up.
                mesh.normals = vec![Vec3::Y; 4];
                mesh.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4];
            }
            // Light from straight above the leaning normal is brighter than from the other side, by the ratio of
            // cosines.
            let mut bright = |direction: Vec3, eye: f32| {
                data.lights = vec![Light::Directional { direction: -direction, illuminance_lux: Vec3::splat(PI) }];
                let scene = Scene::new(data.clone()).expect("scene");
                let camera = Camera::look_at(Vec3::new(0.0, eye, 0.0), Vec3::ZERO, 0.01);
                middle(&scene, &camera, &options(Method::Standard)).x
            };
            for (eye, up) in [(1.0, Vec3::Y), (-1.0, Vec3::NEG_Y)] {
                let (near, far) = (bright(up * 0.8 + toward * lean, eye), bright(up * 0.8 - toward * lean, eye));
                // From behind, glTF turns the whole frame over: what leaned toward X leans away from it.
                let (near, far) = if eye > 0.0 { (near, far) } else { (far, near) };
                assert!(near > 0.97 && far < 0.4, "{texel:?} {with_tangents} {eye}: {near} {far}");
            }
        }
    }
}

/// What a mirror shows takes its light from the mesh like what is seen directly: no shadow ray but those of mesh
/// points, and two to the lamp's image in the mirror.
#[test]
fn mirrored_hits_read_the_mesh() {
    let mut data = floor(Vec3::splat(0.8));
    data.lights.push(point_light(Vec3::new(1.0, 2.0, 1.0), Vec3::splat(50.0)));
    data.materials.push(Material { metallic: 1.0, roughness: 0.0, ..Material::default() });
    let c = |x: f32, y: f32| Vec3::new(x, y, -3.0);
    place(&mut data, quad([c(-6.0, -1.0), c(6.0, -1.0), c(6.0, 5.0), c(-6.0, 5.0)], 1));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.5, 2.0), Vec3::new(0.0, 0.9, -3.0), 0.3);
    let (mesh, truth) = (options(Method::MESH), options(Method::Standard));
    let (mesh, truth) = (shoot(&scene, &camera, &mesh), shoot(&scene, &camera, &truth));
    let d = difference(&mesh.image.pixels, &truth.image.pixels);
    assert!(d.relrmse < 1e-4 && truth.image.pixels[40 * 64 + 32].x > 0.1, "{d:?}");
    let stats = mesh.stats;
    assert!(stats.rays.secondary > 64 * 48 / 2 && stats.exact_fallbacks == 0, "{stats:?}");
    assert_eq!(stats.fill_shadow_rays, stats.direct.points_used - stats.direct.points_invalid);
    assert!(stats.rays.shadow - stats.fill_shadow_rays <= 2 * 64 * 48, "{stats:?}");
}

/// A lamp 1 m above a floor and 1 m below a mirror that faces down: I (1 / 1² + 1 / 3²) a/π, by every method.
#[test]
fn a_lamp_shines_by_way_of_a_mirror() {
    let mut data = floor(Vec3::splat(0.5));
    data.lights.push(point_light(Vec3::Y, Vec3::splat(30.0)));
    data.materials.push(Material { metallic: 1.0, roughness: 0.0, base_color: Vec3::ONE, ..Material::default() });
    let c = |x: f32, z: f32| Vec3::new(x, 2.0, z);
    place(&mut data, quad([c(-2.0, -2.0), c(2.0, -2.0), c(2.0, 2.0), c(-2.0, 2.0)], 1));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 1.2, 3.0), Vec3::ZERO, 0.3);
    let expected = 0.5 / PI * 30.0 * (1.0 + 1.0 / 9.0);
    for method in [Method::Standard, Method::MESH, Method::Hybrid, Method::UNBIASED, Method::Path] {
        let image = shoot(&scene, &camera, &options(method)).image;
        let middle = image.pixels[24 * 64 + 32].x;
        assert!((middle / expected - 1.0).abs() < 0.02, "{method:?}: {middle} {expected}");
    }
}
