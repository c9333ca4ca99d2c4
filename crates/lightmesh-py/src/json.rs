//! JSON: the statistics of the library on their way to Python.

use lightmesh_io::output::Denoised;
use pyo3::prelude::*;

use crate::error;

/// Returns what [`serde_json::to_string`] returned; writing our own statistics never fails, so a failure is a defect.
pub(crate) fn written(text: serde_json::Result<String>) -> PyResult<String> {
    text.map_err(|error| error::internal(&error.to_string()))
}

/// Parses JSON into Python's own objects.
pub(crate) fn parse<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// Adds to statistics what took the noise out of the picture.
pub(crate) fn with_denoised(stats: &str, denoised: &Denoised) -> PyResult<String> {
    let mut all: serde_json::Value =
        serde_json::from_str(stats).map_err(|error| error::internal(&error.to_string()))?;
    all["denoiser"] = denoised.by.as_str().into();
    all["seconds"]["denoise"] = denoised.seconds.into();
    Ok(all.to_string())
}
