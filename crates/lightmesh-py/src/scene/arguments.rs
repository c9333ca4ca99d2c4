//! Arguments of the methods of scenes, converted into what the library takes.

use glam::{Affine3A, Quat, Vec3};
use lightmesh::{Camera, Environment, Material, SceneData};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::camera::PyCamera;
use crate::material::{self, PyMaterial};
use crate::{arrays, error, keywords};

/// A material of the scene by its index, or a new one.
pub(crate) enum MaterialArg<'py> {
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

/// Returns a place in the file's coordinates relative to the scene's origin, which is zero unless a reader chose another.
pub(crate) fn relative(data: &SceneData, place: Vec3) -> Vec3 {
    (place.as_dvec3() - data.origin).as_vec3()
}

/// Returns a transform to the file's coordinates as one to those relative to the scene's origin.
pub(crate) fn placed(data: &SceneData, mut transform: Affine3A) -> Affine3A {
    transform.translation = relative(data, transform.translation.into()).into();
    transform
}

/// Chooses the camera of a picture as the command line does.
pub(crate) fn scene_camera(data: &SceneData, wanted: Option<&Bound<'_, PyAny>>) -> PyResult<Camera> {
    // A Camera is taken as it is; everything else is a name or an index.
    let wanted = match wanted {
        None => None,
        Some(value) => {
            if let Ok(camera) = value.cast::<PyCamera>() {
                return Ok(camera.get().camera.clone());
            }
            // A number is an index, whatever the names are.
            if let Some(camera) = value.extract::<usize>().ok().and_then(|index| data.cameras.get(index)) {
                return Ok(camera.clone());
            }
            Some((camera_name(value)?, value.py()))
        }
    };
    let name = wanted.as_ref().map(|(name, _)| name.as_str());
    match (lightmesh_cli::choose_camera(data, name), wanted) {
        (Ok((camera, _)), _) => Ok(camera),
        (Err(error), Some((_, py))) => {
            Err(error::option(py, error.to_string().replace("the file has", "the scene has")))
        }
        (Err(error), None) => Err(PyValueError::new_err(error.to_string())),
    }
}

/// Returns the name of a camera, or its index as text.
fn camera_name(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let number = || if value.is_instance_of::<PyBool>() { None } else { keywords::number(value) };
    let text = value.extract().ok().or_else(|| number().map(|number| number.to_string()));
    text.ok_or_else(|| PyTypeError::new_err("camera: must be a Camera, or the name or index of one of the scene's"))
}

/// Returns the index of a material; adds it if it is new.
pub(crate) fn material_index(data: &mut SceneData, material: Option<MaterialArg<'_>>) -> Result<usize, String> {
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

/// Converts a transform; a missing one is the identity.
pub(crate) fn transform_or_identity(transform: Option<&Bound<'_, PyAny>>) -> PyResult<Affine3A> {
    transform.map_or(Ok(Affine3A::IDENTITY), |value| arrays::affine(value, "transform"))
}

/// Converts the arguments of Scene.set_environment: a map, (H, W, 3), or a colour, (3,) or one number.
pub(crate) fn environment(value: &Bound<'_, PyAny>, strength: f32, rotation: f32) -> PyResult<Environment> {
    let (map, color) = match arrays::dimensions(value) {
        Some(3) => (Some(material::image(value, "environment")?), Vec3::ONE),
        _ => (None, arrays::color(value, "environment")?),
    };
    if !rotation.is_finite() {
        return Err(error::option(value.py(), format!("rotation: must be degrees, not {rotation}")));
    }
    let world_from_map = Quat::from_rotation_y(rotation.to_radians());
    Ok(Environment { map, radiance: color * strength, world_from_map })
}
