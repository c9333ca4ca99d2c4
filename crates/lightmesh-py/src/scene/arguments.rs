//! What methods of scenes are given, as the library has it.

use glam::Affine3A;
use lightmesh::{Camera, Material, SceneData};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::camera::PyCamera;
use crate::material::PyMaterial;
use crate::{arrays, error, keywords};

/// A material of the scene by its index, or a new one.
pub(super) enum MaterialArg<'py> {
    New(Bound<'py, PyMaterial>),
    Index(usize),
}

impl<'a, 'py> FromPyObject<'a, 'py> for MaterialArg<'py> {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(material) = value.cast::<PyMaterial>() {
            return Ok(Self::New(material.to_owned()));
        }
        let wrong = |_| PyTypeError::new_err("must be a Material, or the index of one that was added");
        value.extract().map(Self::Index).map_err(wrong)
    }
}

/// Which camera takes the picture, as the command line chooses it.
pub(crate) fn scene_camera(
    cameras: &[Camera],
    data: &SceneData,
    wanted: Option<&Bound<'_, PyAny>>,
) -> PyResult<Camera> {
    let wanted = match wanted {
        None => None,
        Some(value) => {
            if let Ok(camera) = value.cast::<PyCamera>() {
                return Ok(camera.get().camera.clone());
            }
            // A number is an index, whatever the names are.
            if let Some(camera) = value.extract::<usize>().ok().and_then(|index| cameras.get(index)) {
                return Ok(camera.clone());
            }
            Some((keywords::spell("camera", value)?, value.py()))
        }
    };
    let name = wanted.as_ref().map(|(name, _)| name.to_string_lossy());
    match (lightmesh_cli::choose_camera(data, name.as_deref()), wanted) {
        (Ok((camera, _)), _) => Ok(camera),
        (Err(error), Some((_, py))) => {
            Err(error::option(py, error.to_string().replace("the file has", "the scene has")))
        }
        (Err(error), None) => Err(PyValueError::new_err(error.to_string())),
    }
}

/// The index of a material, which is added if it is new.
pub(super) fn material_index(data: &mut SceneData, material: Option<MaterialArg<'_>>) -> Result<usize, String> {
    match material {
        Some(MaterialArg::New(material)) => Ok(material.get().add_to(data)),
        Some(MaterialArg::Index(index)) if index < data.materials.len() => Ok(index),
        Some(MaterialArg::Index(index)) => {
            Err(format!("material: there is no {index}; the scene has {}", data.materials.len()))
        }
        None => {
            data.materials.push(Material::default());
            Ok(data.materials.len() - 1)
        }
    }
}

/// A transform, which may be missing.
pub(super) fn transform_or_identity(transform: Option<&Bound<'_, PyAny>>) -> PyResult<Affine3A> {
    transform.map_or(Ok(Affine3A::IDENTITY), |value| arrays::affine(value, "transform"))
}
