//! The methods of LightMesh.

use std::path::PathBuf;
use std::sync::Arc;

use lightmesh::{LightMesh, Method};
use lightmesh_cli::MeshesStats;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{self, Raise};
use crate::light_mesh::{Part, PyLightMesh, PyMeshArrays, Target};
use crate::listener::Listener;
use crate::scene::{LitScene, PyScene, scene_camera};
use crate::work::{self, AtInterrupt};
use crate::{arrays, json, keywords, mesh_files, output};

#[pymethods]
impl PyLightMesh {
    #[new]
    #[pyo3(
        signature = (scene, *, cameras=None, **options),
        text_signature = "(scene, *, cameras=None, size=None, method='mesh', quality=None, spp=None, most_spp=None, time_limit=None, bounces=3, error=None, depth=8, cutoff=0.001, falloff='r2', light_error=0.01, seed=0, environment=None, environment_strength=1.0, environment_rotation=0.0, light_samples=64, light_radius=0.0, spacing='auto', indirect_spacing='auto', gather_rays=None, near_rays=None, refine=None, lod_distance=None, rays=4, interpolation='auto', weight='constant', field_falloff='r2', paper_scale='visibility', aov=None, threads=None, max_memory=None)"
    )]
    fn new(
        scene: &Bound<'_, PyScene>,
        cameras: Option<Vec<Option<Bound<'_, PyAny>>>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let py = scene.py();
        let mut chosen = keywords::chosen("LightMesh", options)?;
        // What the points of a mesh know by themselves; with an error or a quality, or None, that of the method auto.
        if !options.is_some_and(|options| options.contains("method").unwrap_or(false)) {
            chosen.prefer_method(Method::MESH);
        }
        Self::with(scene, chosen, |LitScene { keywords, built }| {
            let (options, built) = (keywords.mesh_options(), Arc::clone(built));
            let cameras = cameras.map(|cameras| {
                let cameras = cameras.iter().map(|camera| scene_camera(built.scene.data(), camera.as_ref()));
                cameras.collect::<PyResult<Vec<_>>>()
            });
            let cameras = cameras.transpose()?;
            let make = move |_: &work::Watch| match cameras {
                Some(cameras) => LightMesh::for_cameras(&built.scene, &options, &cameras),
                None => LightMesh::new(&built.scene, &options),
            };
            work::run(py, keywords.threads(), None, AtInterrupt::Abandon, make)?.map_err(|error| error.raise(py))
        })
    }

    /// Reads a file that save has written: the mesh goes on where that one was.
    ///
    /// scene: the one that it was made for, or an equal one, loaded or lit the same way; another is a SceneError.
    /// Options that are not given and decide about the mesh are the file's, but for an environment that is itself a
    /// file. A mesh made with others is an OptionError, but bounces may be fewer.
    #[staticmethod]
    #[pyo3(
        signature = (path, scene, **options),
        text_signature = "(path, scene, *, size=None, method=None, quality=None, spp=None, most_spp=None, time_limit=None, bounces=None, error=None, depth=None, cutoff=0.001, falloff=None, light_error=None, seed=None, environment=None, environment_strength=None, environment_rotation=None, light_samples=None, light_radius=None, spacing=None, indirect_spacing=None, gather_rays=None, near_rays=None, refine=None, lod_distance=None, rays=None, interpolation=None, weight=None, field_falloff=None, paper_scale=None, aov=None, threads=None, max_memory=None)"
    )]
    fn load(path: PathBuf, scene: &Bound<'_, PyScene>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let py = scene.py();
        let file = mesh_files::open(py, path, &keywords::chosen("load", options)?)?;
        let chosen = file.chosen.clone();
        Self::with(scene, chosen, |lit| file.into_mesh(py, lit))
    }

    /// Writes all that the mesh knows, and its settings: safetensors, which other programs read too. The file appears
    /// whole or not at all; it may be the one that the mesh was loaded from, but none of the scene's (OptionError).
    ///
    /// progress: as for Scene.render, in bytes.
    #[pyo3(signature = (path, *, progress=None))]
    fn save(&self, py: Python<'_>, path: PathBuf, progress: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let lit = self.own_scene(py)?;
        let listener = Listener::new(py, progress)?;
        let origin = &self.scene.get().origin;
        output::spare(py, &path, &origin.files)?;
        let units = origin.units;
        listener.close(mesh_files::save(py, path, lit, self.mesh.clone(), units, listener.callback()))
    }

    /// Evaluates mesh points ahead of time. Later reads give the same values, and shoot no rays for these points.
    ///
    /// points: (N, 3), metres: all mesh points that meters there read, whichever way they face.
    /// region: instead of them the least and the largest corner of a box, (2, 3), metres: all mesh points in it, of
    /// both meshes; surfaces in it read points up to a spacing further out.
    /// progress: as for Scene.render, in mesh points.
    ///
    /// Returns statistics, as the stats of measure.
    #[pyo3(signature = (points=None, *, region=None, progress=None))]
    fn fill<'py>(
        &self,
        py: Python<'py>,
        points: Option<&Bound<'py, PyAny>>,
        region: Option<&Bound<'py, PyAny>>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let target = match (points, region) {
            (Some(points), None) => Target::Around(arrays::finite_vec3s(points, "points")?),
            (None, Some(region)) => Target::Box(arrays::region(region, "region")?),
            _ => return Err(PyTypeError::new_err("fill() takes either points or region")),
        };
        json::parse(py, &self.fill_target(py, target, progress)?)
    }

    /// Measures the irradiance at meters, direct and indirect light together: (N, 3), lux per channel, float32.
    ///
    /// positions: (N, 3), metres; on surfaces or in the open. normals: (N, 3), or (3,) for all, of any length: which
    /// way they face. Each gets what a surface in its place would get in a picture, from the hemisphere that it faces.
    /// progress: as for Scene.render, in meters.
    ///
    /// What a meter reads depends on its place and direction alone, bit for bit. Meters outside Scene.bounds, where no
    /// mesh is, shoot rays of their own. error, refine and lod_distance follow a picture: a mesh that was made with them
    /// cannot measure, which is an OptionError.
    #[pyo3(signature = (positions, normals, *, progress=None))]
    fn irradiance<'py>(
        &self,
        positions: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.read(positions, normals, progress, None)?.irradiance(positions.py())
    }

    /// Measures the irradiance that comes straight from lights: (N, 3), lux per channel, float32. The indirect mesh
    /// stays as it is, but for scenes with emission that only gather rays find.
    #[pyo3(signature = (positions, normals, *, progress=None))]
    fn direct<'py>(
        &self,
        positions: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.read(positions, normals, progress, Some(0))?.direct(positions.py())
    }

    /// Measures the irradiance that surfaces have reflected: (N, 3), lux per channel, float32. To get both parts, call
    /// measure once.
    #[pyo3(signature = (positions, normals, *, progress=None))]
    fn indirect<'py>(
        &self,
        positions: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.read(positions, normals, progress, None)?.indirect(positions.py())
    }

    /// Measures both parts of irradiance. Returns a Measured, which is a tuple (direct, indirect, stats).
    #[pyo3(signature = (positions, normals, *, progress=None))]
    fn measure<'py>(
        &self,
        positions: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.read(positions, normals, progress, None)?.into_measured(positions.py())
    }

    /// The scene that it belongs to.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<PyScene> {
        self.scene.clone_ref(py)
    }

    /// Statistics of the mesh, as the key "mesh" of an image's stats: for "direct" and "indirect" spacing_m (metres),
    /// points_used, points_refined, points_total, points_invalid and bytes.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let stats = self.with_mesh(py, MeshesStats::of)?;
        json::parse(py, &json::written(serde_json::to_string(&stats))?)
    }

    /// Spacing of the direct mesh, metres; level l has it divided by 2**l.
    #[getter]
    fn spacing(&self, py: Python<'_>) -> PyResult<f64> {
        self.with_mesh(py, |mesh| mesh.stats().spacing_m)
    }

    /// Spacing of the indirect mesh, metres; None if there is no indirect mesh.
    #[getter]
    fn indirect_spacing(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        self.with_mesh(py, |mesh| Some(mesh.indirect_stats().spacing_m).filter(|&spacing| spacing > 0.0))
    }

    /// Points of the direct mesh that have been evaluated: (N, 3), metres, float32. Their order means nothing, but that
    /// of values, valid and levels is the same. Arrays of a mesh cannot be written to, and keep what they show while
    /// the mesh learns more.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyMeshArrays::points(&self.snapshot(py)?, Part::Direct)
    }

    /// Values of the points of the direct mesh, float32; NaN for points that give no light (see valid).
    ///
    /// Of method "mesh" (N, 6, 2, 3), lux: by point, for planes that face +x, -x, +y, -y, +z, -z, the irradiance that
    /// arrives, and the one that would if nothing were in the way. Of "paper" (N, 2, 3): formula (1) of the paper, and
    /// what it is divided by.
    /// Points of "hybrid" and "unbiased" know of each light whether they see it, and no irradiance: they have no
    /// values, which is an OptionError; irradiance measures there.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = PyMeshArrays::values(&self.snapshot(py)?, Part::Direct)?;
        values.ok_or_else(|| {
            let message =
                "values: with hybrid, unbiased and error points know which lights they see, and no irradiance; use irradiance()";
            error::option(py, message)
        })
    }

    /// Whether points of the direct mesh give light: (N,), bool; those that do not were found in solids or on surfaces.
    #[getter]
    fn valid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyMeshArrays::valid(&self.snapshot(py)?, Part::Direct)
    }

    /// Levels of the points of the direct mesh: (N,), uint8; all 0 without refine, lod_distance and error.
    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyMeshArrays::levels(&self.snapshot(py)?, Part::Direct)
    }

    /// Points of the indirect mesh that have been evaluated: (N, 3), metres, float32, as for points.
    #[getter]
    fn indirect_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyMeshArrays::points(&self.snapshot(py)?, Part::Indirect)
    }

    /// Values of the points of the indirect mesh, after its bounces: (N, 6, 3), lux, float32: by point the irradiance
    /// on planes that face +x, -x, +y, -y, +z, -z. Of method "paper" (N, 3): formula (4), four times the irradiance on
    /// any plane were the light even. NaN for points that give none.
    #[getter]
    fn indirect_values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = PyMeshArrays::values(&self.snapshot(py)?, Part::Indirect)?;
        values.ok_or_else(|| error::internal("indirect light has no values"))
    }

    /// Whether points of the indirect mesh give light: (N,), bool.
    #[getter]
    fn indirect_valid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyMeshArrays::valid(&self.snapshot(py)?, Part::Indirect)
    }

    /// Levels of the points of the indirect mesh: (N,), uint8.
    #[getter]
    fn indirect_levels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyMeshArrays::levels(&self.snapshot(py)?, Part::Indirect)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let scene = &self.scene.get().origin.name;
        let points = py.detach(|| self.mesh.lock().map(|mesh| mesh.stats().points_used));
        let points = points.map_or("in use".to_owned(), |points| format!("{points} points of direct light"));
        format!("<lightmesh.LightMesh of {scene:?}, {points}>")
    }
}
