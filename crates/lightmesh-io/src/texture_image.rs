//! The image formats of textures.

use std::io::Cursor;

use image::error::{ImageFormatHint, UnsupportedError};
use image::{ImageError, ImageFormat, ImageReader, ImageResult, Limits};

/// A reader of a PNG, JPEG or WebP image that allocates at most `limit` bytes.
///
/// # Errors
/// For any other format, also those that the `image` crate was built with for other uses.
pub(crate) fn reader(bytes: &[u8], limit: u64) -> ImageResult<ImageReader<Cursor<&[u8]>>> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    match reader.format() {
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
