//! Light where no camera looks.

use lightmesh::{LightMesh, Measured, Meter, RenderOptions};
use lightmesh_cli::WorkStats;
use pyo3::prelude::*;

use crate::error::Raise;
use crate::listener::Listener;
use crate::scene::{LitScene, relative};
use crate::shared_mesh::{self, SharedMesh};
use crate::work::{self, AtInterrupt, Watch};
use crate::{arrays, json};

/// What meters read, and the statistics as JSON.
pub(crate) struct Reading {
    measured: Measured,
    stats: String,
}

/// Measures on a thread of its own, with a mesh that is kept or with one for these meters only.
pub(crate) fn measure(
    py: Python<'_>,
    lit: LitScene,
    options: RenderOptions,
    meters: Vec<Meter>,
    mesh: Option<&SharedMesh>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Reading> {
    let LitScene { keywords, built } = lit;
    let here = |meter: &Meter| Meter { position: relative(built.scene.data(), meter.position), ..*meter };
    let meters: Vec<Meter> = meters.iter().map(here).collect();
    let mesh = mesh.cloned();
    let listener = Listener::new(py, progress)?;
    let work = move |watch: &Watch| {
        let measure = |mesh: &mut LightMesh| {
            let measured = lightmesh::measure(&built.scene, &meters, &options, mesh, watch)?;
            let stats = serde_json::to_string(&WorkStats::new(&options, &measured.stats));
            Ok((measured, stats))
        };
        match &mesh {
            None => Some(LightMesh::new(&built.scene, &options).and_then(|mut mesh| measure(&mut mesh))),
            Some(shared) => shared.lock().map(|mut mesh| measure(&mut mesh)),
        }
    };

    // Listen to progress until it is done.
    let done = work::run(py, keywords.threads(), listener.callback(), AtInterrupt::Wait, work);
    let done = listener.close(done)?.ok_or_else(|| shared_mesh::in_use(py))?;
    let (measured, stats) = done.map_err(|error: lightmesh::Error| error.raise(py))?;
    Ok(Reading { measured, stats: json::written(stats)? })
}

impl Reading {
    /// Returns the light that comes straight from lights, (n, 3), lux.
    pub(crate) fn direct(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        arrays::from_colors(py, self.measured.direct)
    }

    /// Returns the light that surfaces have reflected, (n, 3), lux.
    pub(crate) fn indirect(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        arrays::from_colors(py, self.measured.indirect)
    }

    /// Returns the sum of both, (n, 3), lux.
    pub(crate) fn irradiance(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let Measured { mut direct, indirect, .. } = self.measured;
        direct.iter_mut().zip(&indirect).for_each(|(direct, indirect)| *direct += *indirect);
        arrays::from_colors(py, direct)
    }

    /// Returns both and the statistics, as `lightmesh.Measured`.
    pub(crate) fn into_measured(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let Measured { direct, indirect, .. } = self.measured;
        let (direct, indirect) = (arrays::from_colors(py, direct)?, arrays::from_colors(py, indirect)?);
        let class = py.import("lightmesh._measured")?.getattr("Measured")?;
        class.call1((direct, indirect, json::parse(py, &self.stats)?))
    }
}
