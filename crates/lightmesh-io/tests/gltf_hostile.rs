//! Damaged and hostile files: an error or a scene, never a panic, never more memory than allowed.
//!
//! A program of its own, because it counts every allocation. Its one test runs its properties one after the other, so
//! that the count is theirs alone.

#[allow(dead_code, reason = "the other program uses the rest")]
mod common;
#[path = "common/counting.rs"]
mod counting;

use std::io::Cursor;
use std::sync::atomic::Ordering::Relaxed;

use crate::common::{Gltf, U8};
use crate::counting::{LIVING, PEAK};
use image::{DynamicImage, ImageBuffer, ImageFormat};
use lightmesh_io::{LoadOptions, load_gltf_bytes};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde_json::{Value, json};

/// The limit that the reader is given.
const LIMIT: usize = 1 << 20;

/// What it may take besides: the state of the PNG, JPEG and WebP decoders, of which there is one per thread. Empirical.
const DECODERS: usize = 1 << 20;

/// [`check_within`] the usual limit.
fn check(file: &[u8]) -> Result<(), TestCaseError> {
    check_within(LIMIT, file)
}

/// Loads within a limit and checks the peak; the scene, if it is one, holds together.
fn check_within(limit: usize, file: &[u8]) -> Result<(), TestCaseError> {
    let before = LIVING.load(Relaxed);
    PEAK.store(before, Relaxed);
    let options = LoadOptions { max_memory: limit as u64, ..LoadOptions::default() };
    let result = load_gltf_bytes("hostile.glb", file, None, &options);
    let took = PEAK.load(Relaxed) - before;
    prop_assert!(took <= limit + DECODERS, "took {took} bytes for a file of {}", file.len());
    match result {
        Err(error) => {
            let message = error.to_string();
            prop_assert!(message.starts_with("hostile.glb: ") && !message.contains('\n'), "{message}");
        }
        Ok(loaded) => {
            let data = loaded.data;
            for mesh in &data.meshes {
                let n = mesh.positions.len();
                prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n));
                prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
                prop_assert!(mesh.normals.iter().all(|n| n.is_normalized()));
                prop_assert!(mesh.tangents.iter().all(|t| t.truncate().is_normalized()));
                prop_assert!([0, n].contains(&mesh.normals.len()) && [0, n].contains(&mesh.tangents.len()));
                prop_assert!([0, n].contains(&mesh.colors.len()) && mesh.uvs.iter().all(|u| [0, n].contains(&u.len())));
                prop_assert!(mesh.material < data.materials.len());
            }
            prop_assert!(!data.instances.is_empty());
            prop_assert!(data.instances.iter().all(|i| i.mesh < data.meshes.len() && i.world_from_object.is_finite()));
            prop_assert!(data.textures.iter().all(|t| t.image < data.images.len()));
            for material in &data.materials {
                prop_assert!(material.base_color_texture.is_none_or(|t| t.texture < data.textures.len()));
                prop_assert!(material.emission.is_finite());
            }
        }
    }
    Ok(())
}

/// A file with something of everything.
fn rich() -> Gltf {
    let mut gltf = Gltf::triangle();
    let normal = gltf.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let tangent = gltf.floats("VEC4", &[1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0]);
    let color = gltf.accessor(U8, "VEC4", 3, &[9; 12]);
    let indices = gltf.indices(&[0, 1, 2, 2, 1, 0]);
    let minus_x: Vec<u8> = [-1.0_f32, 0.0, 0.0].repeat(2).into_iter().flat_map(f32::to_le_bytes).collect();
    let (at, values) = (gltf.view(&[1, 2]), gltf.view(&minus_x));
    let sparse =
        json!({"count": 2, "indices": {"bufferView": at, "componentType": U8}, "values": {"bufferView": values}});
    gltf.json["accessors"][normal]["sparse"] = sparse;
    gltf.primitive()["indices"] = json!(indices);
    for (name, accessor) in [("NORMAL", normal), ("TANGENT", tangent), ("COLOR_0", color)] {
        gltf.primitive()["attributes"][name] = json!(accessor);
    }
    let strip = json!({"attributes": {"POSITION": 0}, "mode": 5});
    gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(strip);

    // One image of each kind.
    let texels: Vec<u8> = (0..8 * 8 * 3).map(|i| (i * 37 % 251) as u8).collect();
    let image = DynamicImage::ImageRgb8(ImageBuffer::from_raw(8, 8, texels).unwrap());
    for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP] {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        gltf.texture(&bytes.into_inner());
    }
    let mut deep = Cursor::new(Vec::new());
    DynamicImage::ImageRgb16(image.to_rgb16()).write_to(&mut deep, ImageFormat::Png).unwrap();
    gltf.texture(&deep.into_inner());
    gltf.push("samplers", json!({"wrapS": 33071, "magFilter": 9728}));
    gltf.json["textures"][0]["sampler"] = json!(0);
    let transform =
        json!({"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 1, "scale": [2, 2], "texCoord": 1}});
    gltf.material(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0, "extensions": transform},
            "metallicRoughnessTexture": {"index": 1},
        },
        "normalTexture": {"index": 3, "scale": 2}, "emissiveTexture": {"index": 2}, "emissiveFactor": [1, 0, 0],
        "alphaMode": "MASK", "alphaCutoff": 0.5,
        "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_specular": {"specularFactor": 0.5}},
    }));
    gltf.node(json!({"translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 2, 1], "children": [2]}));
    gltf.push("nodes", json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}));
    gltf.light(json!({"type": "spot", "intensity": 5, "range": 9, "spot": {"outerConeAngle": 0.5}}), json!({}));
    gltf.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1}}));
    gltf.node(json!({"camera": 0}));
    gltf
}

/// The `target`-th number, string or other leaf of a JSON tree.
fn leaf<'a>(value: &'a mut Value, target: &mut usize) -> Option<&'a mut Value> {
    match value {
        Value::Array(list) => list.iter_mut().find_map(|v| leaf(v, target)),
        Value::Object(map) => map.iter_mut().find_map(|(_, v)| leaf(v, target)),
        leaf if *target == 0 => Some(leaf),
        _ => {
            *target -= 1;
            None
        }
    }
}

/// How many of them there are.
fn leaves(value: &Value) -> usize {
    match value {
        Value::Array(list) => list.iter().map(leaves).sum(),
        Value::Object(map) => map.values().map(leaves).sum(),
        _ => 1,
    }
}

/// Values that a careless reader trips over.
fn hostile_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        prop::sample::select(vec![
            json!(-1),
            json!(0),
            json!(1),
            json!(2),
            json!(3),
            json!(255),
            json!(65_535),
            json!(4_294_967_295_u64),
            json!(4_294_967_296_u64),
            json!(u64::MAX),
            json!(i64::MIN),
            json!(1e38),
            json!(1e300),
            json!(-1e39),
            json!(1e-45),
            json!(0.5),
            json!(null),
            json!(true),
            json!(""),
            json!("../x"),
            json!("data:,"),
            json!("MAT4"),
            json!("SCALAR"),
            json!([]),
            json!({}),
        ]),
        any::<u32>().prop_map(|n| json!(n)),
        (5120_u32..5127).prop_map(|n| json!(n)),
        (0_u32..12).prop_map(|n| json!(n)),
        any::<f32>().prop_map(|x| json!(x)),
    ]
}

#[test]
fn hostile_files_neither_panic_nor_take_more_memory_than_allowed() {
    let rich = rich();
    let glb = rich.glb();
    check(&glb).unwrap();
    let whole = load_gltf_bytes("hostile.glb", &glb, None, &LoadOptions::default()).unwrap();
    assert_eq!(whole.warnings, [""; 0], "the file is sound before it is damaged");
    let json_length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let config = || Config { cases: 2_000, failure_persistence: None, ..Config::default() };

    // Cut off anywhere.
    for cut in 0..glb.len() {
        check(&glb[..cut]).unwrap();
    }

    // Some bytes changed: anywhere, in the headers, in the JSON, in the binary chunk.
    let headers = prop_oneof![0..20_usize, 20 + json_length..28 + json_length];
    let place = prop_oneof![0..glb.len(), headers, 20..20 + json_length, 28 + json_length..glb.len()];
    let changes = prop::collection::vec((place, any::<u8>()), 1..6);
    TestRunner::new(config())
        .run(&changes, |changes| {
            let mut bytes = glb.clone();
            for (at, byte) in changes {
                bytes[at] = byte;
            }
            check(&bytes)
        })
        .unwrap();

    // Some values of the JSON changed, the file sound otherwise.
    let count = leaves(&rich.json);
    let changes = prop::collection::vec((0..count, hostile_value()), 1..4);
    TestRunner::new(Config { cases: 6_000, ..config() })
        .run(&changes, |changes| {
            let mut gltf = rich.clone();
            for (mut target, value) in changes {
                if let Some(leaf) = leaf(&mut gltf.json, &mut target) {
                    *leaf = value;
                }
            }
            check(&gltf.glb())
        })
        .unwrap();

    // No glTF at all.
    TestRunner::new(config())
        .run(&prop::collection::vec(any::<u8>(), 0..200), |bytes| {
            check(&bytes)?;
            check(&[b"glTF\x02\0\0\0", &bytes[..]].concat())?;
            check(&[b"{\"asset\": {\"version\": \"2.0\"}, ", &bytes[..]].concat())
        })
        .unwrap();

    // Small texts that unfold: deep nesting, many empty things, one thing many times.
    let mut many_instances = Gltf::triangle();
    let primitive = many_instances.primitive().clone();
    many_instances.json["meshes"][0]["primitives"] = json!(vec![primitive; 500]);
    for _ in 0..500 {
        many_instances.node(json!({"mesh": 0, "name": "n"}));
    }
    let mut zeros = Gltf::triangle();
    zeros.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 4_000_000_000_u64});
    for gltf in [many_instances, zeros] {
        check(&gltf.glb()).unwrap();
    }
    for nested in ["[".repeat(200_000), "{\"a\":".repeat(200_000)] {
        check(format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"extras\": {nested}").as_bytes()).unwrap();
        check(format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"nodes\": {nested}").as_bytes()).unwrap();
    }
    // Lists of many small elements, at every limit up to one that suffices for them.
    for (list, element) in [
        ("nodes", json!({})),
        ("scenes", json!({})),
        ("materials", json!({})),
        ("samplers", json!({})),
        ("textures", json!({})),
        ("images", json!({})),
        ("cameras", json!({})),
        ("meshes", json!({"primitives": [{"attributes": {}}]})),
        ("bufferViews", json!({"buffer": 0, "byteLength": 0})),
        ("accessors", json!({"componentType": 0, "count": 0, "type": ""})),
        ("extensionsUsed", json!("")),
        ("animations", json!({})),
    ] {
        let mut gltf = Gltf::triangle();
        for _ in 0..20_000 {
            gltf.push(list, element.clone());
        }
        let file = gltf.glb();
        for limit in (16..28).map(|power| 1 << power) {
            check_within(limit, &file).unwrap();
        }
        let options = LoadOptions { max_memory: 1 << 27, ..LoadOptions::default() };
        assert!(load_gltf_bytes("long.glb", &file, None, &options).is_ok(), "{list}");
    }
}
