//! The files in `scenes/` are what `make_scenes` writes, and hold what they promise.

#[path = "../examples/make_scenes/scenes/mod.rs"]
mod scenes;

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

type Vec3 = [f64; 3];

/// Triangles of a GLB in the world, read without the crate's own reader.
struct Glb {
    json: Value,
    triangles: Vec<[[f32; 3]; 3]>,
    normals: Vec<[[f32; 3]; 3]>,
}

fn word(bytes: &[u8], offset: usize) -> usize {
    u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap()) as usize
}

fn parse(glb: &[u8]) -> Glb {
    assert_eq!((&glb[..4], word(glb, 4), word(glb, 8)), (&b"glTF"[..], 2, glb.len()));
    let json_length = word(glb, 12);
    let json: Value = serde_json::from_slice(&glb[20..20 + json_length]).unwrap();
    let binary = &glb[28 + json_length..];
    assert_eq!(json["buffers"][0]["byteLength"], binary.len());

    // Every accessor here is tightly packed at the start of its view.
    let bytes_of = |accessor: &Value| {
        let view = &json["bufferViews"]
            [json["accessors"][accessor.as_u64().unwrap() as usize]["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        &binary[start..start + view["byteLength"].as_u64().unwrap() as usize]
    };
    let vectors = |accessor: &Value| -> Vec<[f32; 3]> {
        let floats: Vec<f32> =
            bytes_of(accessor).chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        floats.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
    };
    let (mut triangles, mut normals) = (Vec::new(), Vec::new());
    for node in json["nodes"].as_array().unwrap() {
        let Some(mesh) = node["mesh"].as_u64() else { continue };
        let translation = [0, 1, 2].map(|axis| node["translation"][axis].as_f64().unwrap_or(0.0) as f32);
        for primitive in json["meshes"][mesh as usize]["primitives"].as_array().unwrap() {
            let (p, n) = (vectors(&primitive["attributes"]["POSITION"]), vectors(&primitive["attributes"]["NORMAL"]));
            let indices: Vec<usize> = bytes_of(&primitive["indices"])
                .chunks_exact(2)
                .map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))
                .collect();
            let accessor = |key: &str| primitive[key].as_u64().unwrap() as usize;
            assert_eq!(
                json["accessors"][accessor("indices")]["count"].as_u64().unwrap(),
                3 * (indices.len() as u64 / 3)
            );
            for t in indices.chunks_exact(3) {
                triangles.push([t[0], t[1], t[2]].map(|i| [0, 1, 2].map(|axis| p[i][axis] + translation[axis])));
                normals.push([t[0], t[1], t[2]].map(|i| n[i]));
            }
        }
    }
    Glb { json, triangles, normals }
}

fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn corners(triangle: &[[f32; 3]; 3]) -> [Vec3; 3] {
    triangle.map(|p| p.map(f64::from))
}

/// How often the surface winds around `point`, outward counted positive: Σ Ω / 4π with the solid angles of A. Van
/// Oosterom and J. Strackee, 1983: tan(Ω / 2) = a·(b × c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|).
fn winding_number(triangles: &[[[f32; 3]; 3]], point: Vec3) -> f64 {
    let solid_angle = |triangle| {
        let [a, b, c] = corners(triangle).map(|p| sub(p, point));
        let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
        2.0 * libm::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    };
    triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

fn light_positions(json: &Value) -> Vec<Vec3> {
    let nodes = json["nodes"].as_array().unwrap().iter();
    let lights = nodes.filter(|n| n["extensions"]["KHR_lights_punctual"]["light"].is_u64());
    lights.map(|n| [0, 1, 2].map(|axis| n["translation"][axis].as_f64().unwrap())).collect()
}

#[test]
fn the_files_are_what_the_program_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut total = 0;
    for scene in scenes::all() {
        let path = folder.join(scene.file_name);
        let file = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(
            file == scene.document.to_glb(),
            "{} differs: run `cargo run --release -p lightmesh-io --example make_scenes`",
            scene.file_name
        );
        total += file.len();
    }
    assert!(total < 1_500_000, "{total} bytes");
}

#[test]
fn counts_are_those_of_the_table() {
    let expected = [
        ("room_5.glb", 5014, 5),
        ("room_10.glb", 5014, 10),
        ("room_15.glb", 5014, 15),
        ("room_100.glb", 5014, 100),
        ("room_1000.glb", 5014, 1000),
        ("triangle.glb", 3, 1),
        ("cornell.glb", 34, 1),
        ("window.glb", 2192, 1),
    ];
    let readme = include_str!("../../../scenes/README.md");
    let scenes = scenes::all();
    assert_eq!(scenes.len(), expected.len());
    for (scene, (name, triangles, lights)) in scenes.iter().zip(expected) {
        let glb = parse(&scene.document.to_glb());
        assert_eq!(scene.file_name, name);
        assert_eq!(glb.triangles.len(), triangles, "{name}");
        assert_eq!(scene.document.triangle_count(), triangles, "{name}");
        assert_eq!(light_positions(&glb.json).len(), lights, "{name}");
        assert_eq!(glb.json["cameras"].as_array().unwrap().len(), 1);
        let row = readme.lines().find(|line| line.contains(&format!("`{name}`"))).expect("a row in the table");
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        assert_eq!(cells[2].replace(',', ""), triangles.to_string(), "{row}");
        assert!(cells[3].starts_with(&format!("{lights} ")), "{row}");
    }
}

/// Each triangle has an area, and unit normals on the side from which it is seen counter-clockwise.
#[test]
fn normals_agree_with_the_winding() {
    for scene in scenes::all() {
        let glb = parse(&scene.document.to_glb());
        for (triangle, normals) in glb.triangles.iter().zip(&glb.normals) {
            let [a, b, c] = corners(triangle);
            let geometric = cross(sub(b, a), sub(c, a));
            assert!(dot(geometric, geometric).sqrt() > 1e-7, "{}: {triangle:?}", scene.file_name);
            for n in corners(normals) {
                // f32 rounding of three components: 3 · 2⁻²⁴.
                assert!((dot(n, n) - 1.0).abs() < 4e-7, "{n:?}");
                assert!(dot(n, geometric) > 0.0, "{}: {triangle:?} {n:?}", scene.file_name);
            }
        }
    }
}

/// In the room every edge has as many triangles on one side as on the other, bit for bit: all solids are closed and the
/// shell has no gap. Seen from a light the shell, which faces inward, winds −1 times and each solid around the light
/// would add 1.
#[test]
fn the_room_is_closed_and_its_lights_hang_free() {
    let scenes = scenes::all();
    let rooms = scenes.iter().filter(|scene| scene.file_name.starts_with("room_"));
    for scene in rooms {
        let glb = parse(&scene.document.to_glb());
        let mut balance: BTreeMap<[[u32; 3]; 2], i64> = BTreeMap::new();
        for triangle in &glb.triangles {
            // Adding 0 makes −0 and 0 the same bits.
            let key = triangle.map(|p| p.map(|x| (x + 0.0).to_bits()));
            for (from, to) in [(key[0], key[1]), (key[1], key[2]), (key[2], key[0])] {
                *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        assert!(balance.values().all(|&sum| sum == 0), "{}", scene.file_name);
        for position in light_positions(&glb.json) {
            let winding = winding_number(&glb.triangles, position);
            assert!((winding + 1.0).abs() < 1e-6, "{}: {position:?} {winding}", scene.file_name);
        }
    }
}

/// Σ Rec. 709 luminance of color · intensity is 1,800 cd for every number of lights.
#[test]
fn the_rooms_have_equal_light() {
    let scenes = scenes::all();
    for scene in scenes.iter().filter(|scene| scene.file_name.starts_with("room_")) {
        let json = parse(&scene.document.to_glb()).json;
        let luminance = |light: &Value| {
            let channel = |i: usize| light["color"][i].as_f64().unwrap() * light["intensity"].as_f64().unwrap();
            0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
        };
        let lights = json["extensions"]["KHR_lights_punctual"]["lights"].as_array().unwrap();
        let total: f64 = lights.iter().map(luminance).sum();
        assert!((total - 1800.0).abs() < 1e-3, "{}: {total}", scene.file_name);
    }
}
