//! Pictures read back, to be compared.

use std::{fs::File, io::BufReader, path::Path};

use glam::Vec3;
use lightmesh::Image;

use crate::{
    budget::Budget, error::Error, exr_file, output::Format, picture_file::PictureFile, srgb::linear_from_srgb,
};

/// The most bytes of samples that a PNG can hold per byte of its length: deflate makes at most 1032 bytes of one, and
/// the expansion of 1-bit palettes to 8-bit RGBA at most 32 of those.
const PNG_EXPANSION: u64 = 1032 * 32;

/// The meaning of a picture's values.
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
    /// The meaning of its values.
    pub encoding: Encoding,
}

/// Reads an EXR (channels R G B, with or without A, or Y; any layer order) or a PNG (8 or 16 bits, sRGB). Alpha is left
/// out.
///
/// # Errors
/// If the file is missing, damaged, or has none of those channels; if it says that it has more than 2²⁸ pixels, 1024
/// channels or 4 GiB of samples, or more samples than its length can hold. Nothing is allocated for those.
pub fn read_picture(path: &Path) -> Result<Picture, Error> {
    let format = Format::of(path)?;
    let (file, reader) = PictureFile::open(path)?;
    match format {
        Format::Png => read_png(&file, reader).map(|image| Picture { image, encoding: Encoding::DisplayLinear }),
        // The limits of `exr_file` bound it.
        Format::Exr => exr_file::read(&file, reader, &mut Budget::new(u64::MAX))
            .map(|image| Picture { image, encoding: Encoding::SceneLinear }),
    }
}

fn read_png(file: &PictureFile, reader: BufReader<File>) -> Result<Image, Error> {
    let unreadable = |error: png::DecodingError| file.invalid(format_args!("not a readable PNG: {error}"));
    // Read the header alone, then the pixels with palettes and low bit depths expanded.
    let mut decoder = png::Decoder::new(reader);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(unreadable)?;
    // The decoder would read past its end.
    if reader.info().palette.as_ref().is_some_and(|palette| !palette.len().is_multiple_of(3)) {
        return Err(file.invalid("its palette ends within a colour"));
    }
    let (width, height) = reader.info().size();
    file.check_size(width.into(), height.into())?;
    let size =
        reader.output_buffer_size().ok_or_else(|| file.invalid("its header asks for more memory than there is"))?;
    file.check_samples(size as u64, PNG_EXPANSION)?;
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
    Ok(Image::new(width, height, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_palette_that_ends_within_a_colour_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        for length in [4, 5, 11] {
            std::fs::write(&path, crate::texture_image::tests::with_palette(&vec![0; length])).expect("a file");
            let message = read_picture(&path).expect_err("cut off").to_string();
            assert!(message.ends_with("a.png: its palette ends within a colour"), "{message}");
        }
    }
}
