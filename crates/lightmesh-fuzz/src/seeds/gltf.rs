//! glTF files: a square, and what can be added to it.

use serde_json::json;

use super::gltf_document::{Document, F32, U16};
use super::{Seed, texture};

/// Adds something to the square.
type Addition = fn(&mut Document);

pub(crate) fn seeds() -> Vec<Seed> {
    let square = Document::square();
    let mut seeds = vec![Seed::new("square.gltf", square.text()), Seed::new("square.glb", square.glb())];
    let kinds: [(&str, Addition); 9] = [
        ("attributes", attributes),
        ("sparse", sparse),
        ("modes", modes),
        ("textured", textured),
        ("glass", glass),
        ("lights", lights),
        ("nodes", nodes),
        ("sky", sky),
        ("emitter", emitter),
    ];
    for (name, add) in kinds {
        let mut document = Document::square();
        add(&mut document);
        let (file, bytes) = if name == "nodes" {
            (format!("{name}.gltf"), document.text())
        } else {
            (format!("{name}.glb"), document.glb())
        };
        seeds.push(Seed::new(file, bytes));
    }
    seeds
}

/// A square with this picture on it.
pub(crate) fn with_texture(picture: &[u8]) -> Vec<u8> {
    let mut document = Document::square();
    document.uvs();
    let texture = document.texture(picture);
    document.material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}, "metallicRoughnessTexture": {"index": texture}},
        "normalTexture": {"index": texture},
        "alphaMode": "BLEND",
    }));
    document.glb()
}

/// Normals, tangents, colours, two sets of texture coordinates, and indices of 16 bits.
fn attributes(document: &mut Document) {
    let normal = document.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let tangent = document.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
    let color = document.accessor(U16, "VEC4", 4, &[255; 32]);
    document.json["accessors"][color]["normalized"] = json!(true);
    document.uvs();
    let uvs = document.accessor(U16, "VEC2", 4, &[7; 16]);
    document.json["accessors"][uvs]["normalized"] = json!(true);
    let indices = document.accessor(U16, "SCALAR", 6, &[0, 0, 1, 0, 2, 0, 0, 0, 2, 0, 3, 0]);
    for (name, accessor) in [("NORMAL", normal), ("TANGENT", tangent), ("COLOR_0", color), ("TEXCOORD_1", uvs)] {
        document.attribute(name, accessor);
    }
    document.primitive()["indices"] = json!(indices);
    // Positions and normals in one view, in turn.
    let both: Vec<u8> = [-1.0_f32, 0.0, 0.0, 0.0, 0.0, 1.0].repeat(4).iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = document.view(&both);
    document.json["bufferViews"][view]["byteStride"] = json!(24);
    let in_turn = json!({"bufferView": view, "byteOffset": 12, "componentType": F32, "count": 4, "type": "VEC3"});
    let normal = document.push("accessors", in_turn);
    document.attribute("NORMAL", normal);
}

/// Positions of which two are given elsewhere.
fn sparse(document: &mut Document) {
    let at = document.view(&[1, 2]);
    let values: Vec<u8> = [1.0_f32, -1.0, 0.5].repeat(2).iter().flat_map(|x| x.to_le_bytes()).collect();
    let values = document.view(&values);
    document.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": at, "componentType": 5121},
        "values": {"bufferView": values},
    });
}

/// Strips, fans, lines and points; a morph target.
fn modes(document: &mut Document) {
    for mode in [5, 6, 1, 0] {
        let part = json!({"attributes": {"POSITION": 0}, "mode": mode, "targets": [{"POSITION": 0}]});
        document.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(part);
    }
    document.json["meshes"][0]["weights"] = json!([0.5]);
}

/// A texture that is shifted and turned, in several places of a material.
fn textured(document: &mut Document) {
    document.uvs();
    let texture = document.texture(&texture::small_png());
    document.push("samplers", json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}));
    document.json["textures"][texture]["sampler"] = json!(0);
    let transform = json!({"KHR_texture_transform": {"offset": [0.5, 0], "rotation": 1, "scale": [2, 2]}});
    document.material(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": texture, "extensions": transform},
            "metallicRoughnessTexture": {"index": texture}, "metallicFactor": 0.5,
        },
        "normalTexture": {"index": texture, "scale": 2}, "emissiveTexture": {"index": texture}, "emissiveFactor": [1, 0, 0],
        "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
        "extensions": {"KHR_materials_specular": {"specularTexture": {"index": texture}, "specularFactor": 0.5}},
    }));
}

/// Clear glass, and a mirror beside it.
fn glass(document: &mut Document) {
    document.material(json!({
        "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0, "baseColorFactor": [1, 0.9, 0.8, 0.5]},
        "alphaMode": "BLEND",
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_volume": {"thicknessFactor": 1},
        },
    }));
    let mirror =
        document.push("materials", json!({"pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 1}}));
    let part = json!({"attributes": {"POSITION": 0}, "material": mirror, "mode": 5});
    document.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(part);
}

/// Lights of every kind.
fn lights(document: &mut Document) {
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        {"type": "spot", "intensity": 5, "range": 9, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}},
        {"type": "directional", "intensity": 2, "color": [1, 0.5, 0.25], "name": "sun"},
        {"type": "point", "intensity": 50, "range": 0.5},
    ]);
    for light in 1..3 {
        let node = document.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": light}}}));
        document.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(node));
    }
}

/// Nodes below nodes, transforms of both kinds, one mesh in several places, both kinds of cameras, two scenes.
fn nodes(document: &mut Document) {
    document.push("nodes", json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1]}));
    document.push(
        "nodes",
        json!({"children": [3], "rotation": [0, 0.6, 0, 0.8], "scale": [-1, 2, 1], "translation": [1e3, 0, 0]}),
    );
    document.push("cameras", json!({"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1}}));
    document.push("nodes", json!({"camera": 1, "translation": [0, 0, 3], "name": "front"}));
    document.json["scenes"] = json!([{"nodes": [0, 1, 2, 4, 5], "name": "all"}, {"nodes": [0]}]);
}

/// An environment of coefficients and faces.
fn sky(document: &mut Document) {
    let image = document.texture(&texture::small_png());
    document.json["extensions"]["EXT_lights_image_based"] = json!({"lights": [{
        "intensity": 2, "rotation": [0, 0.6, 0, 0.8],
        "irradianceCoefficients": vec![json!([0.5, 0.25, 0.1]); 9],
        "specularImages": [[image, image, image, image, image, image]], "specularImageSize": 2,
    }]});
    document.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
}

/// A surface that shines, and one without light.
fn emitter(document: &mut Document) {
    document.material(json!({
        "emissiveFactor": [1, 0.5, 0.25],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 1000}},
    }));
    let unlit = document.push("materials", json!({"extensions": {"KHR_materials_unlit": {}}}));
    let part = json!({"attributes": {"POSITION": 0}, "material": unlit});
    document.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(part);
}
