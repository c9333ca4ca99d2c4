//! Punctual lights, to look at.

use lightmesh::Light;
use pyo3::prelude::*;

/// A light of a scene.
#[pyclass(name = "Light", module = "lightmesh", frozen)]
pub(crate) struct PyLight {
    pub(crate) light: Light,
}

#[pymethods]
impl PyLight {
    /// "point", "spot" or "directional".
    #[getter]
    fn kind(&self) -> &'static str {
        match self.light {
            Light::Point { .. } => "point",
            Light::Spot { .. } => "spot",
            Light::Directional { .. } => "directional",
        }
    }

    /// Its position, metres; None for a directional light.
    #[getter]
    fn position(&self) -> Option<(f32, f32, f32)> {
        match self.light {
            Light::Point { position, .. } | Light::Spot { position, .. } => Some(position.into()),
            Light::Directional { .. } => None,
        }
    }

    /// The way it shines, of unit length; None for a point light.
    #[getter]
    fn direction(&self) -> Option<(f32, f32, f32)> {
        match self.light {
            Light::Point { .. } => None,
            Light::Spot { direction, .. } | Light::Directional { direction, .. } => Some(direction.into()),
        }
    }

    /// Luminous intensity per channel, candela; of a directional light illuminance per channel, lux. Linear RGB.
    #[getter]
    fn color(&self) -> (f32, f32, f32) {
        self.light.color().into()
    }

    /// Distance at which it ends, metres; None: nowhere.
    #[getter]
    fn range(&self) -> Option<f32> {
        match self.light {
            Light::Point { range, .. } | Light::Spot { range, .. } => range,
            Light::Directional { .. } => None,
        }
    }

    /// Half angles of a spot's cone, radians: inside the first it is full, outside the second dark; None for other
    /// lights.
    #[getter]
    fn cone_angles(&self) -> Option<(f32, f32)> {
        match self.light {
            Light::Spot { inner_cone_angle, outer_cone_angle, .. } => Some((inner_cone_angle, outer_cone_angle)),
            Light::Point { .. } | Light::Directional { .. } => None,
        }
    }

    fn __repr__(&self) -> String {
        let place = self.position().or(self.direction()).unwrap_or_default();
        format!("<lightmesh.Light {} {place:?} {:?}>", self.kind(), self.color())
    }
}
