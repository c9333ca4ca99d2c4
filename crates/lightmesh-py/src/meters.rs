//! Light where no camera looks.

use std::sync::{Arc, Mutex};

use lightmesh::{LightMesh, Measured, Meter, RenderOptions};
use lightmesh_cli::{Keywords, WorkStats};
use pyo3::prelude::*;

use crate::built::Built;
use crate::error::{self, Raise};
use crate::image::from_json;
use crate::light_mesh::{self, IN_USE};
use crate::work::{self, AtInterrupt};
use crate::{arrays, listener::Listener};

/// What meters read, and in which thread pool: its statistics as JSON.
pub(crate) struct Reading {
    measured: Measured,
    stats: String,
}

/// Measures in a thread of its own, with a mesh of its own or with one that is kept.
pub(crate) fn measure(
    py: Python<'_>,
    (built, keywords, options): (Arc<Built>, &Keywords, RenderOptions),
    meters: Vec<Meter>,
    mesh: Option<&Arc<Mutex<LightMesh>>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Reading> {
    let mesh = mesh.map(Arc::clone);
    let listener = Listener::new(py, progress)?;
    let work = move |watch: &work::Watch| {
        let measure = |mesh: &mut LightMesh| {
            let measured = lightmesh::measure(&built.scene, &meters, &options, mesh, watch)?;
            let stats = WorkStats::new(&options, &measured.stats);
            Ok((measured, stats))
        };
        match &mesh {
            None => Some(LightMesh::new(&built.scene, &options).and_then(|mut mesh| measure(&mut mesh))),
            Some(shared) => light_mesh::lock(shared).map(|mut mesh| measure(&mut mesh)),
        }
    };
    let done = work::run(py, keywords.threads(), listener.callback(), AtInterrupt::Wait, work);
    let done = listener.close(done)?.ok_or_else(|| error::general(py, IN_USE))?;
    let (measured, stats) = done.map_err(|error| error.raise(py))?;
    let stats = serde_json::to_string(&stats).map_err(|error| error::internal(&error.to_string()))?;
    Ok(Reading { measured, stats })
}

impl Reading {
    /// From lights, (n, 3), lux.
    pub(crate) fn direct(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        arrays::from_colors(py, self.measured.direct)
    }

    /// After reflections, (n, 3), lux.
    pub(crate) fn indirect(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        arrays::from_colors(py, self.measured.indirect)
    }

    /// Both together, (n, 3), lux.
    pub(crate) fn irradiance(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let Measured { mut direct, indirect, .. } = self.measured;
        direct.iter_mut().zip(&indirect).for_each(|(direct, indirect)| *direct += *indirect);
        arrays::from_colors(py, direct)
    }

    /// All of it, as `lightmesh.Measured`.
    pub(crate) fn into_measured(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let Measured { direct, indirect, .. } = self.measured;
        let (direct, indirect) = (arrays::from_colors(py, direct)?, arrays::from_colors(py, indirect)?);
        let class = py.import("lightmesh._measured")?.getattr("Measured")?;
        class.call1((direct, indirect, from_json(py, &self.stats)?))
    }
}
