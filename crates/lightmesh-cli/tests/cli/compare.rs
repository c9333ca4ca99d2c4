//! `lightmesh compare` from the outside.

use std::{fs::File, io::BufWriter};

use crate::place::Place;
use glam::Vec3;
use lightmesh::{Camera, Image};
use lightmesh_io::output::{Metadata, Precision, write_exr, write_png};
use serde_json::Value;

/// Writes a picture of `value` times a gradient, as EXR or PNG by the name.
fn picture(place: &Place, name: &str, width: u32, value: f32) {
    let image = Image::new(width, 8, (0..width * 8).map(|i| Vec3::splat(value * (1 + i) as f32)).collect());
    let metadata = Metadata {
        software: "test".into(),
        method: "mesh".into(),
        scene: "none".into(),
        settings: "{}".into(),
        seconds: 0.0,
        estimated_error: None,
        spp: 1,
        denoised: None,
        camera: Camera::look_at(Vec3::Z, Vec3::ZERO, 0.7),
    };
    let file = BufWriter::new(File::create(place.path(name)).unwrap());
    if name.ends_with(".exr") {
        write_exr(file, &image, &[], Precision::Single, &metadata).unwrap();
    } else {
        write_png(file, &image, -8.0, &metadata).unwrap();
    }
}

fn json(place: &Place, line: &str) -> Value {
    serde_json::from_str(&place.run(line).exits(0).stdout()).unwrap()
}

#[test]
fn a_picture_is_no_different_from_itself() {
    let place = Place::new();
    picture(&place, "a.exr", 16, 1.0);
    let result = json(&place, "compare a.exr a.exr --json");
    for key in ["relrmse", "bias", "max", "flip"] {
        assert_eq!(result[key], 0.0, "{key}");
    }
}

/// Half as bright again: bias 0.5; max 0.5 × 128.
#[test]
fn a_brighter_picture_has_its_factor_as_bias() {
    let place = Place::new();
    picture(&place, "a.exr", 16, 1.5);
    picture(&place, "b.exr", 16, 1.0);
    let result = json(&place, "compare a.exr b.exr --json");
    assert!((result["bias"].as_f64().unwrap() - 0.5).abs() < 1e-6);
    assert!((result["max"].as_f64().unwrap() - 64.0).abs() < 1e-6);
    assert!(result["flip"].as_f64().unwrap() > 0.01);
    let text = place.run("compare a.exr b.exr").exits(0).stdout();
    assert!(text.contains("bias     +0.500000"), "{text}");
}

#[test]
fn png_is_compared_with_png() {
    let place = Place::new();
    picture(&place, "a.png", 16, 1.0);
    picture(&place, "b.png", 16, 1.1);
    let run = place.run("compare a.png b.png --json").exits(0);
    assert_eq!(run.stderr(), "");
    let result: Value = serde_json::from_str(&run.stdout()).unwrap();
    assert!(result["relrmse"].as_f64().unwrap() > 0.0);
}

#[test]
fn sizes_must_match() {
    let place = Place::new();
    picture(&place, "a.exr", 16, 1.0);
    picture(&place, "b.exr", 32, 1.0);
    place.run("compare a.exr b.exr").exits(2).says(&["16x8", "32x8", "a.exr"]);
    place.run("compare a.exr c.exr").exits(2).says(&["c.exr"]);
    place.run("compare a.exr scene.gltf").exits(2).says(&["scene.gltf"]);
}
