//! Pictures of scenes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lightmesh::{Camera, Frame, LightMesh};
use lightmesh_cli::{Denoise, Stats, non_finite_message};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;

use crate::error::Raise;
use crate::image::{Noise, PyImage, metadata};
use crate::light_mesh::PyLightMesh;
use crate::scene::{LitScene, PyScene};
use crate::work::{self, AtInterrupt, Watch};
use crate::{denoise, json, shared_mesh};

/// Renders on a thread of its own, with a mesh that is kept or with one for this picture only.
pub(crate) fn render(
    py: Python<'_>,
    scene: &PyScene,
    lit: LitScene,
    camera: Camera,
    mesh: Option<&PyLightMesh>,
    denoise: bool,
    callback: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyImage> {
    let LitScene { keywords, built } = lit;
    let mut options = keywords.options(&camera);
    let origin = &scene.origin;
    let mut metadata = metadata(&origin.name, &options, keywords.emitters(), origin.units, &camera);

    // Load the denoiser before there is work that would be lost without it, and check memory.
    let denoise = if denoise { denoise::prepare(py, &mut options)? } else { None };
    options.check_picture_memory().map_err(|error| error.raise(py))?;
    if let Some(denoise) = &denoise {
        denoise.check_memory(&options, built.scene.bytes()).map_err(|error| error.raise(py))?;
    }
    let wants_denoised = denoise.is_some();
    let (method, noise) = (options.method, Noise::of(&options, &built.scene));

    // Render, take the noise out, and time it.
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
        let finish = |mut frame: Frame| {
            let apply = |denoise: Denoise| denoise.apply(&mut frame, &built.scene, &options, watch);
            let denoised = denoise.map(apply).transpose()?.flatten();
            let total = load_time + built.time + started.elapsed();
            let stats = Stats::new(name, &built.scene, &options, &frame.stats).with_denoised(denoised.as_ref());
            let stats = stats.with_seconds(load_time, built.time, Duration::ZERO, total);
            Ok::<_, lightmesh_denoise::Error>((frame, serde_json::to_string(&stats), denoised))
        };
        Some(frame.map(finish))
    };
    let rendered = work::run(py, keywords.threads(), callback, AtInterrupt::Wait, work)?;

    let finished = rendered.ok_or_else(|| shared_mesh::in_use(py))?.map_err(|error| error.raise(py))?;
    let (frame, stats, denoised) = finished.map_err(|error| error.raise(py))?;
    warn_of_non_finite(py, &frame)?;
    if wants_denoised && denoised.is_none() {
        denoise::warn_of_no_noise(py, method)?;
    }
    metadata.denoised = denoised;
    Ok(PyImage::of_frame(frame, metadata, json::written(stats)?, Arc::clone(&origin.files), noise))
}

/// Warns (`RuntimeWarning`) if pixels are black because they were no numbers.
pub(crate) fn warn_of_non_finite(py: Python<'_>, frame: &Frame) -> PyResult<()> {
    let Some(message) = non_finite_message(&frame.stats, &frame.image) else { return Ok(()) };
    let message = std::ffi::CString::new(message)?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 1)
}
