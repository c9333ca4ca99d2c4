//! Files that are meant to do harm, or that went wrong: one sentence, or a picture that holds numbers.

use std::fmt::Write;

use crate::place::{Place, Run};

const RENDER: &str = "-o a.exr --size 16x12 --spp 1 --stats a.json";

fn render(place: &Place, scene: &str, more: &str) -> Run {
    place.run(&format!("render {scene} {RENDER} {more}"))
}

fn stats(place: &Place) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(place.path("a.json")).unwrap()).unwrap()
}

/// A floor of 4 × 4 m and what stands on it, as an OBJ.
fn floor_and(more: &str) -> String {
    format!("v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 4 3 2\n{more}")
}

/// A corner far outside, in the mesh or in the world.
#[test]
fn what_reaches_too_far_is_named() {
    let place = Place::new();
    place.write("stray.obj", &floor_and("v 1 1 1e38\nf 1 2 5\n"));
    render(&place, "stray.obj", "-q").exits(2).says(&["stray.obj", "mesh 0", "reaches 1e38; 1e18 is the most"]);
    place.write("far.obj", &floor_and("v 1 1 1e15\nf 1 2 5\n"));
    render(&place, "far.obj", "-q").exits(2).says(&["far.obj", "instance 0 of mesh 0", "1e9 m is the most"]);
    let scene = std::fs::read_to_string(place.path("scene.gltf")).unwrap();
    let lens = r#""orthographic", "orthographic": { "xmag": 1, "ymag": 3e38, "znear": 0, "zfar": 1 } }]"#;
    let (before, after) = scene.split_once(r#""perspective", "name""#).unwrap();
    let (_, after) = after.split_once("}]").unwrap();
    place.write("wide.gltf", &format!("{before}{lens}{after}"));
    render(&place, "wide.gltf", "-q").exits(2).says(&["wide.gltf", "camera 0", "half its view"]);
    place.write("bright.gltf", &scene.replace(r#""intensity": 100.0"#, r#""intensity": 2e38"#));
    render(&place, "bright.gltf", "-q").exits(2).says(&["bright.gltf", "light 0", "above 1e30"]);
}

/// Rooms as large and as small as they may be, by every way to compute light.
#[test]
fn every_size_gives_numbers() {
    let place = Place::new();
    for size in [1e-30, 1e-12, 1e8, 4e8] {
        let scaled = floor_and("v 0 1 0\nf 1 2 5\n").lines().fold(String::new(), |mut text, line| {
            match line.strip_prefix("v ") {
                None => writeln!(text, "{line}").unwrap(),
                Some(numbers) => {
                    let scaled = numbers.split(' ').map(|n| (n.parse::<f64>().unwrap() * size).to_string());
                    writeln!(text, "v {}", scaled.collect::<Vec<_>>().join(" ")).unwrap();
                }
            }
            text
        });
        place.write("scaled.obj", &scaled);
        for method in ["mesh", "hybrid", "path", "standard"] {
            render(&place, "scaled.obj", &format!("-q --method {method}")).exits(0);
            assert_eq!(stats(&place)["non_finite_pixels"], 0, "{size} {method}");
        }
    }
}

/// Many copies of one triangle, exactly or nearly at one place, cost no more than one.
#[test]
fn copies_are_left_out_and_said() {
    let place = Place::new();
    for step in [0.0, 1e-7] {
        let mut text = floor_and("");
        for i in 0..20_000 {
            let z = f64::from(i) * step;
            write!(text, "v -1 0.5 {z}\nv 1 0.5 {z}\nv 0 1.5 {}\nf -3 -2 -1\n", z + 0.2).unwrap();
        }
        place.write("copies.obj", &text);
        let run = render(&place, "copies.obj", "--method path").exits(0);
        let said =
            run.stderr().lines().find(|line| line.contains("lie where others of their mesh do")).map(str::to_owned);
        let count: u32 = said.as_deref().and_then(|line| line.split(' ').nth(1)?.parse().ok()).unwrap_or(0);
        assert!(count > 19_000, "{step}: {}", run.stderr());
    }
}

/// What a limit does not hold is refused before it is built, with what it would take; the process stays small.
#[test]
#[cfg(target_os = "linux")]
fn the_limit_of_memory_holds() {
    let place = Place::new();
    let (n, mut text) = (400, String::new());
    for i in 0..n * n {
        writeln!(text, "v {} {} {}", i % n, (i * 7919) % 13, i / n).unwrap();
    }
    for i in (0..n * n - n).filter(|i| i % n + 1 < n) {
        writeln!(text, "f {} {} {} {}", i + 1, i + 2, i + n + 2, i + n + 1).unwrap();
    }
    place.write("terrain.obj", &text);
    for (limit, what) in [("24MiB", "terrain.obj: "), ("100MiB", "building the scene would need")] {
        render(&place, "terrain.obj", &format!("-q --max-memory {limit}")).exits(2).says(&[what, "--max-memory"]);
    }
    // 318,402 triangles at 512 B and their description.
    render(&place, "terrain.obj", "-q --max-memory 600MiB --method standard").exits(0);
    let held = stats(&place)["peak_memory_bytes"].as_u64().unwrap();
    assert!(held < 600 << 20, "{held}");
}

/// A picture of 16384 × 16384 pixels in 32 KB.
#[test]
fn a_small_file_of_a_large_picture_is_refused() {
    let place = Place::new();
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 16384, 16384);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let row = vec![0; 16384 / 8 * 16384];
    encoder.write_header().unwrap().write_image_data(&row).unwrap();
    assert!(png.len() < 1 << 17, "{}", png.len());
    std::fs::write(place.path("bomb.png"), png).unwrap();
    place.write("bomb.mtl", "newmtl a\nmap_Kd bomb.png\n");
    place.write("bomb.obj", &format!("mtllib bomb.mtl\nusemtl a\n{}", floor_and("")));
    let run = render(&place, "bomb.obj", "--max-memory 256MiB");
    assert!(run.stderr().contains("bomb.png"), "{}", run.stderr());
}
