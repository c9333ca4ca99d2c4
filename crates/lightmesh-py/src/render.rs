//! Pictures of scenes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lightmesh::{Camera, Frame, LightMesh};
use lightmesh_cli::{Stats, non_finite_message};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

use crate::error::Raise;
use crate::image::{PyImage, metadata};
use crate::light_mesh::PyLightMesh;
use crate::scene::{LitScene, PyScene};
use crate::work::{self, AtInterrupt, Watch};
use crate::{json, shared_mesh};

/// Renders on a thread of its own, with a mesh that is kept or with one for this picture only.
pub(crate) fn render(
    py: Python<'_>,
    scene: &PyScene,
    lit: LitScene,
    camera: Camera,
    mesh: Option<&PyLightMesh>,
    callback: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyImage> {
    let LitScene { keywords, built } = lit;
    let options = keywords.options(&camera);
    options.check_picture_memory().map_err(|error| error.raise(py))?;
    let origin = &scene.origin;
    let metadata = metadata(&origin.name, &options, keywords.emitters(), origin.units, &camera);

    // Render, and time it.
    let (name, load_time) = (origin.name.clone(), origin.load_time);
    let mesh = mesh.map(|mesh| mesh.mesh.clone());
    let work = move |watch: &Watch| {
        let started = Instant::now();
        let render = |mesh: &mut LightMesh| lightmesh::render(&built.scene, &camera, &options, mesh, watch);
        let frame = match &mesh {
            None => LightMesh::for_cameras(&built.scene, &options, std::slice::from_ref(&camera))
                .and_then(|mut mesh| render(&mut mesh)),
            Some(shared) => render(&mut *shared.lock()?),
        };
        Some(frame.map(|frame| {
            let total = load_time + built.time + started.elapsed();
            let stats = Stats::new(name, &built.scene, &options, &frame.stats);
            let stats = stats.with_seconds(load_time, built.time, Duration::ZERO, total);
            (frame, serde_json::to_string(&stats))
        }))
    };
    let rendered = work::run(py, keywords.threads(), callback, AtInterrupt::Wait, work)?;

    let (frame, stats) = rendered.ok_or_else(|| shared_mesh::in_use(py))?.map_err(|error| error.raise(py))?;
    warn_of_non_finite(py, &frame)?;
    Ok(PyImage::of_frame(frame, metadata, json::written(stats)?, Arc::clone(&origin.files)))
}

/// Warns (`RuntimeWarning`) if pixels are black because they were no numbers.
pub(crate) fn warn_of_non_finite(py: Python<'_>, frame: &Frame) -> PyResult<()> {
    let Some(message) = non_finite_message(&frame.stats, &frame.image) else { return Ok(()) };
    let message = std::ffi::CString::new(message)?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 1)
}
