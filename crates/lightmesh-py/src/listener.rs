//! The argument `progress` of all functions that take long.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;

/// The receiver of progress reports.
pub(crate) enum Listener<'py> {
    Nobody,
    Function(Bound<'py, PyAny>),
    /// A bar, which has to be closed.
    Bar(Bound<'py, PyAny>),
}

impl<'py> Listener<'py> {
    /// Interprets the argument: `None` and `False` mean nobody, `True` a bar; everything else must be a function.
    pub(crate) fn new(py: Python<'py>, progress: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        let Some(progress) = progress else { return Ok(Self::Nobody) };
        if let Ok(wanted) = progress.cast::<PyBool>() {
            return Ok(match wanted.is_true() {
                true => Self::Bar(py.import("lightmesh._progress")?.getattr("Bar")?.call0()?),
                false => Self::Nobody,
            });
        }
        match progress.is_callable() {
            true => Ok(Self::Function(progress.clone())),
            false => Err(PyTypeError::new_err("progress: must be True or a function of (stage, done, total, rays)")),
        }
    }

    /// Returns the function to call.
    pub(crate) fn callback(&self) -> Option<&Bound<'py, PyAny>> {
        match self {
            Self::Nobody => None,
            Self::Function(callback) | Self::Bar(callback) => Some(callback),
        }
    }

    /// Closes the bar; returns the result of the work, or the error of closing.
    pub(crate) fn close<T>(&self, result: PyResult<T>) -> PyResult<T> {
        if let Self::Bar(bar) = self {
            let closed = bar.call_method0("close");
            return result.and_then(|result| closed.map(|_| result));
        }
        result
    }
}
