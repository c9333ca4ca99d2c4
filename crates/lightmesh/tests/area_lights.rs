//! Emissive surfaces as light: closed forms for a rectangle and a sphere, sides, textures, and light that is counted
//! once.

use std::f32::consts::PI;

use crate::common::*;
use glam::{Quat, Vec2, Vec3};
use lightmesh::geometry::Sphere;
use lightmesh::{
    Camera, EmitterOptions, Environment, Filter, ImageData, Light, Material, Method, Scene, SceneData, Spacing, Texels,
    Texture, TextureRef, UvTransform, Wrap,
};

const METHODS: [Method; 3] = [Method::Standard, Method::MESH, Method::Path];

/// A black surface that shines.
fn lamp(emission: f32) -> Material {
    Material { emission: Vec3::splat(emission), ..Material::lambert(Vec3::ZERO) }
}

/// Adds a rectangle of a × b m about (0, height, 0) that faces down.
fn hang(data: &mut SceneData, material: Material, height: f32, a: f32, b: f32) {
    data.materials.push(material);
    let c = |x: f32, z: f32| Vec3::new(x * a / 2.0, height, z * b / 2.0);
    let mut mesh = quad([c(-1.0, -1.0), c(1.0, -1.0), c(1.0, 1.0), c(-1.0, 1.0)], data.materials.len() - 1);
    mesh.uvs[0] = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    place(data, mesh);
}

/// Mean radiance of the floor's spot at the origin.
fn spot(scene: &Scene, method: Method) -> f32 {
    // Exact shadow rays go to random points.
    let spp = match method {
        Method::Path => 4096,
        Method::Standard => 256,
        _ => 1,
    };
    let options = options(method).with(|o| {
        o.picture.width = 1;
        o.picture.height = 1;
        o.picture.spp = spp;
        o.mesh.spacing = Spacing::Metres(0.25);
    });
    let camera = Camera::look_at(Vec3::new(0.0, 0.3, 0.0), Vec3::ZERO, 0.001);
    shoot(scene, &camera, &options).image.pixels[0].x
}

/// Irradiance below the middle of a rectangle of a × b m and 1 cd/m², h above: four corners of a/2 × b/2, each
/// ½ (A/√(1+A²) atan(B/√(1+A²)) + B/√(1+B²) atan(A/√(1+B²))), A = a/2h, B = b/2h.
fn below_rectangle(a: f32, b: f32, h: f32) -> f32 {
    let (a, b) = (a / 2.0 / h, b / 2.0 / h);
    let (p, q) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    4.0 * 0.5 * (a / p * (b / p).atan() + b / q * (a / q).atan())
}

/// Emission that is sampled, an environment and punctual lights with a radius have a size; points have none.
#[test]
fn lights_with_a_size_are_known() {
    let has = |light_radius: f32, change: fn(&mut SceneData)| {
        let mut data = SceneData::default();
        hang(&mut data, Material::lambert(Vec3::splat(0.5)), 0.0, 1.0, 1.0);
        data.lights.push(Light::Point { position: Vec3::Y, intensity_cd: Vec3::ONE, range: None });
        change(&mut data);
        let emitters = EmitterOptions { light_radius, ..EmitterOptions::default() };
        Scene::with_emitters(data, &emitters).expect("a scene").has_lights_with_size()
    };
    assert!(!has(0.0, |_| {}));
    assert!(has(0.1, |_| {}));
    assert!(has(0.0, |data| data.environment =
        Some(Environment { map: None, radiance: Vec3::ONE, world_from_map: Quat::IDENTITY })));
    assert!(has(0.0, |data| hang(data, lamp(100.0), 2.0, 1.0, 1.0)));
}

/// Within 2%, 1% for paths: far from the lamp and a quarter of its width below it.
#[test]
fn a_rectangle_lights_the_floor_by_its_form_factor() {
    for (a, b, h) in [(0.5, 0.5, 2.0), (1.0, 2.0, 1.5), (2.0, 2.0, 0.5)] {
        let mut data = floor(Vec3::splat(0.5));
        hang(&mut data, lamp(100.0), h, a, b);
        let scene = Scene::new(data).expect("scene");
        let expected = 100.0 * below_rectangle(a, b, h) * 0.5 / PI;
        for method in METHODS {
            let tolerance = if method == Method::Path { 0.01 } else { 0.02 };
            let found = spot(&scene, method);
            assert!((found / expected - 1.0).abs() < tolerance, "{method:?}, {a} x {b} at {h}: {found} {expected}");
        }
    }
}

/// Exact shadow rays go to random points: with few strata of a lamp that is four times as wide as it is high, the mean
/// over 256 seeds is the form factor within four standard errors, of at most 0.6%.
#[test]
fn light_from_random_points_has_no_bias() {
    let mut data = floor(Vec3::splat(0.5));
    hang(&mut data, lamp(100.0), 0.5, 2.0, 2.0);
    let scene =
        Scene::with_emitters(data, &EmitterOptions { light_samples: 4, ..EmitterOptions::default() }).expect("scene");
    let expected = f64::from(100.0 * below_rectangle(2.0, 2.0, 0.5) * 0.5 / PI);
    let camera = Camera::look_at(Vec3::new(0.0, 0.3, 0.0), Vec3::ZERO, 0.001);
    for method in [Method::Standard, Method::Unbiased { rays: 2 }] {
        let found = |seed: u64| {
            let options = options(method).with(|o| {
                o.picture.width = 1;
                o.picture.height = 1;
                o.picture.spp = 64;
                o.mesh.spacing = Spacing::Metres(0.25);
                o.seed = seed;
            });
            f64::from(shoot(&scene, &camera, &options).image.pixels[0].x)
        };
        let values: Vec<f64> = (0..256).map(found).collect();
        let mean = values.iter().sum::<f64>() / 256.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 255.0;
        let standard_error = (variance / 256.0).sqrt();
        let z = (mean - expected) / standard_error;
        assert!(z.abs() < 4.0 && standard_error < 0.006 * expected, "{method:?}: {mean} {expected} {z}");
    }
}

/// A sphere of radius r at distance d in the zenith: E = π L r² / d², whatever d > r.
#[test]
fn a_sphere_lights_the_floor_as_its_solid_angle() {
    let mut data = floor(Vec3::splat(0.5));
    data.materials.push(lamp(100.0));
    data.spheres.push(Sphere { center: Vec3::new(0.0, 2.0, 0.0), radius: 0.5, material: 1 });
    let scene = Scene::new(data).expect("scene");
    let expected = 100.0 * PI * 0.25 / 4.0 * 0.5 / PI;
    for method in METHODS {
        let found = spot(&scene, method);
        assert!((found / expected - 1.0).abs() < 0.02, "{method:?}: {found} {expected}");
    }
}

/// Turned up, a single-sided lamp does not light the floor; a double-sided one does as if it faced it.
#[test]
fn the_back_of_a_single_sided_lamp_is_dark() {
    let expected = 100.0 * below_rectangle(1.0, 1.0, 1.5) * 0.5 / PI;
    for (double_sided, brightness) in [(false, 0.0), (true, expected)] {
        let mut data = floor(Vec3::splat(0.5));
        hang(&mut data, Material { double_sided, ..lamp(100.0) }, 1.5, 1.0, 1.0);
        let up = inside_out(data.meshes.pop().expect("the lamp"));
        data.meshes.push(up);
        let scene = Scene::new(data).expect("scene");
        for method in METHODS {
            let found = spot(&scene, method);
            assert!((found - brightness).abs() < 0.02 * expected, "{method:?} {double_sided}: {found} {brightness}");
        }
    }
}

/// A texture that is black but for one half: the light of half the lamp.
#[test]
fn a_textured_lamp_shines_where_its_texture_does() {
    let mut data = floor(Vec3::splat(0.5));
    let texel = |i: usize| if i % 64 < 32 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
    data.images.push(ImageData {
        name: String::new(),
        width: 64,
        height: 2,
        texels: Texels::Rgba32F((0..128).map(texel).collect::<Vec<_>>().into()),
    });
    let wrap = Wrap::ClampToEdge;
    data.textures.push(Texture { image: 0, wrap_s: wrap, wrap_t: wrap, filter: Filter::Nearest });
    let texture = TextureRef { texture: 0, uv_set: 0, transform: UvTransform::default() };
    hang(&mut data, Material { emission_texture: Some(texture), ..lamp(100.0) }, 1.5, 1.0, 1.0);
    let scene = Scene::new(data).expect("scene");
    // Below the middle of the whole, both halves give the same.
    let expected = 0.5 * 100.0 * below_rectangle(1.0, 1.0, 1.5) * 0.5 / PI;
    for method in METHODS {
        let found = spot(&scene, method);
        assert!((found / expected - 1.0).abs() < 0.03, "{method:?}: {found} {expected}");
    }
}

/// A lamp is sampled, a panel that glows as dimly as a lit wall is left to gather rays; the picture has the light of
/// each once: what paths find, within 6% (bounces read off the surfaces are up to 4% too bright at this spacing:
/// indirect_light.rs).
#[test]
fn emission_counts_once_whether_it_is_sampled_or_gathered() {
    for (emission, sampled) in [(200.0, true), (1.0, false)] {
        let mut data = room();
        data.lights.clear();
        data.lights.push(point_light(Vec3::new(-1.0, 2.5, 1.0), Vec3::splat(if sampled { 0.001 } else { 2.0 })));
        let size = if sampled { 0.6 } else { 2.5 };
        hang(&mut data, Material { double_sided: true, ..lamp(emission) }, 2.7, size, size);
        let scene = Scene::new(data).expect("scene");
        let gi = |method, spp| {
            let mesh = options(method).with(|o| {
                o.transport.bounces = 3;
                o.picture.spp = spp;
                o.mesh.indirect_spacing = Spacing::Metres(0.2);
            });
            let pixels = shoot(&scene, &room_camera(), &mesh).image.pixels;
            pixels.iter().sum::<Vec3>() / pixels.len() as f32
        };
        let (mesh, path) = (gi(Method::MESH, 1), gi(Method::Path, 64));
        let off = (mesh / path - Vec3::ONE).abs().max_element();
        assert!(off < 0.06, "emission {emission}: {mesh} {path}");
    }
}
