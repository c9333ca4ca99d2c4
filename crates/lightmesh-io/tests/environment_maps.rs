//! Environment maps: known texels come back; damaged and hostile files are refused.

use std::io::Cursor;

use crate::common::assert_says;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage,
};
use lightmesh::Texels;
use lightmesh_io::{EnvironmentMap, Error, LoadOptions, read_environment};

const LIMIT: u64 = 1 << 24;

/// Writes `bytes` into a file called `name` and reads it as an environment map.
fn read_within(limit: u64, name: &str, bytes: &[u8]) -> Result<EnvironmentMap, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_environment(&path, limit)
}

fn read(name: &str, bytes: &[u8]) -> Result<EnvironmentMap, Error> {
    read_within(LIMIT, name, bytes)
}

fn refusal(name: &str, bytes: &[u8]) -> String {
    let message = read(name, bytes).map(|_| ()).expect_err("must be refused").to_string();
    assert!(message.contains(name) && !message.contains('\n'), "{message}");
    message
}

fn texels(map: &EnvironmentMap) -> &[[f32; 4]] {
    match &map.map.texels {
        Texels::Rgba32F(texels) => texels,
        Texels::Rgba8(_) => panic!("environment maps are floats"),
    }
}

/// A Radiance picture with these lines in its header, size and bytes of pixels.
fn hdr(settings: &str, width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
    let head = format!("#?RADIANCE\n{settings}FORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    [head.as_bytes(), pixels].concat()
}

/// Radiance's format (Ward, "Real Pixels", Graphics Gems II): c = mantissa · 2^(e − 136). So 128 with e = 129 is 1.
#[test]
fn plain_radiance_texels_come_back() {
    let pixels = [[128, 64, 32, 129], [128, 128, 128, 136], [0, 0, 0, 0], [255, 1, 0, 128]].concat();
    let map = read("sky.HDR", &hdr("", 4, 1, &pixels)).unwrap();
    let expected = [
        [1.0, 0.5, 0.25, 1.0],
        [128.0, 128.0, 128.0, 1.0],
        [0.0, 0.0, 0.0, 1.0],
        [255.0 / 256.0, 1.0 / 256.0, 0.0, 1.0],
    ];
    assert_eq!((map.map.width, map.map.height, texels(&map)), (4, 1, &expected[..]));
    assert_eq!(map.warnings.len(), 1, "4x1 is not twice as wide as high: {:?}", map.warnings);

    // Division by what the header says the values were multiplied by.
    let map = read("sky.hdr", &hdr("EXPOSURE=2\nEXPOSURE=2\nCOLORCORR=1 2 0.5\n", 4, 1, &pixels)).unwrap();
    assert_eq!(texels(&map)[0], [0.25, 0.0625, 0.125, 1.0]);
}

/// Sixteen columns in run-length encoding: a run of twelve and four plain values in red, runs in the others.
#[test]
fn run_length_encoded_radiance_texels_come_back() {
    let row = [&[2, 2, 0, 16][..], &[128 + 12, 128, 4, 1, 2, 3, 4], &[128 + 16, 64], &[128 + 16, 0], &[128 + 16, 136]];
    let map = read("sky.hdr", &hdr("", 16, 8, &row.concat().repeat(8))).unwrap();
    assert_eq!(map.warnings, [""; 0]);
    for row in texels(&map).chunks(16) {
        assert!(row[..12].iter().all(|t| *t == [128.0, 64.0, 0.0, 1.0]));
        assert_eq!([row[12][0], row[13][0], row[14][0], row[15][0]], [1.0, 2.0, 3.0, 4.0]);
    }
}

/// An EXR of these channels.
fn exr(width: usize, height: usize, channels: &[(&str, FlatSamples)]) -> Vec<u8> {
    encoded_exr(Encoding::FAST_LOSSLESS, width, height, channels)
}

fn encoded_exr(encoding: Encoding, width: usize, height: usize, channels: &[(&str, FlatSamples)]) -> Vec<u8> {
    let channels = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
    let layer = Layer::new((width, height), LayerAttributes::named("sky"), encoding, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn floats(values: &[f32]) -> FlatSamples {
    FlatSamples::F32(values.to_vec())
}

#[test]
fn exr_texels_come_back() {
    let (r, g) = ([1.0, 2.5, 1e5, 1e-5], [0.0, 7.0, 8.0, 9.0]);
    let (r2, g2) = (r.repeat(2), g.repeat(2));
    let map = read("sky.exr", &exr(4, 2, &[("R", floats(&r2)), ("G", floats(&g2)), ("B", floats(&r2))])).unwrap();
    let expected: Vec<[f32; 4]> = (0..8).map(|i| [r2[i], g2[i], r2[i], 1.0]).collect();
    assert_eq!((map.map.width, map.map.height, texels(&map)), (4, 2, &expected[..]));
    assert_eq!(map.warnings, [""; 0]);
    let grey = read("sky.exr", &exr(4, 2, &[("Y", floats(&r2))])).unwrap();
    assert_eq!(texels(&grey)[1], [2.5, 2.5, 2.5, 1.0]);
}

/// DWAA, lossy (by less than 2% here, empirical): a chunk says how much is to be unpacked, and is held against its place in the
/// picture.
#[test]
fn lossy_exr_texels_come_back_and_their_chunks_cannot_ask_for_memory() {
    let encoding = Encoding { compression: Compression::DWAA(None), ..Encoding::FAST_LOSSLESS };
    let values: Vec<f32> = (0..32 * 16).map(|i| 1.0 + (i % 32) as f32 / 16.0).collect();
    let channels = ["R", "G", "B"].map(|name| (name, floats(&values)));
    let file = encoded_exr(encoding, 32, 16, &channels);
    let map = read("sky.exr", &file).unwrap();
    assert!(texels(&map).iter().zip(&values).all(|(texel, value)| (texel[0] - value).abs() < 0.02 * value));

    // The only entry of the offset table stands right before its tile: four coordinates, size, and eleven numbers.
    let table = (0..file.len() - 8).find(|&at| file[at..at + 8] == (at as u64 + 8).to_le_bytes()).unwrap();
    let numbers = table + 8 + 5 * 4;
    assert_eq!(file[numbers..numbers + 8], 2_u64.to_le_bytes(), "the version");
    for (number, value) in
        [(1, 1_u64 << 40), (6, 1 << 40), (7, 1 << 40), (8, 1 << 40), (9, 1 << 40), (1, 64 * 64 * 12 + 1)]
    {
        let mut lying = file.clone();
        lying[numbers + 8 * number..][..8].copy_from_slice(&value.to_le_bytes());
        assert_says(&refusal("sky.exr", &lying), &["a chunk announces more than its place in the picture holds"]);
    }

    // Noise does not become shorter, and is stored as it is.
    let noise: Vec<f32> =
        (0..8 * 8_u32).map(|i| f32::from_bits(0x3f80_0000 | i.wrapping_mul(0x9e37_79b9) >> 9)).collect();
    let file = encoded_exr(encoding, 8, 8, &["R", "G", "B"].map(|name| (name, floats(&noise))));
    assert!(read("sky.exr", &file).is_ok());

    // Squares of 8 pixels hold a line of one.
    let line = vec![1.0; 1 << 14];
    let lines = Encoding { compression: Compression::DWAA(None), ..Encoding::SMALL_LOSSLESS };
    let file = encoded_exr(lines, 1 << 14, 1, &["R", "G", "B"].map(|name| (name, floats(&line))));
    assert!(read_within(8 << 20, "sky.exr", &file).is_ok());
    let message = read_within(2 << 20, "sky.exr", &file).map(|_| ()).expect_err("the decoder takes more").to_string();
    assert_says(&message, &["sky.exr", "the decoder", "memory"]);
}

/// What no light can be becomes 0; what was too bright for its file, the brightest that fits it.
#[test]
fn texels_that_are_no_light_are_mended_with_a_warning() {
    let r = [1.0, -2.0, 3.0, f32::INFINITY, 5.0, f32::NEG_INFINITY, f32::NAN, 8.0];
    let g = floats(&[0.5; 8]);
    let map = read("sky.exr", &exr(4, 2, &[("R", floats(&r)), ("G", g.clone()), ("B", g)])).unwrap();
    let reds: Vec<f32> = texels(&map).iter().map(|t| t[0]).collect();
    assert_eq!(reds, [1.0, 0.0, 3.0, 65504.0, 5.0, 0.0, 0.0, 8.0]);
    assert!(texels(&map).iter().all(|t| t[1..] == [0.5, 0.5, 1.0]));
    assert_eq!(map.warnings.len(), 2, "{:?}", map.warnings);
    assert_says(&map.warnings[0], &["sky.exr, texel (1, 0)", "negative or no number", "0", "3 times"]);
    assert_says(&map.warnings[1], &["sky.exr, texel (3, 0)", "infinite", "65504"]);
}

#[test]
fn damaged_files_are_refused_by_name() {
    let row = [&[2, 2, 0, 16][..], &[128 + 16, 128], &[128 + 16, 64], &[128 + 16, 0], &[128 + 16, 136]].concat();
    let hdr = hdr("", 16, 8, &row.repeat(8));
    let grey = floats(&[0.5; 128]);
    let exr = exr(16, 8, &[("R", grey.clone()), ("G", grey.clone()), ("B", grey)]);
    for (name, bytes) in [("a.hdr", &hdr), ("a.exr", &exr)] {
        // Cut off anywhere.
        for length in (0..bytes.len()).step_by(5).chain([bytes.len() - 1]) {
            refusal(name, &bytes[..length]);
        }
        // Altered anywhere: refused or read, never a panic.
        for at in 0..bytes.len() {
            for flip in [0xff, 0x80, 0x01] {
                let mut altered = bytes.clone();
                altered[at] ^= flip;
                let _ = read(name, &altered);
            }
        }
    }
    assert_says(&refusal("a.hdr", &exr), &["does not begin with #?"]);
    assert_says(&refusal("a.exr", &hdr), &["not a readable EXR"]);
    assert_says(&refusal("a.jpg", &hdr), &[".hdr or .exr"]);
    assert_says(&refusal("hdr", &hdr), &[".hdr or .exr"]);
    let folder = tempfile::tempdir().unwrap();
    let missing = read_environment(&folder.path().join("gone.hdr"), LIMIT).unwrap_err().to_string();
    assert_says(&missing, &["gone.hdr", "cannot be read"]);
}

/// Each would take gigabytes, or for ever, if its header were believed.
#[test]
fn absurd_headers_are_refused_before_memory_is_taken() {
    for (width, height, word) in [
        (0, 4, "no pixel"),
        (4, 0, "no pixel"),
        (20_000, 20_000, "at most"),
        (4_000_000_000, 4_000_000_000, "too large"),
        (1, 16_384, "cannot hold"),
        (16_384, 64, "--max-memory"),
    ] {
        assert_says(&refusal("a.hdr", &hdr("", width, height, &[0; 256])), &[word]);
    }
    assert_says(&refusal("a.hdr", &hdr("FORMAT=32-bit_rle_xyze\n", 4, 4, &[0; 64])), &["not a readable"]);
    assert_says(&refusal("a.hdr", b"#?RADIANCE\n\n+Y 4 +X 4\n"), &["Orientation +Y +X"]);
    assert_says(&refusal("a.hdr", &hdr(&"a=b\n".repeat(20_000), 1, 1, &[1, 2, 3, 4])), &["65536"]);
    let grey = floats(&[0.5; 128]);
    let exr = exr(16, 8, &[("R", grey.clone()), ("G", grey.clone()), ("B", grey)]);
    let message = read_within(1000, "a.exr", &exr).unwrap_err().to_string();
    assert_says(&message, &["a.exr", "--max-memory"]);
}

/// Radiance pictures are environments, not textures.
#[test]
fn a_radiance_picture_is_no_texture() {
    let mut gltf = crate::common::Gltf::triangle();
    let texture = gltf.texture(&hdr("", 1, 1, &[128, 128, 128, 129]));
    gltf.material(serde_json::json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    let loaded = gltf.load_with(&LoadOptions::default()).unwrap();
    crate::common::assert_warns(&loaded, &["cannot be decoded", "PNG, JPEG and WebP"]);
}

/// A tile may be larger than its picture: what decoding it takes is counted.
#[test]
fn large_tiles_of_small_pictures_are_counted() {
    let grey = FlatSamples::F32(vec![0.5; 128]);
    let channels = ["B", "G", "R"].map(|name| AnyChannel::new(name, grey.clone()));
    let blocks = exr::prelude::Blocks::Tiles(exr::prelude::Vec2(8, 1 << 20));
    let encoding = Encoding { blocks, ..Encoding::FAST_LOSSLESS };
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = Layer::new((16, 8), LayerAttributes::named("tiles"), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    let message = read_within(1 << 20, "tiles.exr", bytes.get_ref()).unwrap_err().to_string();
    assert_says(&message, &["tiles.exr", "the decoder", "--max-memory"]);
}
