//! Scene files.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lightmesh_cli::{Chosen, EmitterArgs, choice};
use lightmesh_io::{LoadOptions, Units};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::{Origin, PyScene};
use crate::built::{BuildError, Built};
use crate::error::{self, Raise};
use crate::keywords;
use crate::work::{self, AtInterrupt};

/// Returns the options of reading a file.
pub(crate) fn load_options(
    py: Python<'_>,
    units: &str,
    allow_outside: bool,
    max_memory: Option<&Bound<'_, PyAny>>,
    scene: Option<&Bound<'_, PyAny>>,
) -> PyResult<LoadOptions> {
    let units = match units {
        "gltf" => Units::Gltf,
        "blender" => Units::Blender,
        _ => return Err(error::option(py, format!("units: must be one of gltf or blender, not {units:?}"))),
    };
    let mut chosen = Chosen::default();
    if let (Some(value), Some(about)) = (max_memory, choice("max-memory")) {
        keywords::choose(&mut chosen, &about, value)?;
    }
    let limits = chosen.render_options().map_err(|error| error.raise(py))?.limits;
    let scene = scene.map(scene_name).transpose()?;
    Ok(LoadOptions { units, allow_outside, scene, max_memory: limits.max_memory })
}

/// Returns the name of a file's scene, or its index as text.
fn scene_name(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let index = || keywords::number(value).map(|index| index.to_string());
    let text = value.extract().ok().or_else(index);
    text.ok_or_else(|| PyTypeError::new_err("scene: must be the name or the index of one of the file's"))
}

/// Reads a scene file and builds the scene, both on a thread of their own.
pub(crate) fn load(py: Python<'_>, path: PathBuf, options: LoadOptions) -> PyResult<PyScene> {
    let emitters = EmitterArgs::default();
    let units = options.units;
    let name = path.display().to_string();

    // Neither reading nor building can be told to stop.
    let loaded = work::run(py, None, None, AtInterrupt::Abandon, move |_| {
        let started = Instant::now();
        let loaded = lightmesh_io::load(&path, &options).map_err(BuildError::File)?;
        let load_time = started.elapsed();
        let built = Built::new(loaded.data, &emitters, options.max_memory, None)?;
        let files = loaded.files.into_iter().map(|file| std::path::absolute(&file).unwrap_or(file)).collect();
        Ok((built, loaded.warnings, load_time, files))
    })?;

    // Errors of the scene itself do not know its file.
    let (built, warnings, load_time, files) = loaded.map_err(|error| match error {
        BuildError::Scene(error @ (lightmesh::Error::InvalidScene { .. } | lightmesh::Error::EmptyScene)) => {
            error::scene(py, format!("{name}: {error}"))
        }
        other => other.raise(py),
    })?;
    Ok(PyScene::ready(Origin { name, units, load_time, warnings, files }, Arc::new(built)))
}
