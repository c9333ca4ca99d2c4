//! Pictures that are written come back the same; hostile ones are refused.

use std::{io::Cursor, path::Path};

use crate::common::{assert_says, crc32};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding as ExrEncoding, FlatSamples, Layer as ExrLayer, LayerAttributes, WritableImage,
};
use glam::Vec3;
use lightmesh::{Aov, Camera, Image, Layer};
use lightmesh_io::{
    Encoding, Error,
    output::{Metadata, Precision, tone_map, write_exr, write_png},
    read_picture,
};

/// A gradient with values far above white.
fn image() -> Image {
    let (width, height) = (37, 21);
    let pixels = (0..width * height).map(|i| Vec3::new(0.013 * i as f32, 3.0, 1.0 / (1.0 + i as f32))).collect();
    Image::new(width, height, pixels)
}

fn metadata() -> Metadata {
    Metadata {
        software: "lightmesh 0".into(),
        method: "mesh".into(),
        scene: "räume/房.glb".into(),
        settings: "{}".into(),
        seconds: 0.5,
        estimated_error: Some(0.03),
        spp: 4,
        denoised: None,
        camera: Camera::look_at(Vec3::new(3.0, 2.0, 5.0), Vec3::ZERO, 0.7),
    }
}

fn exr(precision: Precision) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    write_exr(&mut bytes, &image(), &[], precision, &metadata()).unwrap();
    bytes.into_inner()
}

/// Writes `bytes` into a file called `name` and reads it as a picture.
fn read_back(name: &str, bytes: &[u8]) -> Result<lightmesh_io::Picture, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_picture(&path)
}

#[test]
fn exr_keeps_every_bit() {
    let picture = read_back("a.exr", &exr(Precision::Single)).unwrap();
    assert_eq!((picture.image, picture.encoding), (image(), Encoding::SceneLinear));
}

/// Half keeps 11 bits: a relative error of at most 2⁻¹¹ for values above 6e-5.
#[test]
fn half_exr_keeps_eleven_bits() {
    let picture = read_back("a.exr", &exr(Precision::Half)).unwrap();
    for (a, b) in picture.image.pixels.iter().zip(&image().pixels) {
        assert!(((*a - *b).abs()).cmple(*b / 2048.0).all(), "{a} {b}");
    }
}

/// A layer of every kind, each value its own.
fn layers() -> Vec<Layer> {
    let values = |aov: Aov| (0..37 * 21 * aov.channels().len()).map(move |i| 0.25 * i as f32 + aov as u8 as f32);
    let mut layers: Vec<Layer> = Aov::ALL.into_iter().map(|aov| Layer { aov, values: values(aov).collect() }).collect();
    layers[2].values[5] = Aov::FAR_M;
    layers
}

/// By name, as other programs find them; the light stays where readers without layers look for it.
#[test]
fn layers_come_back_by_their_names() {
    for precision in [Precision::Single, Precision::Half] {
        let mut bytes = Cursor::new(Vec::new());
        write_exr(&mut bytes, &image(), &layers(), precision, &metadata()).unwrap();
        let bytes = bytes.into_inner();
        let plain = read_back("a.exr", &exr(precision)).unwrap();
        assert_eq!(read_back("a.exr", &bytes).unwrap(), plain);

        let file = exr::prelude::read_all_flat_layers_from_file;
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.exr"), &bytes).unwrap();
        let read = file(folder.path().join("a.exr")).unwrap();
        assert_eq!(read.layer_data.len(), 1);
        let list = &read.layer_data[0].channel_data.list;
        let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
        assert!(names.is_sorted() && names.len() == 3 + 12 + 3 + 1 + 2, "{names:?}");
        for Layer { aov, values } in layers() {
            let count = aov.channels().len();
            for (first, channel) in aov.channels().iter().enumerate() {
                let name = format!("{}.{channel}", aov.name());
                let found = list.iter().find(|channel| channel.name == *name.as_str()).expect(&name);
                let wanted: Vec<f32> = values.iter().skip(first).step_by(count).copied().collect();
                let got: Vec<f32> = found.sample_data.values_as_f32().collect();
                if precision == Precision::Single || aov == Aov::Depth {
                    assert_eq!(got, wanted, "{name}");
                } else {
                    assert!(got.iter().zip(&wanted).all(|(g, w)| (g - w).abs() <= w / 2048.0), "{name}");
                }
            }
        }
    }
}

/// 8 bits of sRGB, dithered: a step of 1/255, steepest where the curve's inverse has slope 2.4 / 1.055. Unlit pixels are
/// rounded to the nearest, whatever the exposure.
#[test]
fn png_shows_the_tone_mapped_picture() {
    let mut bytes = Vec::new();
    write_png(&mut bytes, &image(), -1.0, &metadata()).unwrap();
    let picture = read_back("a.png", &bytes).unwrap();
    assert_eq!(picture.encoding, Encoding::DisplayLinear);
    for (a, b) in picture.image.pixels.iter().zip(&image().pixels) {
        assert!((*a - tone_map(*b * 0.5)).abs().max_element() <= 1.0 / 255.0 * 2.4 / 1.055 + 1e-6);
    }

    let paint = Vec3::new(1.0, 0.5, 0.1);
    let mut unlit = Image::new(37, 21, vec![paint; 37 * 21]);
    unlit.display.unlit = vec![paint.extend(1.0); 37 * 21];
    for ev in [-9.0, 5.0] {
        let mut bytes = Vec::new();
        write_png(&mut bytes, &unlit, ev, &metadata()).unwrap();
        let image = read_back("a.png", &bytes).unwrap().image;
        let byte = |c: f32| (255.0 * lightmesh_io::output::srgb_from_linear(c)).round() as u8;
        assert!(image.pixels.iter().all(|p| p.to_array().map(byte) == [255, 188, 89]));
    }
}

#[test]
fn equal_pictures_are_equal_png_files() {
    let write = |seconds| {
        let mut bytes = Vec::new();
        write_png(&mut bytes, &image(), 0.0, &Metadata { seconds, ..metadata() }).unwrap();
        bytes
    };
    assert_eq!(write(1.0), write(2.0));
}

/// Truncated and altered files: an error that names the file, or a picture; never a panic.
#[test]
fn damaged_files_are_refused_by_name() {
    let mut png = Vec::new();
    write_png(&mut png, &image(), 0.0, &metadata()).unwrap();
    for (name, bytes) in [("a.png", png), ("a.exr", exr(Precision::Single))] {
        for length in [0, 7, 40, bytes.len() / 2] {
            let message = read_back(name, &bytes[..length]).unwrap_err().to_string();
            assert!(message.contains(name), "{message}");
        }
        for at in (0..bytes.len().min(900)).step_by(7) {
            let mut altered = bytes.clone();
            altered[at] ^= 0xff;
            let _ = read_back(name, &altered);
        }
    }
    let missing = read_picture(Path::new("nowhere/b.png")).unwrap_err().to_string();
    assert!(missing.contains("b.png"), "{missing}");
}

/// An EXR of one pixel whose header names this many channels.
fn exr_of_channels(count: usize) -> Vec<u8> {
    let channel = |i| AnyChannel::new(format!("c{i:04}").as_str(), FlatSamples::F32(vec![1.0]));
    let layer = ExrLayer::new(
        (1, 1),
        LayerAttributes::named("many"),
        ExrEncoding::FAST_LOSSLESS,
        AnyChannels::sort((0..count).map(channel).collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The EXR with another size in its header.
fn resized(mut exr: Vec<u8>, width: i32, height: i32) -> Vec<u8> {
    let name = b"dataWindow\0box2i\0";
    let at = exr.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    for (i, value) in [0, 0, width - 1, height - 1].into_iter().enumerate() {
        exr[at + 4 * i..][..4].copy_from_slice(&value.to_le_bytes());
    }
    exr
}

/// Each would take gigabytes if its header were believed.
#[test]
fn exr_headers_that_announce_too_much_are_refused() {
    let small = exr(Precision::Single);
    for (bytes, word) in [
        (resized(small.clone(), 1 << 29, 1 << 29), "536870912x536870912; at most"),
        (resized(small.clone(), i32::MAX, i32::MAX), "not a readable EXR"),
        (resized(small.clone(), 16_384, 16_384), "chunks, which its"),
        (resized(small, 1 << 20, 32), "bytes of samples, which its"),
        (exr_of_channels(1025), "1025 channels; at most 1024"),
        (resized(exr_of_channels(1024), 1_500, 1_500), "9216000000 bytes of samples; at most"),
    ] {
        assert_says(&read_back("a.exr", &bytes).unwrap_err().to_string(), &["a.exr", word]);
    }
    // Many channels that fit are read, and have no colour.
    let message = read_back("a.exr", &exr_of_channels(1024)).unwrap_err().to_string();
    assert_says(&message, &["neither channels R, G, B nor Y, but c0000, c0001"]);
}

#[test]
fn png_headers_that_announce_too_much_are_refused() {
    let mut png = Vec::new();
    write_png(&mut png, &image(), 0.0, &metadata()).unwrap();
    for (size, word) in [(0x4000_0000_u32, "limits are exceeded"), (16_385, "at most"), (16_384, "which its")] {
        png[16..20].copy_from_slice(&size.to_be_bytes());
        png[20..24].copy_from_slice(&size.to_be_bytes());
        let crc = crc32(&png[12..29]);
        png[29..33].copy_from_slice(&crc.to_be_bytes());
        assert_says(&read_back("a.png", &png).unwrap_err().to_string(), &["a.png", word]);
    }
}
