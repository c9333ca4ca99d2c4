//! Pictures read back, to be compared.

use std::{
    fmt::Display,
    fs::{self, File},
    io::{BufReader, Seek},
    path::Path,
};

use exr::prelude::{AnyChannels, FlatSamples, MetaData, ReadChannels, ReadLayers};
use glam::Vec3;
use lightmesh::Image;

use crate::{
    error::{Error, one_line},
    output::Format,
    srgb::linear_from_srgb,
};

/// The most pixels that are read, 16,384 × 16,384: a damaged header must not take the machine's memory.
const MAX_PIXELS: u64 = 1 << 28;
/// The most bytes of samples, in all layers and channels: four 32-bit channels of the most pixels.
const MAX_SAMPLE_BYTES: u64 = 16 * MAX_PIXELS;
/// The most channels of an EXR, in all layers.
const MAX_CHANNELS: usize = 1024;
/// How many times its length a PNG can hold in samples: deflate makes at most 1032 bytes of one, and the expansion of
/// 1-bit palettes to 8-bit RGBA at most 32 of those.
const PNG_EXPANSION: u64 = 1032 * 32;
/// How many times its length an EXR can hold in samples. Its densest compression, PXR24, deflates (1032 to 1) three of
/// four bytes: 1376, rounded up.
const EXR_EXPANSION: u64 = 2048;

/// What a file's values mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Light of the scene, unbounded (EXR).
    SceneLinear,
    /// Light of a display, in [0, 1], already exposed and tone mapped (PNG).
    DisplayLinear,
}

/// A picture from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear values; a file without colour has it in all three channels.
    pub image: Image,
    /// What they mean.
    pub encoding: Encoding,
}

/// Reads an EXR (channels R G B, with or without A, or Y; any layer order) or a PNG (8 or 16 bits, sRGB). Alpha is left out.
///
/// # Errors
/// If the file is missing, damaged, or has none of those channels; if it says that it has more than 2²⁸ pixels, 1024
/// channels or 4 GiB of samples, or more samples than its length can hold. Nothing is allocated for those.
pub fn read_picture(path: &Path) -> Result<Picture, Error> {
    let format = Format::of(path)?;
    let unreadable = |cause| Error::Read { file: one_line(path.display()), cause };
    // A pipe or a device could keep us waiting for ever.
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(invalid(path, "is not a regular file"));
    }
    let file = BufReader::new(File::open(path).map_err(unreadable)?);
    match format {
        Format::Png => {
            read_png(file, metadata.len(), path).map(|image| Picture { image, encoding: Encoding::DisplayLinear })
        }
        Format::Exr => {
            read_exr(file, metadata.len(), path).map(|image| Picture { image, encoding: Encoding::SceneLinear })
        }
    }
}

fn invalid(path: &Path, what: impl Display) -> Error {
    Error::Picture { file: one_line(path.display()), what: one_line(what) }
}

/// Refuses sizes beyond the limit.
fn check_size(path: &Path, width: u64, height: u64) -> Result<(), Error> {
    if width.saturating_mul(height) <= MAX_PIXELS {
        return Ok(());
    }
    Err(invalid(path, format_args!("its header says {width}x{height}; at most {MAX_PIXELS} pixels are read")))
}

/// Refuses `needed` bytes of samples if they are too many, or more than `expansion` times the file's length.
fn check_samples(path: &Path, needed: u64, length: u64, expansion: u64) -> Result<(), Error> {
    if needed > MAX_SAMPLE_BYTES {
        let what = format_args!("its header announces {needed} bytes of samples; at most {MAX_SAMPLE_BYTES} are read");
        return Err(invalid(path, what));
    }
    if needed > length.saturating_mul(expansion) {
        let what = format_args!(
            "its header announces {needed} bytes of samples, which its {length} bytes cannot hold; is it cut off?"
        );
        return Err(invalid(path, what));
    }
    Ok(())
}

fn read_png(file: BufReader<File>, length: u64, path: &Path) -> Result<Image, Error> {
    let unreadable = |error: png::DecodingError| invalid(path, format_args!("not a readable PNG: {error}"));
    // Read the header alone, then the pixels with palettes and low bit depths expanded.
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(unreadable)?;
    let (width, height) = reader.info().size();
    check_size(path, width.into(), height.into())?;
    let size =
        reader.output_buffer_size().ok_or_else(|| invalid(path, "its header asks for more memory than there is"))?;
    check_samples(path, size as u64, length, PNG_EXPANSION)?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(unreadable)?;

    // One value per channel in [0, 1], then linear light.
    let channels = frame.color_type.samples();
    let encoded: Vec<f32> = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            bytes.chunks_exact(2).map(|b| f32::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0).collect()
        }
        _ => bytes.iter().map(|&b| f32::from(b) / 255.0).collect(),
    };
    let pixels = encoded
        .chunks_exact(channels)
        .map(|c| match channels {
            1 | 2 => Vec3::splat(linear_from_srgb(c[0])),
            _ => Vec3::new(linear_from_srgb(c[0]), linear_from_srgb(c[1]), linear_from_srgb(c[2])),
        })
        .collect();
    Ok(Image { width, height, pixels })
}

fn read_exr(mut file: BufReader<File>, length: u64, path: &Path) -> Result<Image, Error> {
    let unreadable = |error: exr::error::Error| invalid(path, format_args!("not a readable EXR: {error}"));

    // Read the headers alone first.
    let meta = MetaData::read_from_buffered(&mut file, false).map_err(unreadable)?;
    check_exr(path, &meta, length)?;
    file.rewind().map_err(|cause| Error::Read { file: one_line(path.display()), cause })?;

    // Take the first layer that has colour, else the first that has luminance.
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(file)
        .map_err(unreadable)?;
    let layer_with = |names: [&str; 3]| {
        image.layer_data.iter().find_map(|layer| {
            let [r, g, b] = names.map(|name| full_channel(&layer.channel_data, name));
            Some((layer.size, [r?, g?, b?]))
        })
    };
    let (size, [r, g, b]) = layer_with(["R", "G", "B"]).or_else(|| layer_with(["Y", "Y", "Y"])).ok_or_else(|| {
        let names: Vec<String> =
            image.layer_data.iter().flat_map(|l| &l.channel_data.list).map(|c| c.name.to_string()).collect();
        invalid(path, format_args!("has neither channels R, G, B nor Y, but {}", names.join(", ")))
    })?;
    let pixels =
        r.values_as_f32().zip(g.values_as_f32().zip(b.values_as_f32())).map(|(r, (g, b))| Vec3::new(r, g, b)).collect();
    Ok(Image { width: size.x() as u32, height: size.y() as u32, pixels })
}

/// Refuses headers that announce more than is read, or than the file can hold.
fn check_exr(path: &Path, meta: &MetaData, length: u64) -> Result<(), Error> {
    let (mut channels, mut chunks, mut samples) = (0_usize, 0_u64, 0_u64);
    for header in &meta.headers {
        let (width, height) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
        check_size(path, width, height)?;
        let bytes_per_pixel: usize = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample()).sum();
        channels += header.channels.list.len();
        chunks = chunks.saturating_add(header.chunk_count as u64);
        samples = samples.saturating_add((width * height).saturating_mul(bytes_per_pixel as u64));
    }
    if channels > MAX_CHANNELS {
        return Err(invalid(path, format_args!("has {channels} channels; at most {MAX_CHANNELS} are read")));
    }
    // Each chunk has its place in the offset table, 8 bytes, and begins with its coordinate and size, 8 more.
    if chunks.saturating_mul(16) > length {
        let what = format_args!("its header announces {chunks} chunks, which its {length} bytes cannot hold");
        return Err(invalid(path, what));
    }
    check_samples(path, samples, length, EXR_EXPANSION)
}

/// The samples of a channel that has one per pixel.
fn full_channel<'a>(channels: &'a AnyChannels<FlatSamples>, name: &str) -> Option<&'a FlatSamples> {
    channels.list.iter().find(|c| c.name == *name && c.sampling == exr::prelude::Vec2(1, 1)).map(|c| &c.sample_data)
}
