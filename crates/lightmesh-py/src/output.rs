//! Files that Python writes.

use std::io::Write;
use std::path::{Path, PathBuf};

use lightmesh_io::output::{StagedFile, is_same_file};
use pyo3::prelude::*;

use crate::error::{self, Raise};

/// Refuses to write to a file that the scene was read from, whatever it is called.
pub(crate) fn spare(py: Python<'_>, path: &Path, files_of_the_scene: &[PathBuf]) -> PyResult<()> {
    match files_of_the_scene.iter().find(|file| is_same_file(file, path)) {
        None => Ok(()),
        Some(file) => Err(error::option(
            py,
            format!("{}: would replace a file of the scene, {}; name another file", path.display(), file.display()),
        )),
    }
}

/// Writes a file, which appears whole or not at all.
#[pyfunction(name = "_write_file")]
pub(crate) fn write_file(py: Python<'_>, path: PathBuf, data: &[u8]) -> PyResult<()> {
    let written = py.detach(|| {
        let mut file = StagedFile::create(&path)?;
        file.write_all(data).map_err(|cause| file.error(cause))?;
        file.commit()
    });
    written.map_err(|error| error.raise(py))
}
