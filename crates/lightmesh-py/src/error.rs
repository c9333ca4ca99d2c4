//! Errors of the libraries as Python's exceptions: the one place where they are mapped.
//!
//! The classes are those of `lightmesh.errors`; files have Python's own (`FileNotFoundError` and others).

use std::io;

use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// An error that becomes an exception.
pub(crate) trait Raise {
    /// Returns the exception.
    fn raise(self, py: Python<'_>) -> PyErr;
}

/// A scene, an array or a picture that cannot be used: `SceneError`, a `ValueError`.
pub(crate) fn scene(py: Python<'_>, message: impl Into<String>) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    of_class(py, &CLASS, "SceneError", message.into())
}

/// An option outside its range: `OptionError`, a `ValueError`.
pub(crate) fn option(py: Python<'_>, message: impl Into<String>) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    of_class(py, &CLASS, "OptionError", message.into())
}

/// More memory than allowed: `MemoryLimitError`, a `MemoryError`.
fn memory(py: Python<'_>, message: String) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    of_class(py, &CLASS, "MemoryLimitError", message)
}

/// Every other failure of lightmesh: `Error`.
pub(crate) fn general(py: Python<'_>, message: impl Into<String>) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    of_class(py, &CLASS, "Error", message.into())
}

/// A failure that can only be a defect of lightmesh: `RuntimeError`.
pub(crate) fn internal(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("lightmesh failed inside, which is a defect of its own: {what}"))
}

/// An exception of a class of `lightmesh.errors`, which is imported once.
fn of_class(py: Python<'_>, class: &PyOnceLock<Py<PyType>>, name: &str, message: String) -> PyErr {
    match class.import(py, "lightmesh.errors", name) {
        Ok(class) => PyErr::from_type(class.clone(), message),
        Err(error) => error,
    }
}

impl Raise for lightmesh::Error {
    fn raise(self, py: Python<'_>) -> PyErr {
        use lightmesh::Error;
        match self {
            Error::InvalidScene { .. }
            | Error::EmptyScene
            | Error::InvalidMeter { .. }
            | Error::InvalidContents { .. } => scene(py, self.to_string()),
            Error::InvalidOption { option: name, what } => {
                option(py, format!("{}: {}", name.replace('-', "_"), without_dashes(&what)))
            }
            Error::IncompatibleMesh { .. }
            | Error::InvalidBricks { .. }
            | Error::InvalidWaves { .. }
            | Error::InvalidParts { .. }
            | Error::InvalidEmitterEdges { .. }
            | Error::InvalidReflection { .. } => option(py, self.to_string()),
            Error::OutOfMemory { .. } => memory(py, without_dashes(&self.to_string())),
            Error::Cancelled => PyKeyboardInterrupt::new_err(()),
            other => general(py, other.to_string()),
        }
    }
}

impl Raise for lightmesh_denoise::Error {
    fn raise(self, py: Python<'_>) -> PyErr {
        use lightmesh_denoise::Error;
        let message = self.to_string();
        match self {
            Error::OutOfMemory { .. } => memory(py, without_dashes(&message)),
            Error::MissingLayers { .. } => option(py, message),
            Error::Cancelled => PyKeyboardInterrupt::new_err(()),
            _ => general(py, message),
        }
    }
}

impl Raise for lightmesh_io::Error {
    fn raise(self, py: Python<'_>) -> PyErr {
        use lightmesh_io::Error;
        let message = self.to_string().replace("--max-memory", "max_memory");
        match self {
            Error::Read { file, cause } => os_error(&cause, "cannot be read: check the path and its permissions", file),
            Error::MissingFile { file, place, target, cause } => {
                os_error(&cause, &format!("cannot be read: {file}, {place} needs it beside the scene file"), target)
            }
            Error::Write { file, cause } => os_error(&cause, "cannot be written", file),
            Error::NoFolder { file, folder } => {
                let cause = io::Error::from_raw_os_error(ENOENT);
                os_error(&cause, &format!("the folder {folder} does not exist"), file)
            }
            Error::IsFolder { file } => os_error(&io::Error::from_raw_os_error(EISDIR), "name a file in it", file),
            Error::OutOfMemory { .. } => memory(py, message),
            Error::Mesh { cause: lightmesh::Error::OutOfMemory { .. }, .. } => memory(py, message),
            Error::Mesh {
                cause: lightmesh::Error::InvalidOption { .. } | lightmesh::Error::IncompatibleMesh { .. },
                ..
            }
            | Error::OtherSettings { .. }
            | Error::NoSuchScene { .. }
            | Error::PictureFormat { .. }
            | Error::EnvironmentFormat { .. } => option(py, message),
            Error::UnknownFormat { .. }
            | Error::Syntax { .. }
            | Error::Invalid { .. }
            | Error::Version { .. }
            | Error::RequiredExtension { .. }
            | Error::Uri { .. }
            | Error::DataUri { .. }
            | Error::Image { .. }
            | Error::Empty { .. }
            | Error::OtherScene { .. }
            | Error::Mesh { .. }
            | Error::Picture { .. } => scene(py, message),
            _ => general(py, message),
        }
    }
}

// Every system that has these error numbers has the same ones.
const ENOENT: i32 = 2;
const EISDIR: i32 = 21;

/// `OSError(errno, message, file)`, which Python turns into `FileNotFoundError`, `PermissionError` and so on.
fn os_error(cause: &io::Error, what: &str, file: String) -> PyErr {
    match cause.raw_os_error() {
        Some(errno) => {
            let cause = cause.to_string();
            let said = cause.split(" (os error").next().unwrap_or_default();
            PyOSError::new_err((errno, format!("{said}: {what}"), file))
        }
        None => PyOSError::new_err(format!("{file}: {what}: {cause}")),
    }
}

/// The message with options as Python spells them: `light_radius` for `--light-radius`.
pub(crate) fn without_dashes(message: &str) -> String {
    let mut parts = message.split("--");
    let mut result = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let length = part.bytes().take_while(|&b| b.is_ascii_lowercase() || b == b'-').count();
        let (name, rest) = part.split_at(length);
        let dashes = if name.is_empty() { "--" } else { "" };
        result.extend([dashes, &name.replace('-', "_"), rest]);
    }
    result
}
