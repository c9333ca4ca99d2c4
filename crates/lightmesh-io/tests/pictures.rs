//! Pictures that are written come back the same.

use std::{io::Cursor, path::Path};

use glam::Vec3;
use lightmesh::{Camera, Image};
use lightmesh_io::{
    Encoding, PictureError,
    output::{Metadata, Precision, tone_map, write_exr, write_png},
    read_picture,
};

/// A gradient with values far above white.
fn image() -> Image {
    let (width, height) = (37, 21);
    let pixels = (0..width * height).map(|i| Vec3::new(0.013 * i as f32, 3.0, 1.0 / (1.0 + i as f32))).collect();
    Image { width, height, pixels }
}

fn metadata() -> Metadata {
    Metadata {
        software: "lightmesh 0".into(),
        method: "mesh".into(),
        scene: "räume/房.glb".into(),
        settings: "{}".into(),
        seconds: 0.5,
        spp: 4,
        camera: Camera::look_at(Vec3::new(3.0, 2.0, 5.0), Vec3::ZERO, 0.7),
    }
}

fn exr(precision: Precision) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    write_exr(&mut bytes, &image(), precision, &metadata()).unwrap();
    bytes.into_inner()
}

/// Writes `bytes` into a file called `name` and reads it as a picture.
fn read_back(name: &str, bytes: &[u8]) -> Result<lightmesh_io::Picture, PictureError> {
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

/// 8 bits of sRGB: half a step of 1/255, steepest where the curve's inverse has slope 2.4 / 1.055.
#[test]
fn png_shows_the_tone_mapped_picture() {
    let mut bytes = Vec::new();
    write_png(&mut bytes, &image(), -1.0, &metadata()).unwrap();
    let picture = read_back("a.png", &bytes).unwrap();
    assert_eq!(picture.encoding, Encoding::DisplayLinear);
    for (a, b) in picture.image.pixels.iter().zip(&image().pixels) {
        assert!((*a - tone_map(*b * 0.5)).abs().max_element() <= 0.5 / 255.0 * 2.4 / 1.055 + 1e-6);
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
