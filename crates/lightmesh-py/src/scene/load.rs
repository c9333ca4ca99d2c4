//! Scene files.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use pyo3::prelude::*;

use super::{Origin, PyScene};
use crate::built::{BuildError, Built};
use crate::error::{self, Raise};
use crate::keywords::{self, Pairs};
use crate::work::{self, AtInterrupt};

/// Reads a scene file and builds the scene, both on a thread of their own.
pub(crate) fn load(py: Python<'_>, path: PathBuf, pairs: &Pairs) -> PyResult<PyScene> {
    let keywords = keywords::parse(py, pairs)?;
    let (options, emitters) = (keywords.load_options(), keywords.emitters().clone());
    let units = options.units;
    let name = path.display().to_string();

    // Neither reading nor building can be told to stop.
    let loaded = work::run(py, None, None, AtInterrupt::Abandon, move |_| {
        let started = Instant::now();
        let loaded = lightmesh_io::load(&path, &options).map_err(BuildError::File)?;
        let load_time = started.elapsed();
        Ok((Built::new(loaded.data, &emitters, options.max_memory)?, loaded.warnings, load_time))
    })?;

    // Errors of the scene itself do not know its file.
    let (built, warnings, load_time) = loaded.map_err(|error| match error {
        BuildError::Scene(error @ (lightmesh::Error::InvalidScene { .. } | lightmesh::Error::EmptyScene)) => {
            error::scene(py, format!("{name}: {error}"))
        }
        other => other.raise(py),
    })?;
    Ok(PyScene::ready(Origin { name, units, load_time, warnings }, Arc::new(built)))
}
