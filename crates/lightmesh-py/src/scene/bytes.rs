//! Scenes as bytes, for other processes: units in one byte, the length of the name in eight, the name, the scene.

use lightmesh_io::Units;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::{Origin, PyScene};
use crate::error::{self, Raise};

/// Units and the length of the name.
const HEADER: usize = 9;

/// Writes a scene as bytes.
pub(crate) fn write<'py>(py: Python<'py>, scene: &PyScene) -> PyResult<Bound<'py, PyBytes>> {
    let state = scene.state();
    let bytes = py.detach(|| lightmesh_io::scene_to_bytes(&state.into_data()));
    let bytes = bytes.map_err(|error| error.raise(py))?;
    let name = scene.origin.name.as_bytes();
    PyBytes::new_with(py, HEADER + name.len() + bytes.len(), |out| {
        out[0] = match scene.origin.units {
            Units::Gltf => 0,
            Units::Blender => 1,
        };
        out[1..HEADER].copy_from_slice(&(name.len() as u64).to_le_bytes());
        out[HEADER..HEADER + name.len()].copy_from_slice(name);
        out[HEADER + name.len()..].copy_from_slice(&bytes);
        Ok(())
    })
}

/// Reads the bytes that [`write`] wrote.
pub(crate) fn read(py: Python<'_>, data: &[u8]) -> PyResult<PyScene> {
    let incomplete = || error::scene(py, "scene bytes: they are incomplete");
    let (&[units, ref length @ ..], rest) = data.split_first_chunk::<HEADER>().ok_or_else(incomplete)?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| incomplete())?;
    let (name, bytes) = rest.split_at_checked(length).ok_or_else(incomplete)?;
    let name = String::from_utf8_lossy(name).into_owned();
    let units = if units == 1 { Units::Blender } else { Units::Gltf };
    let data = py.detach(|| lightmesh_io::scene_from_bytes(bytes)).map_err(|error| error.raise(py))?;
    Ok(PyScene::draft(Origin { name, units, ..Origin::default() }, data))
}
