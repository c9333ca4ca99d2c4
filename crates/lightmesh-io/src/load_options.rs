//! The options and the result of every reader of scenes.

use std::path::PathBuf;

use lightmesh::SceneData;

/// Units of the intensities of punctual lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Units {
    /// Candela and lux, as KHR_lights_punctual says.
    #[default]
    Gltf,
    /// Blender's exporter multiplies lamps by 683 lm/W but leaves emission as it is: divide punctual lights by 683.
    Blender,
}

/// Options of reading a scene file.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Units of punctual lights; default [`Units::Gltf`].
    pub units: Units,
    /// Whether URIs may leave the folder of the scene file (`..`, absolute paths, symbolic links); default no. The
    /// network is never used.
    pub allow_outside: bool,
    /// Name or index of the scene in a file that has several; `None`: the file's default, else its first.
    pub scene: Option<String>,
    /// Bytes that may be spent on files, parsed text, decoded geometry and images together; default 4 GiB. What might
    /// be needed is counted before it is allocated, and nothing is counted back, so somewhat less is in use at any
    /// time.
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
    /// The contents of the file.
    pub data: SceneData,
    /// What was left out or mended, one sentence each.
    pub warnings: Vec<String>,
    /// The file itself and every file that it names: buffers, images, material libraries, whether they are there and
    /// in use or not. What is written while the scene is of use must not take their places.
    pub files: Vec<PathBuf>,
}
