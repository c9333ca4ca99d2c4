//! From a path to a scene: which reader takes it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use lightmesh::SceneData;

use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::gltf;

/// What the numbers of punctual lights mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Units {
    /// Candela and lux, as KHR_lights_punctual says.
    #[default]
    Gltf,
    /// Blender's exporter multiplies lamps by 683 lm/W but leaves emission as it is: divide punctual lights by 683.
    Blender,
}

/// How a scene file is read.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Units of punctual lights; default [`Units::Gltf`].
    pub units: Units,
    /// Whether URIs may leave the folder of the scene file (`..`, absolute paths, symbolic links); default no. Networks are
    /// never asked.
    pub allow_outside: bool,
    /// Name or index of the scene in a file that has several; `None`: the file's default, else its first.
    pub scene: Option<String>,
    /// Bytes that may be spent on files, decoded geometry and images together; default 4 GiB. Parsed JSON comes on top, in
    /// proportion to the text's length.
    pub max_memory: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { units: Units::Gltf, allow_outside: false, scene: None, max_memory: 4 << 30 }
    }
}

/// A scene that was read.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What the file says.
    pub data: SceneData,
    /// What was left out or mended, one sentence each.
    pub warnings: Vec<String>,
}

/// What [`load`] reads, for messages.
const READABLE: &str = "glTF 2.0 (.gltf, .glb)";

/// Reads a scene file. The extension picks the reader; a file with another extension is read if it begins as a binary glTF.
///
/// # Errors
/// Every variant of [`Error`] that is about reading: the file is missing, cut off, not of its format, contradicts itself, needs
/// something that we do not read, refers to files outside its folder, or is larger than the options allow.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, Error> {
    let file = path.display().to_string();
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let is_gltf = match extension.as_str() {
        "gltf" | "glb" => true,
        _ => starts_as_glb(path, &file)?,
    };
    if !is_gltf {
        let what = match extension.as_str() {
            "" => "has no extension and does not begin as a binary glTF".to_owned(),
            other => one_line(format_args!("files of kind \".{other}\" are not read")),
        };
        return Err(Error::UnknownFormat { file: one_line(file), what, readable: READABLE });
    }

    let mut budget = Budget::new(options.max_memory);
    let bytes = read_file(path, &file, &mut budget)?;
    // A relative path without a folder lies in the current one.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    gltf::read(&file, &bytes, Some(folder), options, budget)
}

/// Whether the file has the magic bytes of a binary glTF.
fn starts_as_glb(path: &Path, file: &str) -> Result<bool, Error> {
    let read_error = |cause| Error::Read { file: one_line(file), cause };
    let mut start = Vec::with_capacity(4);
    File::open(path).map_err(read_error)?.take(4).read_to_end(&mut start).map_err(read_error)?;
    Ok(start == *b"glTF")
}

/// The whole file, its bytes paid from the budget first.
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
