//! One picture of which several processes take parts.

use std::sync::{Arc, Mutex};

use lightmesh::distributed::{self, GatherBatch, PartialImage, PointRequests, WaveRequest};
use lightmesh::{Fingerprint, LightMesh};
use lightmesh_cli::{SOFTWARE, Stats};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::bricks::BrickArrays;
use crate::error::Raise;
use crate::gathering::PyGathering;
use crate::image::{Noise, PyImage, metadata};
use crate::job::{Job, JobError};
use crate::light_mesh::{self, PyLightMesh};
use crate::portions::{from_dict, outlines_of, samples, to_dict};
use crate::render::warn_of_non_finite;
use crate::scene::{LitScene, PyScene, scene_camera};
use crate::shared_mesh::SharedMesh;
use crate::work::{self, AtInterrupt, Watch};
use crate::{arrays, bricks, json, keywords, pool};

/// One picture that several processes render in parts, as lightmesh.cluster does.
///
/// The samples of a picture are waves, numbered from 0. Processes with the same scene, camera and options can each take
/// any of them, and the picture is that of Scene.render, bit for bit. Mesh points can be filled together before; a wave
/// fills those that it misses.
/// The options are those of Scene.render. Bricks are uint64, (n, 10): level, packed coordinates, then a bit for each of
/// 512 points.
#[pyclass(name = "PictureJob", module = "lightmesh", frozen)]
pub(crate) struct PyPictureJob {
    pub(crate) job: Arc<Job>,
    threads: Option<usize>,
}

#[pymethods]
impl PyPictureJob {
    #[new]
    #[pyo3(
        signature = (scene, *, camera=None, mesh=None, **options),
        text_signature = "(scene, *, camera=None, mesh=None, **options)"
    )]
    fn new(
        scene: &Bound<'_, PyScene>,
        camera: Option<&Bound<'_, PyAny>>,
        mesh: Option<&Bound<'_, PyLightMesh>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = scene.py();
        // Parse the options, light the scene and choose the camera.
        let chosen = keywords::chosen("PictureJob", options)?;
        let camera = scene_camera(scene.get().state().data(), camera)?;
        let LitScene { keywords, built } = light_mesh::lit_scene(scene, mesh, &chosen, Some(&camera))?;
        let options = keywords.options(&camera);
        options.check_picture_memory().map_err(|error| error.raise(py))?;

        // Make a mesh, unless there is one.
        let shared = mesh.map(|mesh| mesh.get().mesh.clone());
        let (theirs, mesh_options, eye) = (Arc::clone(&built), options.clone(), camera.clone());
        let made = work::run(py, keywords.threads(), None, AtInterrupt::Abandon, move |_| {
            let mesh = match shared {
                Some(mesh) => mesh,
                None => SharedMesh::new(LightMesh::for_cameras(&theirs.scene, &mesh_options, &[eye])?),
            };
            Ok((mesh, Fingerprint::of_scene(&theirs.scene)))
        })?;
        let (mesh, fingerprint) = made.map_err(|error: lightmesh::Error| error.raise(py))?;

        let origin = &scene.get().origin;
        let job = Job {
            name: origin.name.clone(),
            units: origin.units,
            files: Arc::clone(&origin.files),
            emitters: keywords.emitters().clone(),
            built,
            camera,
            options,
            mesh,
            prepared: Mutex::new(None),
            scene: fingerprint,
        };
        Ok(Self { job: Arc::new(job), threads: keywords.threads() })
    }

    /// The number of waves of the picture.
    #[getter]
    fn wave_count(&self, py: Python<'_>) -> PyResult<u64> {
        distributed::wave_count(&self.job.options).map_err(|error| error.raise(py))
    }

    /// The most levels that the meshes may have. Which points of a finer level are needed may only be known when those
    /// of the coarser one are filled.
    #[getter]
    fn level_count(&self, py: Python<'_>) -> PyResult<u32> {
        let levels = self.job.with_mesh(|mesh| Ok(mesh.level_count()));
        levels.map_err(|error| error.raise(py))
    }

    /// Whether there is a mesh of indirect light.
    #[getter]
    fn has_indirect(&self, py: Python<'_>) -> PyResult<bool> {
        self.job.with_mesh(|mesh| Ok(mesh.has_indirect())).map_err(|error| error.raise(py))
    }

    /// The number of diffuse interreflections; groups exchange levels from 0 to this.
    #[getter]
    fn bounces(&self) -> u32 {
        self.job.options.transport.bounces
    }

    /// (width, height), pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.job.options.picture.width, self.job.options.picture.height)
    }

    /// Every option and the camera's name, as a JSON object.
    #[getter]
    fn options_json(&self) -> String {
        self.job.settings()
    }

    /// 32 hexadecimal digits of the scene, the camera and all options: jobs of the same fingerprint make the same
    /// picture.
    #[getter]
    fn fingerprint(&self) -> String {
        let job = &self.job;
        let text = format!("{} {} {:?} {SOFTWARE}", job.scene, job.settings(), job.camera);
        Fingerprint::of_text(&text).to_string()
    }

    /// Prepares the mesh for the whole picture, as far as the options need that (error, refine, lod_distance). The other
    /// methods do it if it has not been done. Returns statistics, with the keys of the library's stats.
    #[pyo3(signature = (*, progress=None))]
    fn prepare<'py>(&self, py: Python<'py>, progress: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let stats = self.run(py, progress, |job, watch| job.with_prepared(watch, |_, prepared| Ok(prepared.stats)))?;
        json::parse(py, &json::written(serde_json::to_string(&stats))?)
    }

    /// Finds the mesh points that waves first to last (exclusive) read and that this process lacks. Returns those of
    /// the direct and those of the indirect mesh.
    #[pyo3(signature = (first, last, *, outlines=None, progress=None))]
    fn demand<'py>(
        &self,
        py: Python<'py>,
        first: u64,
        last: u64,
        outlines: Option<&Bound<'py, PyTuple>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<BrickArrays<'py>> {
        let outlines = outlines.map(outlines_of).transpose()?;
        let wanted = self.run(py, progress, move |job, watch| {
            job.with_prepared(watch, |mesh, prepared| {
                let samples = samples(outlines.as_ref());
                let request = WaveRequest { prepared, samples, waves: first..last };
                distributed::requested_points(&job.built.scene, &job.camera, &job.options, mesh, request, watch)
            })
        })?;
        Ok((bricks::to_array(py, &wanted.direct)?, bricks::to_array(py, &wanted.indirect)?))
    }

    /// Fills points of the direct mesh. Returns their values as bytes: uint8, (n,), for absorb.
    #[pyo3(signature = (bricks, *, progress=None))]
    fn fill_direct<'py>(
        &self,
        bricks: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let direct = bricks::from_array(bricks, "bricks")?;
        let bytes = self.run(bricks.py(), progress, move |job, watch| {
            let contents = job.with_mesh(|mesh| {
                distributed::fill_direct(&job.built.scene, &job.options, mesh, &direct, watch)?;
                mesh.snapshot_of(&PointRequests { direct, indirect: Vec::new() })
            })?;
            Ok(job.to_bytes(contents))
        })?;
        Ok(bytes.into_pyarray(bricks.py()))
    }

    /// Adds points that fill_direct or GatherBatch.contents returned. Points that the mesh has already stay as they are.
    fn absorb(&self, contents: &Bound<'_, PyAny>) -> PyResult<()> {
        let bytes = arrays::bytes(contents, "contents")?;
        self.run(contents.py(), None, move |job, _| {
            let file = lightmesh_io::mesh_from_bytes("contents", &bytes, job.options.limits.max_memory);
            let file = file.map_err(JobError::File)?;
            file.check("contents".as_ref(), job.scene, &job.options).map_err(JobError::File)?;
            job.with_mesh(|mesh| mesh.merge(&file.contents))
        })
    }

    /// Begins to gather light for points of the indirect mesh: shoots their rays, and finds the points that these read.
    #[pyo3(signature = (bricks, *, progress=None))]
    fn gather(&self, bricks: &Bound<'_, PyAny>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<PyGathering> {
        let points = bricks::from_array(bricks, "bricks")?;
        let gathering = self.run(bricks.py(), progress, move |job, watch| {
            job.with_mesh(|mesh| GatherBatch::new(&job.built.scene, &job.options, mesh, &points, watch))
        })?;
        Ok(PyGathering::new(Arc::clone(&self.job), self.threads, gathering))
    }

    /// Renders waves first to last (exclusive). Returns a dict with first, last, values (float32: the sums of light and
    /// layers in each pixel), seen (uint8: which emitters the samples saw) and stats (JSON).
    #[pyo3(signature = (first, last, *, outlines=None, progress=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        first: u64,
        last: u64,
        outlines: Option<&Bound<'py, PyTuple>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let outlines = outlines.map(outlines_of).transpose()?;
        let portion = self.run(py, progress, move |job, watch| {
            job.with_prepared(watch, |mesh, prepared| {
                let samples = samples(outlines.as_ref());
                let request = WaveRequest { prepared, samples, waves: first..last };
                distributed::render_waves(&job.built.scene, &job.camera, &job.options, mesh, request, watch)
            })
        })?;
        to_dict(py, portion)
    }

    /// Finds the pixels on outlines of emitters, whose samples are to be taken anew, once all waves are rendered.
    /// Returns what was seen there and the number of waves; None if there are no such pixels.
    fn outlines<'py>(
        &self,
        py: Python<'py>,
        portions: Vec<Bound<'py, PyDict>>,
    ) -> PyResult<Option<(Bound<'py, PyArray1<u8>>, u64)>> {
        let taken: Vec<PartialImage> = portions.iter().map(from_dict).collect::<PyResult<_>>()?;
        let outlines = self.run(py, None, move |job, _| {
            Ok(distributed::find_emitter_edges(&job.built.scene, &job.camera, &job.options, &taken)?)
        })?;
        Ok(outlines.map(|outlines| (outlines.emitter_seen.into_pyarray(py), outlines.waves)))
    }

    /// Assembles the picture from all waves and those of the outlines.
    #[pyo3(signature = (portions, outlines=None, outline_portions=Vec::new()), text_signature = "($self, portions, outlines=None, outline_portions=())")]
    fn assemble<'py>(
        &self,
        py: Python<'py>,
        portions: Vec<Bound<'py, PyDict>>,
        outlines: Option<&Bound<'py, PyTuple>>,
        outline_portions: Vec<Bound<'py, PyDict>>,
    ) -> PyResult<PyImage> {
        let taken: Vec<PartialImage> = portions.iter().map(from_dict).collect::<PyResult<_>>()?;
        let anew: Vec<PartialImage> = outline_portions.iter().map(from_dict).collect::<PyResult<_>>()?;
        let outlines = outlines.map(outlines_of).transpose()?;
        let job = &self.job;
        let frame = self.run(py, None, move |job, _| {
            let anew = outlines.as_ref().map(|outlines| (outlines, anew.as_slice()));
            Ok(distributed::merge_images(&job.built.scene, &job.camera, &job.options, &taken, anew)?)
        })?;
        warn_of_non_finite(py, &frame)?;
        let stats = pool::detached(py, || {
            let stats = Stats::new(job.name.clone(), &job.built.scene, &job.options, &frame.stats);
            serde_json::to_string(&stats)
        })?;
        let metadata = metadata(&job.name, &job.options, &job.emitters, job.units, &job.camera);
        let noise = Noise::of(&job.options, &job.built.scene);
        Ok(PyImage::of_frame(frame, metadata, json::written(stats)?, Arc::clone(&job.files), noise))
    }

    fn __repr__(&self) -> String {
        let Job { name, options, .. } = &*self.job;
        format!(
            "<lightmesh.PictureJob {}x{} of {name:?} {}>",
            options.picture.width, options.picture.height, options.method
        )
    }
}

impl PyPictureJob {
    fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        callback: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Job, &Watch) -> Result<T, JobError> + Send + 'static,
    ) -> PyResult<T> {
        let job = Arc::clone(&self.job);
        let done = work::run(py, self.threads, callback, AtInterrupt::Wait, move |watch| work(&job, watch))?;
        done.map_err(|error| error.raise(py))
    }
}
