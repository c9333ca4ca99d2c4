//! Pictures read back, to be compared.

use std::{fs::File, io::BufReader, path::Path};

use exr::prelude::{AnyChannels, FlatSamples, MetaData, ReadChannels, ReadLayers};
use glam::Vec3;
use lightmesh::Image;

use crate::{
    PictureError,
    output::{Format, linear_from_srgb},
};

/// The most pixels that are read, 16,384 × 16,384: a damaged header must not take the machine's memory.
const MAX_PIXELS: u64 = 1 << 28;

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
/// If the file is missing, damaged, larger than 2²⁸ pixels, or has none of those channels.
pub fn read_picture(path: &Path) -> Result<Picture, PictureError> {
    let format = Format::of(path)?;
    let file = File::open(path).map_err(|source| PictureError::Io { path: path.to_owned(), source })?;
    let file = BufReader::new(file);
    match format {
        Format::Png => read_png(file, path).map(|image| Picture { image, encoding: Encoding::DisplayLinear }),
        Format::Exr => read_exr(file, path).map(|image| Picture { image, encoding: Encoding::SceneLinear }),
    }
}

/// Refuses sizes beyond the limit.
fn check_size(path: &Path, width: u64, height: u64) -> Result<(), PictureError> {
    if width.saturating_mul(height) <= MAX_PIXELS {
        return Ok(());
    }
    Err(PictureError::Invalid {
        path: path.to_owned(),
        what: format!("its header says {width}x{height}; at most {MAX_PIXELS} pixels are read"),
    })
}

fn read_png(file: BufReader<File>, path: &Path) -> Result<Image, PictureError> {
    let invalid = |error: png::DecodingError| PictureError::Invalid {
        path: path.to_owned(),
        what: format!("not a readable PNG: {error}"),
    };
    // Read the header alone, then the pixels with palettes and low bit depths expanded.
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(invalid)?;
    let (width, height) = reader.info().size();
    check_size(path, width.into(), height.into())?;
    let size = reader.output_buffer_size().ok_or_else(|| PictureError::Invalid {
        path: path.to_owned(),
        what: "its header asks for more memory than there is".to_owned(),
    })?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(invalid)?;

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

fn read_exr(mut file: BufReader<File>, path: &Path) -> Result<Image, PictureError> {
    use std::io::Seek;
    let invalid = |what: String| PictureError::Invalid { path: path.to_owned(), what };
    let unreadable = |error: exr::error::Error| invalid(format!("not a readable EXR: {error}"));

    // Read the headers alone first.
    let meta = MetaData::read_from_buffered(&mut file, false).map_err(unreadable)?;
    for header in &meta.headers {
        check_size(path, header.layer_size.x() as u64, header.layer_size.y() as u64)?;
    }
    file.rewind().map_err(|source| PictureError::Io { path: path.to_owned(), source })?;

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
        invalid(format!("has neither channels R, G, B nor Y, but {}", names.join(", ")))
    })?;
    let pixels =
        r.values_as_f32().zip(g.values_as_f32().zip(b.values_as_f32())).map(|(r, (g, b))| Vec3::new(r, g, b)).collect();
    Ok(Image { width: size.x() as u32, height: size.y() as u32, pixels })
}

/// The samples of a channel that has one per pixel.
fn full_channel<'a>(channels: &'a AnyChannels<FlatSamples>, name: &str) -> Option<&'a FlatSamples> {
    channels.list.iter().find(|c| c.name == *name && c.sampling == exr::prelude::Vec2(1, 1)).map(|c| &c.sample_data)
}
