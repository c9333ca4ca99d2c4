//! The program, run from Python.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs `lightmesh` with these arguments, its own name first, and returns its exit code. It listens to Ctrl-C itself,
/// and may end the process.
#[pyfunction(name = "_run_program")]
pub(crate) fn run_program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| lightmesh_cli::run(arguments))
}
