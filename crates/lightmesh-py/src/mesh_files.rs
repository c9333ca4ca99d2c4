//! Meshes into files and back.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use lightmesh::LightMesh;
use lightmesh_cli::{Chosen, EnvironmentArg, SOFTWARE, choice, settings_json};
use lightmesh_io::output::StagedFile;
use lightmesh_io::{Error, MeshFile, Provenance, Units, write_mesh_to};
use pyo3::prelude::*;

use crate::error::{self, Raise};
use crate::keywords::Keywords;
use crate::scene::LitScene;
use crate::shared_mesh::{self, SharedMesh};
use crate::work::{self, AtInterrupt, Watch};

/// Settings that a loaded mesh takes from its file unless the caller gives others: all that its points depend on. An
/// environment that is a file is not among them: a mesh file must not decide which files are opened.
const KEPT: [&str; 22] = [
    "method",
    "bounces",
    "error",
    "depth",
    "falloff",
    "light-error",
    "seed",
    "environment",
    "environment-strength",
    "environment-rotation",
    "light-samples",
    "light-radius",
    "spacing",
    "indirect-spacing",
    "gather-rays",
    "refine",
    "lod-distance",
    "rays",
    "interpolation",
    "weight",
    "field-falloff",
    "paper-scale",
];

/// The most bytes that are written at once, before the next look at whether to stop.
const AT_ONCE: usize = 1 << 22;

/// Why a mesh was not saved.
enum SaveError {
    MeshInUse,
    File(Error),
}

/// Writes everything that a mesh knows to a file, which appears whole or not at all.
pub(crate) fn save(
    py: Python<'_>,
    path: PathBuf,
    lit: LitScene,
    mesh: SharedMesh,
    units: Units,
    callback: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    let LitScene { keywords, built } = lit;
    let options = keywords.mesh_options();
    let settings = settings_json(&options, keywords.emitters(), units, "");
    let work = move |watch: &Watch| {
        let mut staged = StagedFile::create(&path).map_err(SaveError::File)?;
        let file = {
            let mesh = mesh.lock().ok_or(SaveError::MeshInUse)?;
            let method = options.method.name();
            let provenance = Provenance { software: SOFTWARE, method, settings: &settings };
            MeshFile::new(&built.scene, &options, &mesh, provenance)
        };
        let total = file.array_bytes();
        let mut out = Watched { out: &mut staged, watch, done: 0, total };
        let written = write_mesh_to(&mut out, &file);
        written.map_err(|cause| SaveError::File(staged.error(cause)))?;
        watch.saved(total, total);
        staged.commit().map_err(SaveError::File)
    };
    work::run(py, keywords.threads(), callback, AtInterrupt::Wait, work)?.map_err(|error| match error {
        SaveError::MeshInUse => shared_mesh::in_use(py),
        SaveError::File(error) => error.raise(py),
    })
}

/// A writer that counts bytes, and fails when the work is cancelled.
struct Watched<'a> {
    out: &'a mut StagedFile,
    watch: &'a Watch,
    done: u64,
    total: u64,
}

impl Write for Watched<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if lightmesh::Progress::cancelled(self.watch) {
            return Err(io::Error::other("cancelled"));
        }
        let written = self.out.write(&bytes[..bytes.len().min(AT_ONCE)])?;
        self.done += written as u64;
        // The header is not counted, but written too.
        self.watch.saved(self.done.min(self.total), self.total);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A mesh file that has been read.
pub(crate) struct Opened {
    path: PathBuf,
    file: MeshFile,
    /// The settings of the mesh: those of the file, under those of the caller.
    pub(crate) chosen: Chosen,
    /// The environment map that lit the scene, if the caller did not name one.
    map: Option<String>,
}

/// Reads a mesh file; `said` are the settings that the caller gives.
pub(crate) fn open(py: Python<'_>, path: PathBuf, said: &Chosen) -> PyResult<Opened> {
    let max_memory = Keywords::new(py, said)?.mesh_options().limits.max_memory;
    let read = move |_: &Watch| {
        let file = lightmesh_io::read_mesh(&path, max_memory);
        file.map(|file| (path, file))
    };
    // Reading cannot be told to stop.
    let (path, file) =
        work::run(py, None, None, AtInterrupt::Abandon, read)?.map_err(|error: Error| error.raise(py))?;
    let unusable = |error: PyErr| {
        let message = error.value(py).to_string();
        error::scene(py, format!("{}: settings: {message}", path.display()))
    };
    let (kept, map) = settings(&file.settings).map_err(|error| unusable(error.raise(py)))?;
    Keywords::new(py, &kept).map_err(unusable)?;
    let map = map.filter(|_| said.get("environment").is_none());
    Ok(Opened { chosen: kept.over(said), path, file, map })
}

impl Opened {
    /// Makes the mesh, for the scene that it belongs to.
    pub(crate) fn into_mesh(self, py: Python<'_>, lit: &LitScene) -> PyResult<LightMesh> {
        let (built, options) = (Arc::clone(&lit.built), lit.keywords.mesh_options());
        let Self { path, file, map, .. } = self;
        let make = move |_: &Watch| file.into_mesh(&path, &built.scene, &options);
        let made = work::run(py, lit.keywords.threads(), None, AtInterrupt::Abandon, make)?;
        made.map_err(|error| match (error, map) {
            (error @ Error::OtherScene { .. }, Some(map)) => {
                error::scene(py, format!("{error}; it was lit by {map}: say so with environment="))
            }
            (error, _) => error.raise(py),
        })
    }
}

/// Returns the settings of the file that its mesh depends on, and the file of its environment map.
fn settings(json: &str) -> Result<(Chosen, Option<String>), lightmesh::Error> {
    let settings: serde_json::Map<String, serde_json::Value> = serde_json::from_str(json).unwrap_or_default();
    let (mut chosen, mut map) = (Chosen::default(), None);
    for about in KEPT.into_iter().filter_map(choice) {
        if let Some(value) = lightmesh_io::setting(&settings, about.key()) {
            match EnvironmentArg::parse(value.as_text()).filter(|_| about.name == "environment") {
                Some(EnvironmentArg::File(path)) => map = Some(path.display().to_string()),
                _ => chosen.choose(&about, &value)?,
            }
        }
    }
    Ok((chosen, map))
}
