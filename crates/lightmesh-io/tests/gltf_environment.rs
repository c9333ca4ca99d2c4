//! EXT_lights_image_based: what shines from where.

use std::f32::consts::PI;
use std::io::Cursor;

use crate::common::{Gltf, assert_says, assert_warns};
use glam::Vec3;
use image::{DynamicImage, ImageBuffer, ImageFormat, Rgb, Rgba};
use lightmesh::{Environment, Texels};
use lightmesh_io::LoadOptions;
use serde_json::{Value, json};

/// Nine coefficients of an even sky of radiance 1: E_00 = π / Y_00.
fn even() -> Value {
    let mut coefficients = vec![[0.0; 3]; 9];
    coefficients[0] = [PI / 0.282_095; 3];
    json!(coefficients)
}

/// The triangle, lit by this image-based light.
fn lit_by(light: Value) -> Gltf {
    with_light(Gltf::triangle(), light)
}

fn with_light(mut gltf: Gltf, light: Value) -> Gltf {
    gltf.json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    gltf.json["extensionsRequired"] = json!(["EXT_lights_image_based"]);
    gltf.json["extensions"]["EXT_lights_image_based"] = json!({"lights": [light]});
    gltf.json["scenes"][0]["extensions"]["EXT_lights_image_based"] = json!({"light": 0});
    gltf
}

fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// An RGBD face of one colour.
fn rgbd(size: u32, texel: [u8; 4]) -> Vec<u8> {
    png(ImageBuffer::from_pixel(size, size, Rgba(texel)))
}

/// A light whose sharpest level has these faces.
fn cube(faces: [Vec<u8>; 6], more: Value) -> Gltf {
    let mut gltf = Gltf::triangle();
    let indices = faces.map(|face| {
        let view = gltf.view(&face);
        gltf.push("images", json!({"bufferView": view, "mimeType": "image/png"}))
    });
    let mut light = json!({"irradianceCoefficients": even(), "specularImages": [indices], "specularImageSize": 4});
    light.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    with_light(gltf, light)
}

fn environment(gltf: &Gltf) -> Environment {
    let loaded = gltf.load().unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    loaded.data.environment.expect("an environment")
}

/// What is seen along a direction of the world, by the documentation of [`Environment::map`]: (u, v) looks along
/// (−cos 2πu sin πv, cos πv, −sin 2πu sin πv).
fn seen(environment: &Environment, direction: Vec3) -> Vec3 {
    let d = environment.world_from_map.inverse() * direction.normalize();
    let map = environment.map.as_ref().unwrap();
    let u = ((-d.z).atan2(-d.x) / (2.0 * PI)).rem_euclid(1.0);
    let v = d.y.clamp(-1.0, 1.0).acos() / PI;
    let texel = |share: f32, n: u32| ((share * n as f32) as u32).min(n - 1);
    let i = texel(v, map.height) * map.width + texel(u, map.width);
    match &map.texels {
        Texels::Rgba32F(texels) => Vec3::from_slice(&texels[i as usize]) * environment.radiance,
        Texels::Rgba8(_) => panic!("environment maps are floats"),
    }
}

const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Each face in turn is bright: white over D = 51/255 is 5, times the intensity 2.
#[test]
fn a_bright_face_shines_from_its_side() {
    for bright in 0..6 {
        let face = |i| rgbd(4, if i == bright { [255, 255, 255, 51] } else { [0, 0, 0, 255] });
        let environment = environment(&cube(std::array::from_fn(face), json!({"intensity": 2.0})));
        for (i, axis) in AXES.into_iter().enumerate() {
            let expected = if i == bright { 10.0 } else { 0.0 };
            assert!((seen(&environment, axis) - expected).abs().max_element() < 1e-3, "{bright} {axis}");
        }
    }
}

/// Faces are what a camera in the middle sees: on the +X face +Z is on the right and +Y above; the colours are those of
/// RGBD, (c / 255)^2.2.
#[test]
fn a_face_is_upright_and_not_mirrored() {
    let quarters = ImageBuffer::from_fn(8, 8, |x, y| match (x < 4, y < 4) {
        (true, true) => Rgba([255_u8, 0, 0, 255]),
        (false, true) => Rgba([0, 255, 0, 255]),
        (true, false) => Rgba([0, 0, 255, 255]),
        (false, false) => Rgba([128, 128, 128, 255]),
    });
    let face = |i| if i == 0 { png(quarters.clone()) } else { rgbd(8, [0, 0, 0, 255]) };
    let environment = environment(&cube(std::array::from_fn(face), json!({})));
    let grey = Vec3::splat((128.0_f32 / 255.0).powf(2.2));
    for (z, y, expected) in [(-0.5, 0.5, Vec3::X), (0.5, 0.5, Vec3::Y), (-0.5, -0.5, Vec3::Z), (0.5, -0.5, grey)] {
        let got = seen(&environment, Vec3::new(1.0, y, z));
        assert!((got - expected).abs().max_element() < 1e-3, "{y} {z}: {got} {expected}");
    }
}

/// Three channels are a plain sRGB picture: 188 is 0.5029.
#[test]
fn faces_without_alpha_are_srgb() {
    let face = |_| png(ImageBuffer::from_pixel(2, 2, Rgb([188_u8, 255, 0])));
    let got = seen(&environment(&cube(std::array::from_fn(face), json!({}))), Vec3::new(0.3, 0.5, -0.2));
    assert!((got - Vec3::new(0.502_886, 1.0, 0.0)).abs().max_element() < 1e-4, "{got}");
}

/// A quarter turn about +Y, counter-clockwise seen from above, takes +X to −Z.
#[test]
fn the_environment_turns_by_its_rotation() {
    let face = |i| rgbd(4, if i == 0 { [255; 4] } else { [0, 0, 0, 255] });
    let half = 0.5_f32.sqrt();
    let environment =
        environment(&cube(std::array::from_fn(face), json!({"rotation": [0, 3.0 * half, 0, 3.0 * half]})));
    assert!((seen(&environment, Vec3::NEG_Z) - 1.0).abs().max_element() < 1e-3);
    assert_eq!(seen(&environment, Vec3::X), Vec3::ZERO);
}

/// Without images the sky is what the coefficients of its irradiance say: L = E_00 Y_00 / π + E_11 Y_11 / (2π/3).
#[test]
fn without_faces_the_coefficients_are_shown() {
    let mut coefficients = vec![[0.0; 3]; 9];
    coefficients[0] = [PI / 0.282_095, 0.0, 0.0];
    // l = 1, m = 1 is x.
    coefficients[3] = [0.5 * (2.0 * PI / 3.0) / 0.488_603, 0.0, 0.0];
    let loaded = lit_by(json!({"irradianceCoefficients": coefficients, "intensity": 3.0})).load().unwrap();
    assert_warns(&loaded, &["image-based light 0", "specularImages", "irradianceCoefficients"]);
    let environment = loaded.data.environment.unwrap();
    for (axis, expected) in [(Vec3::X, 1.5), (Vec3::NEG_X, 0.5), (Vec3::Y, 1.0), (Vec3::Z, 1.0)] {
        let got = seen(&environment, axis);
        assert!((got - Vec3::new(3.0 * expected, 0.0, 0.0)).abs().max_element() < 0.1, "{axis}: {got}");
    }
}

#[test]
fn what_is_damaged_is_mended_or_refused() {
    let black = || std::array::from_fn(|_| rgbd(2, [0, 0, 0, 255]));
    // Mended: the coefficients take the place of the cube.
    for (faces, word) in [
        (
            {
                let mut faces: [Vec<u8>; 6] = black();
                faces[3] = b"no image".to_vec();
                faces
            },
            "cannot be decoded",
        ),
        (
            {
                let mut faces = black();
                faces[3] = rgbd(4, [0; 4]);
                faces
            },
            "squares of one size",
        ),
    ] {
        let loaded = cube(faces, json!({})).load().unwrap();
        assert_says(&loaded.warnings.join("; "), &[word, "irradianceCoefficients take their place"]);
        assert!((seen(loaded.data.environment.as_ref().unwrap(), Vec3::Y) - 1.0).abs().max_element() < 1e-3);
    }
    let loaded = cube(black(), json!({"specularImages": [[0, 1, 2, 3, 4]]})).load().unwrap();
    assert_says(&loaded.warnings.join("; "), &["has not six faces"]);
    let loaded = cube(black(), json!({"rotation": [0, 0, 0, 0]})).load().unwrap();
    assert_warns(&loaded, &["rotation", "zero length"]);
    // Left out.
    let loaded = lit_by(json!({"irradianceCoefficients": [[1, 1, 1]]})).load().unwrap();
    assert_warns(&loaded, &["left out"]);
    assert!(loaded.data.environment.is_none());
    // Refused.
    assert_says(&lit_by(json!({"intensity": -1.0})).refusal(), &["image-based light 0", "intensity -1"]);
    assert_says(&lit_by(json!({"irradianceCoefficients": [[1, 1]]})).refusal(), &["irradianceCoefficients"]);
    assert_says(&lit_by(json!({"irradianceCoefficients": [[1e39, 1, 1]]})).refusal(), &["irradianceCoefficients"]);
    let mut gltf = lit_by(json!({"name": "sky"}));
    gltf.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = json!(7);
    assert_says(&gltf.refusal(), &["scene 0", "image-based light 7"]);
    assert_says(&cube(black(), json!({"specularImages": [[0, 1, 2, 3, 4, 99]]})).refusal(), &["image 99"]);
    let outside = with_light(
        {
            let mut gltf = Gltf::triangle();
            gltf.push("images", json!({"uri": "../sky.png"}));
            gltf
        },
        json!({"specularImages": [[0, 0, 0, 0, 0, 0]]}),
    );
    assert_says(&outside.refusal(), &["image 0"]);
    // A face of a million texels is paid for before it is decoded.
    let big: [Vec<u8>; 6] = std::array::from_fn(|_| rgbd(1024, [0, 0, 0, 255]));
    let limited = LoadOptions { max_memory: 8 << 20, ..LoadOptions::default() };
    let message = cube(big, json!({})).load_with(&limited).map(|_| ()).unwrap_err().to_string();
    assert_says(&message, &["image 0", "--max-memory"]);
}

/// A scene that names no light has none, whatever the file holds.
#[test]
fn only_the_chosen_scene_is_lit() {
    let mut gltf = lit_by(json!({"irradianceCoefficients": even()}));
    gltf.push("scenes", json!({"name": "dark", "nodes": [0]}));
    let dark = LoadOptions { scene: Some("dark".to_owned()), ..LoadOptions::default() };
    assert!(gltf.load_with(&dark).unwrap().data.environment.is_none());
    assert!(gltf.load().unwrap().data.environment.is_some());
}
