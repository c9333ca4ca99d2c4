//! Scenes: the class and its state. `methods` has what Python calls.

mod arguments;
pub(crate) mod bytes;
mod load;
mod state;

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lightmesh_io::Units;
use pyo3::prelude::*;

pub(crate) use self::arguments::{
    MaterialArg, environment, material_index, placed, relative, scene_camera, transform_or_identity,
};
pub(crate) use self::load::{load, load_options};
use self::state::Inner;
pub(crate) use self::state::LitScene;

/// What is rendered: surfaces, lights, an environment and cameras. Read from a file by Scene.load, or put together from
/// arrays.
///
/// Metres; candela for point and spot lights, lux for directional ones, cd/m² for surfaces and environments, per
/// channel of linear RGB.
/// A scene is checked and made ready for rays when that is first needed; what is wrong with it is a SceneError then.
/// Any number of threads may use a scene at once, and of processes that are forked (multiprocessing): pictures are the
/// same. A change counts for what begins after it.
#[pyclass(name = "Scene", module = "lightmesh", frozen)]
pub(crate) struct PyScene {
    pub(crate) origin: Origin,
    inner: Mutex<Inner>,
}

/// Where a scene comes from.
#[derive(Default)]
pub(crate) struct Origin {
    /// The file as the caller named it; empty for a scene made of arrays.
    pub(crate) name: String,
    pub(crate) units: Units,
    pub(crate) load_time: Duration,
    /// What the reader left out or mended, one sentence each.
    pub(crate) warnings: Vec<String>,
    /// The file and every file that it names, as absolute paths.
    pub(crate) files: Arc<[PathBuf]>,
}
