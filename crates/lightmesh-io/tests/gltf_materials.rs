//! Materials, textures and images of glTF files built in memory.

use std::io::Cursor;

use crate::common::{Gltf, assert_says, assert_warns, crc32};
use glam::{Vec2, Vec3};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use lightmesh::{AlphaMode, Filter, Texels, UvTransform, Wrap};
use lightmesh_io::LoadOptions;
use serde_json::{Value, json};

fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Two by one texels: opaque red, and half-transparent (10, 20, 30).
fn small_png() -> Vec<u8> {
    let image = ImageBuffer::from_raw(2, 1, vec![255, 0, 0, 255, 10, 20, 30, 128]).unwrap();
    encode(DynamicImage::ImageRgba8(image), ImageFormat::Png)
}

fn material(description: Value) -> lightmesh::Material {
    let mut gltf = Gltf::triangle();
    gltf.material(description);
    gltf.load().unwrap().data.materials.swap_remove(0)
}

/// A triangle whose base colour is this texture of one image.
fn textured(image: &[u8]) -> Gltf {
    let mut gltf = Gltf::triangle();
    let texture = gltf.texture(image);
    gltf.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    gltf
}

fn rgba8(texels: &Texels) -> &[[u8; 4]] {
    match texels {
        Texels::Rgba8(texels) => texels,
        Texels::Rgba32F(_) => panic!("eight bits were expected"),
    }
}

#[test]
fn defaults_are_those_of_gltf() {
    for material in [material(json!({})), Gltf::triangle().load().unwrap().data.materials.swap_remove(0)] {
        assert_eq!((material.base_color, material.alpha), (Vec3::ONE, 1.0));
        assert_eq!((material.metallic, material.roughness), (1.0, 1.0));
        assert_eq!((material.specular, material.ior, material.transmission), (1.0, 1.5, 0.0));
        assert_eq!((material.emission, material.alpha_mode), (Vec3::ZERO, AlphaMode::Opaque));
        assert!(!material.double_sided && !material.unlit);
    }
}

#[test]
fn every_factor_is_read() {
    let material = material(json!({
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
        },
        "emissiveFactor": [1.0, 0.5, 0.25],
        "alphaMode": "MASK",
        "alphaCutoff": 0.7,
        "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8.0},
            "KHR_materials_unlit": {},
            "KHR_materials_specular": {"specularFactor": 0.8, "specularColorFactor": [1.0, 2.0, 0.5]},
            "KHR_materials_ior": {"ior": 1.33},
            "KHR_materials_transmission": {"transmissionFactor": 0.9},
        },
    }));
    assert_eq!(material.name, "all");
    assert_eq!((material.base_color, material.alpha), (Vec3::new(0.1, 0.2, 0.3), 0.4));
    assert_eq!((material.metallic, material.roughness), (0.5, 0.6));
    assert_eq!(material.emission, Vec3::new(8.0, 4.0, 2.0));
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.7 });
    assert_eq!((material.specular, material.specular_color), (0.8, Vec3::new(1.0, 2.0, 0.5)));
    assert_eq!((material.ior, material.transmission), (1.33, 0.9));
    assert!(material.double_sided && material.unlit);
}

#[test]
fn alpha_modes() {
    assert_eq!(material(json!({"alphaMode": "BLEND"})).alpha_mode, AlphaMode::Blend);
    assert_eq!(material(json!({"alphaMode": "MASK"})).alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
}

#[test]
fn values_that_cannot_be_are_clamped_or_refused() {
    let mut gltf = Gltf::triangle();
    gltf.material(json!({"pbrMetallicRoughness": {"metallicFactor": 2, "roughnessFactor": -1}}));
    let loaded = gltf.load().unwrap();
    assert_eq!((loaded.data.materials[0].metallic, loaded.data.materials[0].roughness), (1.0, 0.0));
    assert_warns(&loaded, &["material 0", "clamped"]);
    assert_eq!(material(json!({"extensions": {"KHR_materials_ior": {"ior": 0}}})).ior, 1e6);
    assert_eq!(material(json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})).ior, 1.0);
    let strength = |value: f64| json!({"KHR_materials_emissive_strength": {"emissiveStrength": value}});
    for value in [-1.0, 1e39] {
        let mut gltf = Gltf::triangle();
        gltf.material(json!({"name": "lamp", "emissiveFactor": [1, 1, 1], "extensions": strength(value)}));
        assert_says(&gltf.refusal(), &["material 0 \"lamp\"", "emission"]);
    }
}

#[test]
fn every_texture_slot_is_read() {
    let mut gltf = Gltf::triangle();
    for _ in 0..7 {
        gltf.texture(&small_png());
    }
    gltf.material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 6}, "metallicRoughnessTexture": {"index": 5}},
        "emissiveTexture": {"index": 4, "texCoord": 1},
        "normalTexture": {"index": 3, "scale": 0.5},
        "extensions": {
            "KHR_materials_specular": {"specularTexture": {"index": 2}, "specularColorTexture": {"index": 1}},
            "KHR_materials_transmission": {"transmissionTexture": {"index": 0}},
        },
    }));
    let data = gltf.load().unwrap().data;
    let m = &data.materials[0];
    // Images come in the file's order, so texture k of the file shows image k.
    let images = m.textures().map(|slot| data.textures[slot.unwrap().texture].image);
    assert_eq!(images, [6, 5, 4, 3, 2, 1, 0]);
    assert_eq!(m.emission_texture.unwrap().uv_set, 1);
    assert_eq!(m.normal_scale, 0.5);
}

#[test]
fn png_jpeg_and_webp_are_decoded_from_the_upper_left() {
    let png = textured(&small_png()).load().unwrap().data;
    assert_eq!((png.images[0].width, png.images[0].height), (2, 1));
    assert_eq!(rgba8(&png.images[0].texels), [[255, 0, 0, 255], [10, 20, 30, 128]]);

    // A flat grey survives JPEG but for its quantisation.
    let grey = ImageBuffer::from_pixel(8, 8, Rgb([90_u8, 90, 90]));
    let jpeg = textured(&encode(grey, ImageFormat::Jpeg)).load().unwrap().data;
    assert!(rgba8(&jpeg.images[0].texels).iter().all(|t| t[0].abs_diff(90) <= 2 && t[3] == 255));

    // Lossless WebP, by the extension.
    let image = ImageBuffer::from_raw(1, 2, vec![1_u8, 2, 3, 4, 5, 6, 7, 8]).unwrap();
    let mut webp = textured(&encode(DynamicImage::ImageRgba8(image), ImageFormat::WebP));
    webp.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    webp.json["textures"][0] = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    assert_eq!(rgba8(&webp.load().unwrap().data.images[0].texels), [[1, 2, 3, 4], [5, 6, 7, 8]]);
}

#[test]
fn an_image_is_decoded_once_for_many_textures_and_uses() {
    let mut gltf = textured(&small_png());
    let second = gltf.push("textures", json!({"source": 0, "sampler": 0}));
    let sampler = json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728});
    gltf.push("samplers", sampler);
    gltf.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = json!({"index": second});
    gltf.json["materials"][0]["normalTexture"] = json!({"index": 0});
    let data = gltf.load().unwrap().data;
    assert_eq!((data.images.len(), data.textures.len()), (1, 3));
    let texture = |slot: Option<lightmesh::TextureRef>| data.textures[slot.unwrap().texture];
    let plain = texture(data.materials[0].base_color_texture);
    assert_eq!((plain.wrap_s, plain.wrap_t, plain.filter), (Wrap::Repeat, Wrap::Repeat, Filter::Bilinear));
    let sampled = texture(data.materials[0].metallic_roughness_texture);
    assert_eq!((sampled.wrap_s, sampled.wrap_t), (Wrap::ClampToEdge, Wrap::MirroredRepeat));
    assert_eq!(sampled.filter, Filter::Nearest);
}

/// Sixteen bits: as colour through IEC 61966-2-1 (half of full scale is linear 0.214 041), as numbers unchanged.
#[test]
fn deep_images_are_floats_for_each_use() {
    let image = ImageBuffer::from_raw(1, 1, vec![0_u16, 32_768, 65_535, 16_384]).unwrap();
    let png = encode(DynamicImage::ImageRgba16(image), ImageFormat::Png);
    let mut gltf = textured(&png);
    gltf.json["materials"][0]["normalTexture"] = json!({"index": 0});
    let data = gltf.load().unwrap().data;
    assert_eq!((data.images.len(), data.textures.len()), (2, 2));
    let texel = |slot: Option<lightmesh::TextureRef>| {
        let image = &data.images[data.textures[slot.unwrap().texture].image];
        match &image.texels {
            Texels::Rgba32F(texels) => texels[0],
            Texels::Rgba8(_) => panic!("floats were expected"),
        }
    };
    let [r, g, b, a] = texel(data.materials[0].base_color_texture);
    assert!(r == 0.0 && (g - 0.214_05).abs() < 1e-5 && b == 1.0 && (a - 0.25).abs() < 1e-5);
    let [r, g, b, a] = texel(data.materials[0].normal_texture);
    assert!(r == 0.0 && (g - 0.5).abs() < 1e-5 && b == 1.0 && (a - 0.25).abs() < 1e-5);
}

#[test]
fn grey_images_are_grey_in_every_channel() {
    let png = encode(ImageBuffer::from_pixel(1, 1, Luma([77_u8])), ImageFormat::Png);
    assert_eq!(rgba8(&textured(&png).load().unwrap().data.images[0].texels), [[77, 77, 77, 255]]);
}

#[test]
fn texture_transforms_and_their_coordinate_set() {
    let mut gltf = textured(&small_png());
    let transform = json!({"offset": [0.1, 0.2], "rotation": 0.5, "scale": [2, 3], "texCoord": 1});
    gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({"KHR_texture_transform": transform});
    let reference = gltf.load().unwrap().data.materials[0].base_color_texture.unwrap();
    assert_eq!(reference.uv_set, 1);
    assert_eq!(reference.transform, UvTransform::new(Vec2::new(0.1, 0.2), 0.5, Vec2::new(2.0, 3.0)));
}

#[test]
fn textures_that_cannot_be_shown_are_left_out_with_a_warning() {
    let mut gltf = textured(&small_png());
    gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(2);
    let loaded = gltf.load().unwrap();
    assert!(loaded.data.materials[0].base_color_texture.is_none());
    assert_warns(&loaded, &["material 0", "coordinate set"]);

    let mut gltf = textured(&small_png());
    gltf.json["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    assert_warns(&gltf.load().unwrap(), &["texture 0", "no PNG"]);

    let mut gltf = textured(&small_png());
    gltf.primitive()["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    assert_warns(&gltf.load().unwrap(), &["mesh", "no texture coordinates"]);
}

#[test]
fn dangling_references_are_refused() {
    for (path, index, words) in [
        ("/meshes/0/primitives/0/material", 5, ["mesh 0, primitive 0", "material 5"]),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", 5, ["material 0", "texture 5"]),
        ("/textures/0/source", 5, ["texture 0", "image 5"]),
        ("/images/0/bufferView", 55, ["image 0", "bufferView 55"]),
    ] {
        let mut gltf = textured(&small_png());
        *gltf.json.pointer_mut(path).unwrap() = json!(index);
        assert_says(&gltf.refusal(), &words);
    }
}

#[test]
fn broken_images_are_left_out_by_name() {
    let mut gltf = textured(b"no image at all");
    gltf.json["images"][0]["name"] = json!("oak");
    gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.1, 0.2, 0.3, 1]);
    let loaded = gltf.load().unwrap();
    assert_warns(&loaded, &["image 0 \"oak\"", "cannot be decoded", "its textures are left out"]);
    let material = &loaded.data.materials[0];
    assert!(material.base_color_texture.is_none() && material.base_color == Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((loaded.data.textures.len(), loaded.data.images.len()), (0, 0));

    // Cut off: its header is sound, its texels are not.
    let png = small_png();
    let loaded = textured(&png[..png.len() - 20]).load().unwrap();
    assert_warns(&loaded, &["image 0", "cannot be decoded"]);
    let mut gltf = textured(&png);
    gltf.json["images"][0] = json!({"name": "empty"});
    assert_warns(&gltf.load().unwrap(), &["image 0 \"empty\"", "neither a uri nor a bufferView"]);
}

/// Of three textures the first and the second use, as colour and as numbers, an image that is broken.
#[test]
fn the_other_textures_keep_their_places() {
    let mut gltf = textured(b"no image at all");
    let sound = gltf.texture(&small_png());
    gltf.json["materials"][0]["normalTexture"] = json!({"index": 0});
    gltf.json["materials"][0]["emissiveTexture"] = json!({"index": sound});
    let loaded = gltf.load().unwrap();
    assert_warns(&loaded, &["image 0", "cannot be decoded"]);
    let material = &loaded.data.materials[0];
    assert!(material.base_color_texture.is_none() && material.normal_texture.is_none());
    assert_eq!(material.emission_texture.unwrap().texture, 0);
    assert_eq!((loaded.data.textures.len(), loaded.data.textures[0].image), (1, 0));
    assert_eq!(rgba8(&loaded.data.images[0].texels)[0], [255, 0, 0, 255]);
}

#[test]
fn absurd_image_sizes_meet_the_limit_before_decoding() {
    // The header says 2³⁰ × 2³⁰ texels; its checksum is made to fit.
    let mut png = small_png();
    png[16..20].copy_from_slice(&0x4000_0000_u32.to_be_bytes());
    png[20..24].copy_from_slice(&0x4000_0000_u32.to_be_bytes());
    let crc = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    assert_says(&textured(&png).refusal(), &["image 0"]);

    let large = encode(ImageBuffer::from_pixel(1000, 1000, Rgba([0_u8; 4])), ImageFormat::Png);
    let options = LoadOptions { max_memory: 3_000_000, ..LoadOptions::default() };
    let message = textured(&large).load_with(&options).unwrap_err().to_string();
    assert_says(&message, &["image 0", "needs 3.8 MiB more"]);
}
