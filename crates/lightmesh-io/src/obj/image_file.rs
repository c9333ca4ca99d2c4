//! Files beside the OBJ file: material libraries and images.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::{Component, Path};

use image::{ImageReader, Limits};
use lightmesh::{ImageData, Texels};

use super::Context;
use crate::error::{Error, one_line};

/// The bytes of a file named in the scene; `None`, and a warning, where it cannot be read or must not be.
pub(super) fn read_beside(context: &mut Context<'_>, name: &str) -> Result<Option<Vec<u8>>, Error> {
    match open_beside(context, name) {
        Ok((file, length)) => {
            context.budget.take(context.file, name, length, 1)?;
            let mut bytes = Vec::with_capacity(length as usize);
            match file.take(length).read_to_end(&mut bytes) {
                Ok(_) => Ok(Some(bytes)),
                Err(cause) => {
                    context.warnings.add(name, &format!("cannot be read: {cause}; it is left out"));
                    Ok(None)
                }
            }
        }
        Err(why) => {
            context.warnings.add(one_line(name), &why);
            Ok(None)
        }
    }
}

/// Opens the file, which must lie in the scene's folder (as written and after symbolic links) unless the options allow others.
fn open_beside(context: &Context<'_>, name: &str) -> Result<(File, u64), String> {
    const OUTSIDE: &str =
        "leaves the scene's folder and is left out; put the file beside the scene or pass --allow-outside";
    let cannot = |cause: std::io::Error| format!("cannot be read: {cause}; it is left out");
    let Some(folder) = context.folder else {
        return Err("is left out: the scene was not read from a folder".into());
    };
    // Windows exporters write backslashes.
    let relative = name.replace('\\', "/");
    if relative.is_empty() || relative.contains('\0') {
        return Err("is no file name".into());
    }
    let outward = |c| !matches!(c, Component::Normal(_) | Component::CurDir);
    if !context.options.allow_outside && Path::new(&relative).components().any(outward) {
        return Err(OUTSIDE.into());
    }
    let resolved = folder.join(&relative).canonicalize().map_err(cannot)?;
    if !context.options.allow_outside && !resolved.starts_with(folder.canonicalize().map_err(cannot)?) {
        return Err(OUTSIDE.into());
    }
    let metadata = resolved.metadata().map_err(cannot)?;
    // A pipe or a device could keep us waiting for ever.
    if !metadata.is_file() {
        return Err("is not a regular file and is left out".into());
    }
    Ok((File::open(&resolved).map_err(cannot)?, metadata.len()))
}

/// Reads and decodes an image beside the scene; `None`, and a warning, where that fails.
pub(super) fn read_image(context: &mut Context<'_>, name: &str) -> Result<Option<ImageData>, Error> {
    let Some(bytes) = read_beside(context, name)? else { return Ok(None) };
    // Look at the size first, pay for the texels, then decode within what is left.
    let reader = || ImageReader::new(Cursor::new(&bytes)).with_guessed_format();
    let size = reader().map_err(image::ImageError::IoError).and_then(|reader| reader.into_dimensions());
    let decoded = match size {
        Ok((width, height)) => {
            // Four bytes per texel here, and at most as many in the decoder, which may hold 16-bit channels.
            context.budget.take(context.file, name, u64::from(width) * u64::from(height), 12)?;
            let mut limits = Limits::default();
            limits.max_alloc = Some(12 * u64::from(width) * u64::from(height) + (1 << 20));
            reader().map_err(image::ImageError::IoError).and_then(|mut reader| {
                reader.limits(limits);
                reader.decode()
            })
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
