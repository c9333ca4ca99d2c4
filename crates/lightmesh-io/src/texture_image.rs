//! The image formats of textures.

use std::io::Cursor;

use image::error::{DecodingError, ImageFormatHint, UnsupportedError};
use image::{ImageError, ImageFormat, ImageReader, ImageResult, Limits};

/// A reader of a PNG, JPEG or WebP image that allocates at most `limit` bytes.
///
/// # Errors
/// For any other format, also those that the `image` crate was built with for other uses; for a palette of a PNG that ends
/// within a colour, as png 0.18.1 reads past its end and panics.
pub(crate) fn reader(bytes: &[u8], limit: u64) -> ImageResult<ImageReader<Cursor<&[u8]>>> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    match reader.format() {
        Some(ImageFormat::Png) if !has_whole_palette(bytes) => {
            let hint = ImageFormatHint::Exact(ImageFormat::Png);
            return Err(ImageError::Decoding(DecodingError::new(hint, "its palette ends within a colour")));
        }
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) | None => {}
        Some(other) => {
            let hint = ImageFormatHint::Exact(other);
            return Err(ImageError::Unsupported(UnsupportedError::from(hint)));
        }
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(limit);
    reader.limits(limits);
    Ok(reader)
}

/// Returns whether every palette of a PNG has three bytes for each colour.
fn has_whole_palette(png: &[u8]) -> bool {
    // Each chunk is its length, kind, data and checksum, after a magic of eight bytes.
    let mut rest = png.get(8..).unwrap_or_default();
    while let (Some(length), Some(kind)) = (rest.first_chunk(), rest.get(4..8)) {
        let length = u32::from_be_bytes(*length) as usize;
        if kind == b"PLTE" && !length.is_multiple_of(3) {
            return false;
        }
        rest = length.checked_add(12).and_then(|end| rest.get(end..)).unwrap_or_default();
    }
    true
}

#[cfg(test)]
pub(crate) mod tests {
    use image::ImageDecoder;

    use super::*;

    /// A PNG of 1 × 1 pixel, black by its palette, with these bytes for the palette.
    pub(crate) fn with_palette(palette: &[u8]) -> Vec<u8> {
        let pixel = [0x78, 0x01, 0x01, 2, 0, 0xfd, 0xff, 0, 0, 0, 2, 0, 1];
        let header = [0, 0, 0, 1, 0, 0, 0, 1, 8, 3, 0, 0, 0];
        let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
        for (kind, data) in [(b"IHDR", &header[..]), (b"PLTE", palette), (b"IDAT", &pixel), (b"IEND", &[])] {
            let body = [kind, data].concat();
            png.extend((data.len() as u32).to_be_bytes());
            png.extend(&body);
            png.extend(crc32fast::hash(&body).to_be_bytes());
        }
        png
    }

    #[test]
    fn palettes_that_end_within_a_colour_are_refused() {
        let decode = |palette: &[u8]| -> ImageResult<Vec<u8>> {
            let png = with_palette(palette);
            let decoder = reader(&png, 1 << 20)?.into_decoder()?;
            let mut texels = vec![1; decoder.total_bytes() as usize];
            decoder.read_image(&mut texels)?;
            Ok(texels)
        };
        assert_eq!(decode(&[0, 0, 0]).expect("a sound file"), [0; 3]);
        for length in [4, 5, 11] {
            let message = decode(&vec![0; length]).expect_err("cut off").to_string();
            assert!(message.contains("its palette ends within a colour"), "{message}");
        }
    }
}
