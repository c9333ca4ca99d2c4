//! Cameras.

use glam::{DAffine3, DMat3};
use lightmesh::{Camera, Projection};
use pyo3::prelude::*;

use crate::{arrays, error};

/// A camera; it looks along its own -Z, +Y is up. Made by look_at, from_matrix or orthographic, or taken from a scene.
#[pyclass(name = "Camera", module = "lightmesh", frozen)]
pub(crate) struct PyCamera {
    pub(crate) camera: Camera,
}

/// Vertical field of view where none is said, radians: that of cameras which frame a scene.
const YFOV: f32 = 0.8;

#[pymethods]
impl PyCamera {
    /// A pinhole camera at eye that looks at target.
    ///
    /// eye, target, up: (3,), metres; up is what points upwards in the picture, +Y if it is not given.
    /// yfov: vertical field of view, radians, above 0 and below pi.
    /// aspect: width over height of pictures that have no size of their own; 1.5 if it is not given.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, yfov=YFOV, up=None, aspect=None, name=""), text_signature = "(eye, target, *, yfov=0.8, up=None, aspect=None, name='')")]
    fn look_at(
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        yfov: f32,
        up: Option<&Bound<'_, PyAny>>,
        aspect: Option<f32>,
        name: &str,
    ) -> PyResult<Self> {
        let py = eye.py();
        let (eye, target) = (arrays::vec3(eye, "eye")?, arrays::vec3(target, "target")?);
        let Some(back) = (eye - target).try_normalize() else {
            return Err(error::scene(py, "target: must be finite and another place than the eye"));
        };
        let world_from_camera = match up {
            None => Camera::look_at(eye, target, yfov).world_from_camera,
            Some(up) => {
                let up = arrays::direction(up, "up")?;
                let Some(right) = up.cross(back).try_normalize() else {
                    return Err(error::scene(py, "up: the camera looks along it"));
                };
                let matrix3 = DMat3::from_cols(right.as_dvec3(), back.cross(right).as_dvec3(), back.as_dvec3());
                DAffine3 { matrix3, translation: eye.as_dvec3() }
            }
        };
        let projection = Projection::Perspective { yfov, aspect };
        Self::checked(py, Camera { name: name.to_owned(), world_from_camera, projection })
    }

    /// A pinhole camera placed by a matrix.
    ///
    /// world_from_camera: (4, 4), turns column vectors; its scale is ignored.
    /// yfov, aspect: as for look_at.
    #[staticmethod]
    #[pyo3(signature = (world_from_camera, *, yfov=YFOV, aspect=None, name=""), text_signature = "(world_from_camera, *, yfov=0.8, aspect=None, name='')")]
    fn from_matrix(world_from_camera: &Bound<'_, PyAny>, yfov: f32, aspect: Option<f32>, name: &str) -> PyResult<Self> {
        Self::placed(world_from_camera, Projection::Perspective { yfov, aspect }, name)
    }

    /// A camera of parallel rays placed by a matrix.
    ///
    /// world_from_camera: (4, 4), turns column vectors; its scale is ignored.
    /// xmag, ymag: half the width and half the height of the view, metres.
    #[staticmethod]
    #[pyo3(signature = (world_from_camera, *, xmag, ymag, name=""))]
    fn orthographic(world_from_camera: &Bound<'_, PyAny>, xmag: f32, ymag: f32, name: &str) -> PyResult<Self> {
        Self::placed(world_from_camera, Projection::Orthographic { xmag, ymag }, name)
    }

    /// Its name; may be empty.
    #[getter]
    fn name(&self) -> &str {
        &self.camera.name
    }

    /// Its position, metres.
    #[getter]
    fn eye(&self) -> (f32, f32, f32) {
        self.camera.world_from_camera.translation.as_vec3().into()
    }

    /// Vertical field of view, radians; None for parallel rays.
    #[getter]
    fn yfov(&self) -> Option<f32> {
        match self.camera.projection {
            Projection::Perspective { yfov, .. } => Some(yfov),
            Projection::Orthographic { .. } => None,
        }
    }

    /// Width over height of pictures that have no size of their own.
    #[getter]
    fn aspect(&self) -> f32 {
        self.camera.aspect()
    }

    fn __repr__(&self) -> String {
        let (x, y, z) = self.eye();
        let kind = if self.yfov().is_some() { "perspective" } else { "orthographic" };
        format!("<lightmesh.Camera {:?}, {kind}, at ({x}, {y}, {z})>", self.camera.name)
    }
}

/// In double precision.
fn daffine(m: &glam::Affine3A) -> DAffine3 {
    DAffine3::from_cols_array(&m.to_cols_array().map(f64::from))
}

impl PyCamera {
    fn placed(matrix: &Bound<'_, PyAny>, projection: Projection, name: &str) -> PyResult<Self> {
        let world_from_camera = daffine(&arrays::affine(matrix, "world_from_camera")?);
        Self::checked(matrix.py(), Camera { name: name.to_owned(), world_from_camera, projection })
    }

    /// Checks a camera as a scene checks its own.
    fn checked(py: Python<'_>, camera: Camera) -> PyResult<Self> {
        match camera.projection {
            Projection::Perspective { yfov, .. } if !(yfov > 0.0 && yfov < std::f32::consts::PI) => {
                Err(error::scene(py, format!("yfov: must be above 0 and below pi radians, not {yfov}")))
            }
            Projection::Perspective { aspect: Some(aspect), .. } if !(aspect > 0.0 && aspect.is_finite()) => {
                Err(error::scene(py, format!("aspect: must be above 0, not {aspect}")))
            }
            Projection::Orthographic { xmag, ymag } if !(xmag.is_normal() && ymag.is_normal()) => {
                Err(error::scene(py, format!("xmag, ymag: must be metres other than 0, not {xmag} and {ymag}")))
            }
            _ if !camera.world_from_camera.is_finite() => {
                Err(error::scene(py, "the camera's place and directions must be finite"))
            }
            _ => Ok(Self { camera }),
        }
    }
}
