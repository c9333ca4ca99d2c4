//! Taking the noise out of pictures: where Python has the library, and what its absence raises.

use std::ffi::CString;
use std::path::PathBuf;

use lightmesh::{Method, RenderOptions};
use lightmesh_cli::{Denoise, no_noise_message};
use lightmesh_denoise::Places;
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

use crate::error::Raise;

/// Returns where the library may be: with the package `pyoidn` of this interpreter, which is found and not imported, and
/// wherever the environment says.
pub(crate) fn places(py: Python<'_>) -> PyResult<Places> {
    let spec = py.import("importlib.util")?.call_method1("find_spec", ("pyoidn",))?;
    let package: Option<Vec<PathBuf>> = match spec.is_none() {
        true => None,
        false => spec.getattr("submodule_search_locations")?.extract()?,
    };
    Ok(Places { package: package.and_then(|folders| folders.into_iter().next()), ..Places::of_process() })
}

/// Loads the library for a render, and adds the layers that it needs to the options; `None`, with a warning, where
/// pictures by the method have no noise.
pub(crate) fn prepare(py: Python<'_>, options: &mut RenderOptions) -> PyResult<Option<Denoise>> {
    let denoise = Denoise::prepare(&places(py)?, options).map_err(|error| error.raise(py))?;
    if denoise.is_none() {
        warn_of_no_noise(py, options.method)?;
    }
    Ok(denoise)
}

/// Warns (`RuntimeWarning`) that a picture has no noise.
pub(crate) fn warn_of_no_noise(py: Python<'_>, method: Method) -> PyResult<()> {
    let message = CString::new(no_noise_message(method))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 1)
}
