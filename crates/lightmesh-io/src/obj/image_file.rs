//! Files beside the OBJ file: material libraries and images.

use lightmesh::{ImageData, Texels};

use super::Context;
use crate::beside::{self, OUTSIDE, Refusal};
use crate::error::{Error, one_line};
use crate::texture_image;

/// Notes that the scene names a file.
pub(super) fn note_file(context: &mut Context<'_>, name: &str) {
    context.files.extend(beside::path_of(context.folder, name, context.options.allow_outside));
}

/// The bytes of a file named in the scene; `None`, and a warning, where it cannot be read or must not be.
pub(super) fn read_beside(context: &mut Context<'_>, name: &str) -> Result<Option<Vec<u8>>, Error> {
    let cannot = |cause| format!("cannot be read: {cause}; it is left out");
    let why = match beside::open(context.folder, name, context.options.allow_outside) {
        Ok(beside) => {
            context.budget.take(context.file, name, beside.length, 1)?;
            match beside.read() {
                Ok(bytes) => return Ok(Some(bytes)),
                Err(cause) => cannot(cause),
            }
        }
        Err(Refusal::NoFolder) => "is left out: the scene was not read from a folder".into(),
        Err(Refusal::NotAName) => "is no file name: it is left out".into(),
        Err(Refusal::Outside) => format!("is left out: it {OUTSIDE}"),
        Err(Refusal::NotAFile) => "is not a regular file and is left out".into(),
        Err(Refusal::Unreadable { cause, .. }) => cannot(cause),
    };
    context.warnings.add(one_line(name), &why);
    Ok(None)
}

/// Reads and decodes an image beside the scene; `None`, and a warning, where that fails.
pub(super) fn read_image(context: &mut Context<'_>, name: &str) -> Result<Option<ImageData>, Error> {
    let Some(bytes) = read_beside(context, name)? else { return Ok(None) };
    // Look at the size first, pay for the texels, then decode within what is left.
    let size = texture_image::reader(&bytes, 512 << 20).and_then(|reader| reader.into_dimensions());
    let decoded = match size {
        Ok((width, height)) => {
            // Four bytes per texel here, and eight at most in the decoder, which may hold 16-bit channels; the smaller
            // copies that the built scene has have no more texels than the image, and fit into what the decoder gave
            // back.
            context.budget.take(context.file, name, u64::from(width) * u64::from(height), 12)?;
            let limit = 12 * u64::from(width) * u64::from(height) + (1 << 20);
            texture_image::reader(&bytes, limit).and_then(|reader| reader.decode())
        }
        Err(error) => Err(error),
    };
    match decoded {
        Ok(decoded) => {
            let rgba = decoded.into_rgba8();
            let (width, height) = rgba.dimensions();
            let texels: Vec<[u8; 4]> = rgba.pixels().map(|pixel| pixel.0).collect();
            Ok(Some(ImageData { name: name.to_owned(), width, height, texels: Texels::Rgba8(texels.into()) }))
        }
        Err(error) => {
            let what = format!("cannot be decoded: {}; it is left out (PNG, JPEG and WebP are read)", one_line(error));
            context.warnings.add(one_line(name), &what);
            Ok(None)
        }
    }
}
