//! `--denoise` from the outside.
#![allow(clippy::print_stdout, reason = "a skipped test says so; the rest is shown on failure only")]

use std::fs;

use lightmesh_denoise::Denoiser;
use serde_json::Value;

use crate::place::Place;

/// Whether the library is there; says so if it is not.
fn has_library() -> bool {
    match Denoiser::load() {
        Ok(_) => true,
        Err(error) => {
            println!("skipped: {error}");
            false
        }
    }
}

fn stats(place: &Place, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(place.path(name)).unwrap()).unwrap()
}

/// Without the library nothing is rendered and nothing is written, and one sentence says how to get it.
#[test]
fn a_missing_library_is_said_before_the_render() {
    let place = Place::new();
    let line = "render scene.gltf -o a.png --stats a.json --size 16x16 --denoise";
    place.run_with(&[("LIGHTMESH_OIDN", "/nonexistent")], line).exits(2).says(&[
        "LIGHTMESH_OIDN",
        "/nonexistent",
        "Open Image Denoise",
        "pip install pyoidn",
    ]);
    assert_eq!(place.files(), ["scene.gltf"]);
    // Any other file, too.
    place.run_with(&[("LIGHTMESH_OIDN", "scene.gltf")], line).exits(2).says(&["LIGHTMESH_OIDN: scene.gltf: "]);
    assert_eq!(place.files(), ["scene.gltf"]);
}

/// Pictures without noise are left as they are, with a warning, and take no library.
#[test]
fn a_method_without_noise_gets_a_warning() {
    let place = Place::new();
    let line = "render scene.gltf -o a.exr --size 16x16 --method paper --bounces 0";
    let variables = [("LIGHTMESH_OIDN", "/nonexistent")];
    let run = place.run_with(&variables, &format!("{line} --denoise --stats a.json")).exits(0);
    assert!(run.stderr().contains("warning: denoise: pictures by the method paper have no noise"), "{}", run.stderr());
    assert!(stats(&place, "a.json")["denoiser"].is_null());
    // Whether lights have a size is known when the scene is.
    if has_library() {
        let said = place.run("render scene.gltf -o b.png --size 16x16 --method standard --denoise").exits(0).stderr();
        assert!(said.contains("warning: denoise: pictures by the method standard of lights without a size"), "{said}");
    }
}

/// Files and statistics say what took the noise out, and the layers that it needed are not in them.
#[test]
fn a_denoised_picture_says_so() {
    if !has_library() {
        return;
    }
    let place = Place::new();
    let line = "render scene.gltf --size 24x16 --spp 1 --method path --denoise --quiet --aov normal";
    place.run(&format!("{line} -o a.exr -o a.png --stats a.json --preview p.png")).exits(0);
    let stats = stats(&place, "a.json");
    let denoiser = stats["denoiser"].as_str().expect("a name");
    assert!(denoiser.starts_with("Open Image Denoise 2.") && stats["seconds"]["denoise"].as_f64() > Some(0.0));
    for file in ["a.exr", "a.png"] {
        let bytes = fs::read(place.path(file)).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains(denoiser), "{file}");
    }
    let text = String::from_utf8_lossy(&fs::read(place.path("a.exr")).unwrap()).into_owned();
    assert!(text.contains("normal.X") && !text.contains("albedo.R") && text.contains(r#""aov":"normal""#));
    // The preview has become the denoised picture.
    let same = place.run("compare p.png a.png").exits(0).stdout();
    assert!(same.contains("relrmse  0.000000"), "{same}");
}

/// What denoising takes is counted before anything is rendered.
#[test]
fn memory_is_counted() {
    if has_library() {
        let line = "render scene.gltf -o a.png --size 1000x1000 --method path --denoise --max-memory 300MiB";
        Place::new().run(line).exits(2).says(&["denoising", "300.0 MiB", "--size", "--max-memory"]);
    }
}

/// On a room of our own, four samples of the unbiased method come at least twice as close to many as without.
#[test]
fn the_error_falls() {
    if !has_library() {
        return;
    }
    let place = Place::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell.glb");
    let line = format!("render {scene} --size 64x64 --bounces 2 --quiet");
    place.run(&format!("{line} -o truth.exr --method path --spp 256 --seed 9")).exits(0);
    let error = |more: &str| -> f64 {
        place.run(&format!("{line} -o a.exr --method unbiased --rays 1 --spp 4 {more}")).exits(0);
        let found: Value =
            serde_json::from_str(&place.run("compare a.exr truth.exr --json").exits(0).stdout()).unwrap();
        assert!(found["bias"].as_f64().unwrap().abs() < 0.02, "{found}");
        found["relrmse"].as_f64().unwrap()
    };
    let (noisy, denoised) = (error(""), error("--denoise"));
    assert!(denoised < 0.5 * noisy, "{noisy} {denoised}");
}
