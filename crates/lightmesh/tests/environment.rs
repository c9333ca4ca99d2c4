//! Light from every direction against closed forms.

use std::f32::consts::PI;

use crate::common::*;
use glam::{Quat, Vec3};
use lightmesh::geometry::Sphere;
use lightmesh::{
    AlphaMode, Camera, EmitterOptions, Environment, ImageData, Material, Method, Scene, SceneData, Texels,
};

/// Not the paper's: its one scalar at a mesh point has no side, so a floor gets half of a sky (measured: 0.51).
const METHODS: [Method; 3] = [Method::Standard, Method::MESH, Method::Path];

fn constant(radiance: Vec3) -> Environment {
    Environment { map: None, radiance, world_from_map: Quat::IDENTITY }
}

fn build(data: SceneData, light_samples: u32) -> Scene {
    Scene::with_emitters(data, &EmitterOptions { light_samples, ..EmitterOptions::default() }).expect("scene")
}

/// Mean of the pixels of a 64 × 48 picture that `choose` picks by column and row.
fn mean(pixels: &[Vec3], choose: impl Fn(f32, f32) -> bool) -> Vec3 {
    let at = |i: usize| (i as f32 % 64.0 - 31.5, (i / 64) as f32 - 23.5);
    let chosen: Vec<Vec3> = (0..pixels.len()).filter(|&i| choose(at(i).0, at(i).1)).map(|i| pixels[i]).collect();
    chosen.iter().sum::<Vec3>() / chosen.len() as f32
}

/// The white furnace: a convex body of albedo a under the radiance L from everywhere has the radiance a L, as E = π L
/// at each of its points; beside it L itself is seen. The white one disappears.
#[test]
fn a_ball_in_a_furnace_has_albedo_times_the_radiance() {
    let radiance = Vec3::new(3.0, 2.0, 1.0);
    for albedo in [1.0, 0.5] {
        for method in METHODS {
            let scene = build(
                SceneData {
                    materials: vec![Material::lambert(Vec3::splat(albedo))],
                    spheres: vec![Sphere { center: Vec3::ZERO, radius: 1.0, material: 0 }],
                    environment: Some(constant(radiance)),
                    ..SceneData::default()
                },
                256,
            );
            let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 0.6);
            let options = options(method).with(|o| {
                o.picture.spp = 4;
                o.transport.bounces = 3;
            });
            let pixels = shoot(&scene, &camera, &options).image.pixels;
            // The ball ends tan(asin(1/5)) / tan(0.3) · 24 = 15.8 pixels from the middle.
            let ball = mean(&pixels, |x, y| x.hypot(y) < 14.0) / (albedo * radiance);
            let beside = mean(&pixels, |x, y| x.hypot(y) > 18.0) / radiance;
            // Empirical: at a spacing of a fifth of the radius the mesh is 2.5% off.
            let tolerance = if method == Method::MESH { 0.04 } else { 0.02 };
            assert!((ball - 1.0).abs().max_element() < tolerance, "{method:?}, albedo {albedo}: {ball}");
            assert!((beside - 1.0).abs().max_element() < 1e-5, "{method:?}: {beside}");
        }
    }
}

/// A floor that sees half of the sphere of directions, at radiance L in its whole: albedo · L.
#[test]
fn a_floor_under_a_constant_sky_has_albedo_times_the_radiance() {
    let albedo = Vec3::new(0.8, 0.5, 0.2);
    for method in METHODS {
        let mut data = floor(albedo);
        data.environment = Some(constant(Vec3::splat(10.0)));
        let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.01), Vec3::ZERO, 0.8);
        let pixels = shoot(&build(data, 256), &camera, &options(method).with(|o| o.picture.spp = 4)).image.pixels;
        let ratio = mean(&pixels, |_, _| true) / (albedo * 10.0);
        assert!((ratio - 1.0).abs().max_element() < 0.02, "{method:?}: {ratio}");
    }
}

/// Surfaces that are cut out or have no opacity hide nothing of the sky: neither from shadow rays nor from the rays that
/// paths are made of.
#[test]
fn what_is_not_there_hides_nothing_of_the_sky() {
    for alpha_mode in [AlphaMode::Mask { cutoff: 0.5 }, AlphaMode::Blend] {
        for method in [Method::Standard, Method::Path, Method::unbiased(4)] {
            let mut data = floor(Vec3::splat(0.5));
            data.environment = Some(constant(Vec3::splat(10.0)));
            data.materials.push(Material { alpha: 0.0, alpha_mode, double_sided: true, ..Material::default() });
            let corners = [(-3.0, 3.0), (3.0, 3.0), (3.0, -3.0), (-3.0, -3.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
            place(&mut data, quad(corners, 1));
            let camera = Camera::look_at(Vec3::new(0.0, 0.9, 0.01), Vec3::ZERO, 0.8);
            let pixels = shoot(&build(data, 256), &camera, &options(method).with(|o| o.picture.spp = 16)).image.pixels;
            let ratio = mean(&pixels, |_, _| true) / 5.0;
            assert!((ratio - 1.0).abs().max_element() < 0.02, "{method:?} {alpha_mode:?}: {ratio}");
        }
    }
}

/// A sky that shines L from the half with x > 0 alone, turned about +Y by `turn`: by E = ∫ L cos over that half,
/// surfaces that face +X, +Z, −X after the turn get π L, π L / 2 and 0. The camera looks at a cube's side from outside.
#[test]
fn a_lit_half_lights_what_faces_it_and_turns() {
    let (width, height) = (256, 128);
    // Columns from a quarter to three quarters look towards +X.
    let texel = |i: u32| if (64..192).contains(&(i % width)) { [5.0, 5.0, 5.0, 1.0] } else { [0.0, 0.0, 0.0, 1.0] };
    let texels: Vec<[f32; 4]> = (0..width * height).map(texel).collect();
    let map = ImageData { name: "half".to_owned(), width, height, texels: Texels::Rgba32F(texels.into()) };
    for turn in [0.0, 1.0] {
        let rotation = Quat::from_rotation_y(turn);
        for method in [Method::Standard, Method::Path] {
            let mut data = SceneData { materials: vec![Material::lambert(Vec3::ONE)], ..SceneData::default() };
            place(&mut data, cuboid(Vec3::splat(-0.5), Vec3::splat(0.5), 0));
            data.instances[0].world_from_object = glam::Affine3A::from_quat(rotation);
            data.environment =
                Some(Environment { map: Some(map.clone()), radiance: Vec3::ONE, world_from_map: rotation });
            let scene = build(data, 512);
            for (facing, share) in [(Vec3::X, 1.0), (Vec3::Z, 0.5), (Vec3::NEG_X, 0.0)] {
                let camera = Camera::look_at(rotation * facing * 3.0, Vec3::ZERO, 0.3);
                let pixels = shoot(&scene, &camera, &options(method).with(|o| o.picture.spp = 16)).image.pixels;
                let got = mean(&pixels, |x, y| x.hypot(y) < 10.0);
                assert!((got - 5.0 * share).abs().max_element() < 0.1, "{method:?} {turn} {facing}: {got}");
            }
        }
    }
}

/// A punctual light with a radius is a sphere of the same power: beyond half-shadows it lights as the point does,
/// L = albedo / π · I cosθ / r², as a sphere of even radiance lights a plane that it is wholly above like its centre.
#[test]
fn a_radius_keeps_the_power_of_a_lamp() {
    for method in [Method::Standard, Method::MESH, Method::Path] {
        let mut data = floor(Vec3::ONE);
        data.lights.push(point_light(Vec3::new(0.0, 2.0, 0.0), Vec3::splat(50.0)));
        let emitters = EmitterOptions { light_radius: 0.4, ..EmitterOptions::default() };
        let scene = Scene::with_emitters(data, &emitters).expect("scene");
        // From the side, so that the lamp hides nothing of the floor's middle.
        let camera = Camera::look_at(Vec3::new(4.0, 1.0, 0.0), Vec3::ZERO, 0.02);
        let pixels = shoot(&scene, &camera, &options(method).with(|o| o.picture.spp = 64)).image.pixels;
        let ratio = mean(&pixels, |_, _| true) / (50.0 / PI / 4.0);
        assert!((ratio - 1.0).abs().max_element() < 0.02, "{method:?}: {ratio}");
    }
}
