//! Files around a glTF: URIs, folders, containers, versions, extensions.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{Gltf, assert_says, assert_warns};
use base64::Engine;
use lightmesh_io::{Error, LoadOptions, load, load_gltf_bytes};
use serde_json::json;

/// A folder of its own for one test; removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lightmesh-{test}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(path.join("scene/textures")).unwrap();
        Self(path)
    }

    /// Writes a file; its path.
    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The triangle as text whose buffer is at `uri`.
fn text(uri: &str) -> (String, Vec<u8>) {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0]["uri"] = json!(uri);
    (gltf.json.to_string(), gltf.binary)
}

fn refusal(path: &Path) -> String {
    let message = load(path, &LoadOptions::default()).map(|_| ()).expect_err("must be refused").to_string();
    assert!(message.contains(path.file_name().unwrap().to_str().unwrap()) && !message.contains('\n'), "{message}");
    message
}

#[test]
fn buffers_beside_the_scene_and_in_folders_under_it() {
    let folder = Folder::new("beside");
    let cases = [
        ("data.bin", "data.bin"),
        ("./textures/a%20b.bin", "textures/a b.bin"),
        ("textures\\c.bin", "textures/c.bin"),
        ("textures/../d.bin", "d.bin"),
        ("%C3%A9.bin", "é.bin"),
    ];
    for (uri, name) in cases {
        let (json, binary) = text(uri);
        folder.write(&format!("scene/{name}"), binary);
        let path = folder.write("scene/scene.gltf", json);
        assert_eq!(load(&path, &LoadOptions::default()).unwrap().data.meshes.len(), 1, "{uri}");
    }
}

#[test]
fn data_uris_with_and_without_padding_and_base64() {
    let (_, binary) = text("");
    let encoded = base64::engine::general_purpose::STANDARD.encode([&binary[..], &[0]].concat());
    assert!(encoded.ends_with('='));
    let percent: String = binary.iter().map(|byte| format!("%{byte:02x}")).collect();
    for uri in [
        format!("data:application/octet-stream;base64,{encoded}"),
        format!("data:;base64,{}", encoded.trim_end_matches('=')),
        format!("DATA:application/gltf-buffer;base64,{encoded}"),
        format!("data:,{percent}"),
    ] {
        let (json, _) = text(&uri);
        load_gltf_bytes("a.gltf", json.as_bytes(), None, &LoadOptions::default()).unwrap();
    }
    for uri in ["data:;base64,!!!!", "data:nothing"] {
        let (json, _) = text(uri);
        let message =
            load_gltf_bytes("a.gltf", json.as_bytes(), None, &LoadOptions::default()).unwrap_err().to_string();
        assert_says(&message, &["a.gltf: buffer 0: uri"]);
    }
}

#[test]
fn uris_that_leave_the_folder_are_refused_unless_allowed() {
    let folder = Folder::new("outside");
    let (_, binary) = text("");
    let outside = folder.write("secret.bin", binary);
    for uri in ["../secret.bin", "textures/../../secret.bin", "%2e%2e/secret.bin", outside.to_str().unwrap()] {
        let path = folder.write("scene/scene.gltf", text(uri).0);
        assert_says(&refusal(&path), &["buffer 0", "uri", "leaves the scene's folder", "--allow-outside"]);
        load(&path, &LoadOptions { allow_outside: true, ..LoadOptions::default() }).unwrap();
    }
    // What does not exist outside is refused in the same words: the answer tells nothing about other folders.
    let path = folder.write("scene/scene.gltf", text("../no_such_secret.bin").0);
    assert_says(&refusal(&path), &["leaves the scene's folder"]);
}

#[cfg(unix)]
#[test]
fn symbolic_links_out_of_the_folder_are_followed_only_if_allowed() {
    let folder = Folder::new("links");
    let (json, binary) = text("link.bin");
    folder.write("secret.bin", &binary);
    std::os::unix::fs::symlink(folder.0.join("secret.bin"), folder.0.join("scene/link.bin")).unwrap();
    let path = folder.write("scene/scene.gltf", json);
    assert_says(&refusal(&path), &["uri", "leaves the scene's folder"]);
    load(&path, &LoadOptions { allow_outside: true, ..LoadOptions::default() }).unwrap();
    // A link that stays inside is fine, and so is a scene that is itself reached through a link.
    fs::remove_file(folder.0.join("scene/link.bin")).unwrap();
    folder.write("scene/real.bin", &binary);
    std::os::unix::fs::symlink("real.bin", folder.0.join("scene/link.bin")).unwrap();
    std::os::unix::fs::symlink(folder.0.join("scene"), folder.0.join("alias")).unwrap();
    load(&folder.0.join("alias/scene.gltf"), &LoadOptions::default()).unwrap();
}

#[test]
fn networks_schemes_and_missing_files_are_refused_even_if_outside_is_allowed() {
    let folder = Folder::new("schemes");
    let options = LoadOptions { allow_outside: true, ..LoadOptions::default() };
    for uri in ["http://example.org/a.bin", "file:///etc/passwd", "C:/a.bin", ""] {
        let path = folder.write("scene/scene.gltf", text(uri).0);
        assert_says(&load(&path, &options).unwrap_err().to_string(), &["buffer 0", "uri"]);
    }
    let path = folder.write("scene/scene.gltf", text("gone.bin").0);
    assert_says(&load(&path, &options).unwrap_err().to_string(), &["buffer 0", "gone.bin", "cannot be read"]);
    let path = folder.write("scene/scene.gltf", text("textures").0);
    assert_says(&load(&path, &options).unwrap_err().to_string(), &["buffer 0", "not a regular file"]);
    let (json, _) = text("a.bin");
    let message = load_gltf_bytes("a.gltf", json.as_bytes(), None, &options).unwrap_err().to_string();
    assert_says(&message, &["not read from a folder"]);
}

/// The textured triangle as text whose only image is at `uri`; its buffer is in the text.
fn text_with_image(uri: &str) -> String {
    let mut gltf = Gltf::triangle();
    let image = gltf.push("images", json!({"uri": uri, "name": "oak"}));
    let texture = gltf.push("textures", json!({"source": image}));
    gltf.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    let encoded = base64::engine::general_purpose::STANDARD.encode(&gltf.binary);
    gltf.json["buffers"][0]["uri"] = json!(format!("data:;base64,{encoded}"));
    gltf.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    gltf.json["materials"][0]["emissiveTexture"] = json!({"index": 0});
    gltf.json.to_string()
}

#[test]
fn a_missing_image_is_left_out_but_none_is_fetched_from_outside() {
    let folder = Folder::new("images");
    for (uri, words) in [
        ("textures/gone.png", ["image 0 \"oak\"", "gone.png", "cannot be read"]),
        ("textures", ["image 0 \"oak\"", "textures", "not a regular file"]),
        ("data:image/png;base64,!!", ["image 0 \"oak\"", "base64", "cannot be read"]),
        ("data:image/png", ["image 0 \"oak\"", "comma", "cannot be read"]),
        ("data:image/png;base64,AAAA", ["image 0 \"oak\"", "cannot be decoded", "PNG, JPEG and WebP"]),
    ] {
        let path = folder.write("scene/scene.gltf", text_with_image(uri));
        let loaded = load(&path, &LoadOptions::default()).unwrap();
        let material = &loaded.data.materials[0];
        assert!(material.base_color_texture.is_none() && material.emission_texture.is_none());
        assert_eq!(material.emission, glam::Vec3::ZERO, "what a lost picture emits is unknown");
        assert_warns(&loaded, &words);
    }
    for uri in ["../gone.png", "/gone.png", "http://example.org/a.png", "C:/a.png"] {
        let path = folder.write("scene/scene.gltf", text_with_image(uri));
        assert_says(&refusal(&path), &["image 0 \"oak\": uri"]);
    }
}

#[test]
fn files_larger_than_the_limit_are_not_read() {
    let folder = Folder::new("limit");
    folder.write("scene/big.bin", vec![0; 100_000]);
    let path = folder.write("scene/scene.gltf", text("big.bin").0);
    let options = LoadOptions { max_memory: 50_000, ..LoadOptions::default() };
    let message = load(&path, &options).unwrap_err().to_string();
    assert_says(&message, &["buffer 0", "needs 97.7 KiB more", "limit of 48.8 KiB"]);
    let options = LoadOptions { max_memory: 10, ..LoadOptions::default() };
    assert_says(&load(&path, &options).unwrap_err().to_string(), &["the file", "limit of 10 B"]);
}

#[test]
fn buffers_and_views_must_hold_what_they_say() {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0]["byteLength"] = json!(100);
    assert_says(&gltf.refusal(), &["buffer 0", "100", "36"]);
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["byteLength"] = json!(40);
    assert_says(&gltf.refusal(), &["bufferView 0", "buffer 0"]);
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["buffer"] = json!(1);
    assert_says(&gltf.refusal(), &["bufferView 0", "buffer 1"]);
    let mut gltf = Gltf::triangle();
    gltf.push("buffers", json!({"byteLength": 36, "name": "lost"}));
    gltf.json["bufferViews"][0]["buffer"] = json!(1);
    assert_says(&gltf.refusal(), &["buffer 1 \"lost\"", "uri"]);
}

#[test]
fn the_content_decides_where_the_name_does_not() {
    let folder = Folder::new("names");
    let glb = Gltf::triangle().glb();
    for name in ["scene.gltf", "scene.GLB", "scene.vrm", "nameless"] {
        load(&folder.write(name, &glb), &LoadOptions::default()).unwrap();
    }
    for name in ["scene.fbx", "readme"] {
        let error = load(&folder.write(name, "text"), &LoadOptions::default()).unwrap_err();
        assert!(matches!(error, Error::UnknownFormat { .. }));
        assert_says(&error.to_string(), &[name, "lightmesh reads glTF 2.0"]);
    }
    assert_says(&refusal(&folder.0.join("absent.glb")), &["cannot be read"]);
    assert_says(&refusal(&folder.write("text.glb", "hello")), &["not a glTF file"]);
    assert_says(&refusal(&folder.write("list.gltf", "[1, 2]")), &["not a glTF file"]);
    assert_says(&refusal(&folder.write("cut.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [")), &["JSON"]);
    assert_says(&refusal(&folder.write("more.gltf", "{\"asset\": {\"version\": \"2.0\"}} x")), &["JSON"]);
}

#[test]
fn unread_extensions_are_an_error_if_required_and_a_warning_if_not() {
    for (name, advice) in [
        ("KHR_draco_mesh_compression", "gltf-transform copy"),
        ("EXT_meshopt_compression", "gltf-transform copy"),
        ("KHR_texture_basisu", "gltf-transform ktxdecompress"),
        ("ACME_new\nline", "Blender"),
    ] {
        let mut gltf = Gltf::triangle();
        gltf.json["extensionsUsed"] = json!([name]);
        assert_warns(&gltf.load().unwrap(), &[&name.replace('\n', "\\n")]);
        gltf.json["extensionsRequired"] = json!([name]);
        assert_says(&gltf.refusal(), &[&name.replace('\n', "\\n"), advice]);
    }
    let mut gltf = Gltf::triangle();
    let harmless = ["KHR_xmp_json_ld", "KHR_materials_variants", "KHR_animation_pointer"];
    let read = ["KHR_lights_punctual", "KHR_mesh_quantization", "EXT_texture_webp", "KHR_materials_unlit"];
    gltf.json["extensionsUsed"] = json!([harmless.as_slice(), &read].concat());
    gltf.json["extensionsRequired"] = json!([harmless.as_slice(), &read].concat());
    assert_eq!(gltf.load().unwrap().warnings, [""; 0]);
}

/// What no surface of the scene needs is not worth a word; what three surfaces need is worth one.
#[test]
fn material_extensions_are_told_once_and_only_where_they_show() {
    let metalrough = "gltf-transform metalrough";
    let take_out = "take its name out of the file's extensionsRequired";
    for (name, shows, does_not, advice) in [
        ("KHR_materials_pbrSpecularGlossiness", json!({}), None, metalrough),
        ("KHR_materials_clearcoat", json!({"clearcoatFactor": 1}), Some(json!({"clearcoatFactor": 0})), take_out),
        ("KHR_materials_sheen", json!({"sheenColorFactor": [0, 0, 1]}), Some(json!({})), take_out),
        ("KHR_materials_volume", json!({"attenuationDistance": 2}), Some(json!({"thicknessFactor": 1})), take_out),
        ("KHR_materials_iridescence", json!({"iridescenceFactor": 0.1}), Some(json!({"iridescenceIor": 2})), take_out),
        ("KHR_materials_anisotropy", json!({"anisotropyStrength": -0.5}), Some(json!({})), take_out),
        ("KHR_materials_dispersion", json!({"dispersion": 1}), Some(json!({"dispersion": 0.0})), take_out),
        ("KHR_materials_diffuse_transmission", json!({"diffuseTransmissionFactor": 1}), Some(json!(null)), take_out),
    ] {
        // Listed, but on no surface.
        let mut gltf = Gltf::triangle();
        gltf.json["extensionsUsed"] = json!([name]);
        assert_eq!(gltf.load().unwrap().warnings, [""; 0], "{name}");
        // On a surface where it changes nothing, then on three where it does.
        if let Some(neutral) = does_not {
            gltf.material(json!({"extensions": {name: neutral}}));
            assert_eq!(gltf.load().unwrap().warnings, [""; 0], "{name}");
        }
        for _ in 0..3 {
            let position = gltf.floats("VEC3", &crate::common::TRIANGLE);
            let material = gltf.push("materials", json!({"extensions": {name: shows}}));
            let mesh = gltf.mesh(json!({"attributes": {"POSITION": position}, "material": material}));
            gltf.node(json!({"mesh": mesh}));
        }
        assert_warns(&gltf.load().unwrap(), &["material ", name, "is not read", "3 times in the file"]);
        gltf.json["extensionsRequired"] = json!([name]);
        assert_says(&gltf.refusal(), &[name, advice]);
    }
}

#[test]
fn versions_other_than_two_are_refused() {
    for (asset, words) in [
        (json!({"version": "1.0"}), ["asset.version", "1.0"]),
        (json!({"version": "3.0"}), ["asset.version", "3.0"]),
        (json!({"version": "2.1", "minVersion": "2.1"}), ["asset.minVersion", "2.1"]),
        (json!({}), ["JSON, asset", "version"]),
    ] {
        let mut gltf = Gltf::triangle();
        gltf.json["asset"] = asset;
        assert_says(&gltf.refusal(), &words);
    }
    let mut glb = Gltf::triangle().glb();
    glb[4] = 1;
    let message = load_gltf_bytes("old.glb", &glb, None, &LoadOptions::default()).unwrap_err().to_string();
    assert_says(&message, &["old.glb: GLB header: version 1"]);
}

#[test]
fn names_cannot_break_or_flood_a_message() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["name"] = json!(format!("a\nb{}", "x".repeat(100_000)));
    gltf.json["nodes"][0]["mesh"] = json!(4);
    gltf.json["nodes"][0]["children"] = json!([9]);
    assert!(gltf.refusal().len() < 1_000);
}

/// What must not be written to: also a file that is missing, or that nothing uses, but none outside of the folder.
#[test]
fn the_files_that_a_scene_names_are_known() {
    let folder = Folder::new("named");
    let (json, binary) = text("./textures/a%20b.bin");
    let images = r#""images": [{"uri": "oak.png"}, {"uri": "../outside.png"}, {"uri": "data:,x"}], "buffers""#;
    let path = folder.write("scene/a.gltf", json.replace(r#""buffers""#, images));
    folder.write("scene/textures/a b.bin", binary);
    let named = |options: &LoadOptions| load(&path, options).unwrap().files;
    let scene = folder.0.join("scene");
    let inside = [path.clone(), scene.join("./textures/a b.bin"), scene.join("oak.png")];
    assert_eq!(named(&LoadOptions::default()), inside);
    let all = named(&LoadOptions { allow_outside: true, ..LoadOptions::default() });
    assert_eq!(all, [inside.as_slice(), &[scene.join("../outside.png")]].concat());
}
