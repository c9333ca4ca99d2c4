//! Environment maps: OpenEXR in each of its compressions, Radiance plain and run-length encoded.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Layer, LayerAttributes, LineOrder,
    WritableImage, f16,
};

use super::Seed;

const WIDTH: usize = 16;
const HEIGHT: usize = 8;

pub(crate) fn seeds() -> Vec<Seed> {
    let kinds = [
        ("plain", Compression::Uncompressed, Blocks::ScanLines),
        ("rle", Compression::RLE, Blocks::ScanLines),
        ("zip1", Compression::ZIP1, Blocks::ScanLines),
        ("zip16", Compression::ZIP16, Blocks::ScanLines),
        ("piz", Compression::PIZ, Blocks::ScanLines),
        ("pxr24", Compression::PXR24, Blocks::ScanLines),
        ("b44", Compression::B44, Blocks::ScanLines),
        ("b44a", Compression::B44A, Blocks::ScanLines),
        ("dwaa", Compression::DWAA(None), Blocks::ScanLines),
        ("dwab", Compression::DWAB(None), Blocks::Tiles((8, 8).into())),
        ("tiles", Compression::ZIP16, Blocks::Tiles((8, 8).into())),
    ];
    let mut seeds: Vec<Seed> = kinds
        .into_iter()
        .flat_map(|(name, compression, blocks)| {
            [("", ["R", "G", "B"]), ("_y", ["Y", "A", "Z"])]
                .map(|(end, names)| Seed::new(format!("{name}{end}.exr"), exr(compression, blocks, names)))
        })
        .collect();
    let plain: Vec<u8> = (0..4 * 2).flat_map(|i| [i * 30, 128, 255 - i, 130]).collect();
    seeds.push(Seed::new("plain.hdr", hdr("EXPOSURE=2\n", 4, 2, &plain)));
    // Sixteen columns: a run of twelve and four plain values in red, runs in the others.
    let row = [&[2, 2, 0, 16][..], &[128 + 12, 128, 4, 1, 2, 3, 4], &[128 + 16, 64], &[128 + 16, 0], &[128 + 16, 136]];
    seeds.push(Seed::new("rle.hdr", hdr("COLORCORR=1 2 0.5\n", 16, 8, &row.concat().repeat(8))));
    seeds
}

fn hdr(settings: &str, width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
    let head = format!("#?RADIANCE\n{settings}FORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    [head.as_bytes(), pixels].concat()
}

/// A map of three channels: 16-bit floats, 32-bit floats and whole numbers where they can be packed so.
fn exr(compression: Compression, blocks: Blocks, names: [&str; 3]) -> Vec<u8> {
    let value = |i: usize| (i % 23) as f32 * 0.25;
    let count = 0..WIDTH * HEIGHT;
    let is_dwa = matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
    let samples = [
        FlatSamples::F16(count.clone().map(|i| f16::from_f32(value(i))).collect()),
        FlatSamples::F32(count.clone().map(value).collect()),
        if is_dwa {
            FlatSamples::F32(count.map(value).collect())
        } else {
            FlatSamples::U32(count.map(|i| i as u32).collect())
        },
    ];
    let channels = names.into_iter().zip(samples).map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let layer = Layer::new(
        (WIDTH, HEIGHT),
        LayerAttributes::named("sky"),
        Encoding { compression, blocks, line_order: LineOrder::Increasing },
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("a map in memory");
    bytes.into_inner()
}
