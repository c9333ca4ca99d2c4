//! Reads a scene file with the reader for its format.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::load_options::{LoadOptions, Loaded};
use crate::{gltf, obj, ply};

/// The formats that [`load`] reads, for messages.
const READABLE: &str = "glTF 2.0 (.gltf, .glb), Wavefront OBJ (.obj) and PLY (.ply)";

/// Reads a scene file. The extension picks the reader; a file with another extension is read if it begins as a binary
/// glTF.
///
/// # Errors
/// Every variant of [`Error`] that is about reading: the file is missing, cut off, not of its format, contradicts
/// itself, needs something that we do not read, refers to files outside its folder, or is larger than the options
/// allow.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, Error> {
    let file = path.display().to_string();
    refuse_other_than_files(path, &file)?;
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let reader: Reader = match extension.as_str() {
        "gltf" | "glb" => gltf::read,
        "obj" => obj::read,
        "ply" => ply::read,
        _ if starts_as_glb(path, &file)? => gltf::read,
        other => {
            let what = match other {
                "" => "has no extension and does not begin as a binary glTF".to_owned(),
                _ => one_line(format_args!("files of kind \".{other}\" are not read")),
            };
            return Err(Error::UnknownFormat { file: one_line(file), what, readable: READABLE });
        }
    };

    let mut budget = Budget::new(options.max_memory);
    let bytes = read_file(path, &file, &mut budget)?;
    // A relative path without a folder lies in the current one.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut loaded = reader(&file, &bytes, Some(folder), options, budget)?;
    loaded.files.insert(0, path.to_owned());
    Ok(loaded)
}

/// Refuses what has no beginning and no end: a pipe could keep us waiting, and a device could go on for ever.
fn refuse_other_than_files(path: &Path, file: &str) -> Result<(), Error> {
    let read_error = |cause| Error::Read { file: one_line(file), cause };
    let there = fs::metadata(path).map_err(read_error)?;
    // What is wrong with a folder is said by the operating system.
    if there.is_file() || there.is_dir() {
        return Ok(());
    }
    let what = "it is a pipe, a device or a socket and not a file";
    Err(read_error(io::Error::new(io::ErrorKind::InvalidInput, what)))
}

/// Turns a file's name, bytes and folder into a scene, with what the file itself has left of the budget.
type Reader = fn(&str, &[u8], Option<&Path>, &LoadOptions, Budget) -> Result<Loaded, Error>;

/// Returns whether the file has the magic bytes of a binary glTF.
fn starts_as_glb(path: &Path, file: &str) -> Result<bool, Error> {
    let read_error = |cause| Error::Read { file: one_line(file), cause };
    let mut start = Vec::with_capacity(4);
    File::open(path).map_err(read_error)?.take(4).read_to_end(&mut start).map_err(read_error)?;
    Ok(start == *b"glTF")
}

/// Reads the whole file, whose bytes are paid from the budget first.
fn read_file(path: &Path, file: &str, budget: &mut Budget) -> Result<Vec<u8>, Error> {
    let read_error = |cause| Error::Read { file: one_line(file), cause };
    let handle = File::open(path).map_err(read_error)?;
    let length = handle.metadata().map_err(read_error)?.len();
    budget.take(file, "the file", length, 1)?;
    // The file may grow while it is read; what came after the look at its length is not ours.
    let mut bytes = Vec::with_capacity(length as usize);
    handle.take(length).read_to_end(&mut bytes).map_err(read_error)?;
    Ok(bytes)
}
