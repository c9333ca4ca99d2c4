//! Meshes of light that outlive pictures.

use std::sync::{Arc, Mutex};

use lightmesh::LightMesh;
use lightmesh_cli::{Keywords, MeshesStats};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::built::Built;
use crate::error::{self, Raise};
use crate::image::from_json;
use crate::keywords::{self, Pairs};
use crate::scene::PyScene;
use crate::work::{self, AtInterrupt};

/// Light at points in space, computed where pictures first ask for it and kept from one to the next.
///
/// scene: what it belongs to; when that is changed, the mesh no longer serves it.
/// The options are those of Scene.render; the ones that decide about the mesh (method, bounces, spacings, interpolation, weight, falloffs,
/// refine, graded, error, light_error, gather_rays, seed, and what lights the scene) cannot be changed afterwards, and all of them
/// hold for pictures with this mesh that do not say otherwise.
///
/// >>> mesh = LightMesh(scene, spacing="1/80")
/// >>> pictures = [scene.render(camera=camera, mesh=mesh) for camera in scene.cameras]
#[pyclass(name = "LightMesh", module = "lightmesh", frozen)]
pub(crate) struct PyLightMesh {
    scene: Py<PyScene>,
    /// Of the scene when the mesh was made.
    revision: u64,
    chosen: Pairs,
    /// Keeps the scene that the mesh was made for.
    built: Arc<Built>,
    pub(crate) mesh: Arc<Mutex<LightMesh>>,
}

#[pymethods]
impl PyLightMesh {
    #[new]
    #[pyo3(
        signature = (scene, **options),
        text_signature = "(scene, *, size=None, method='mesh', spp=None, time_limit=None, bounces=3, error=None, depth=8, cutoff=0.001, falloff='r2', light_error=0.01, seed=0, environment=None, environment_strength=1.0, environment_rotation=0.0, light_samples=64, light_radius=0.0, spacing='auto', indirect_spacing='auto', gather_rays=256, refine=None, graded=None, rays=4, interpolation='auto', weight='constant', field_falloff='r2', paper_scale='visibility', aov=None, threads=None, max_memory='4GiB')"
    )]
    fn new(scene: &Bound<'_, PyScene>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let py = scene.py();
        let chosen = keywords::pairs("LightMesh", options)?;
        let keywords = keywords::parse(py, &chosen)?;
        let options = keywords.mesh_options();
        if !options.method.has_mesh() {
            return Err(error::option(py, "method: standard and path have no mesh"));
        }
        let revision = scene.get().revision();
        let built = scene.get().built(py, &keywords)?;
        let theirs = Arc::clone(&built);
        let mesh = work::run(py, keywords.threads(), None, AtInterrupt::Abandon, move |_| {
            LightMesh::new(&theirs.scene, &options)
        })?;
        let mesh = mesh.map_err(|error| error.raise(py))?;
        Ok(Self { scene: scene.clone().unbind(), revision, chosen, built, mesh: Arc::new(Mutex::new(mesh)) })
    }

    /// The scene that it belongs to.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<PyScene> {
        self.scene.clone_ref(py)
    }

    /// What it holds, as the key "mesh" of an image's stats: for "direct" and "indirect" spacing_m (metres), points_used,
    /// points_refined, points_total, points_invalid and bytes.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let stats = py.detach(|| match self.mesh.try_lock() {
            Ok(mesh) => Some(MeshesStats::of(&mesh)),
            Err(_) => None,
        });
        let stats = stats.ok_or_else(|| error::general(py, IN_USE))?;
        from_json(py, &serde_json::to_string(&stats).map_err(|error| error::internal(&error.to_string()))?)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let scene = self.scene.get().name.clone();
        let points = py.detach(|| self.mesh.try_lock().ok().map(|mesh| mesh.stats().points_used));
        let points = points.map_or("in use".to_owned(), |points| format!("{points} points of direct light"));
        format!("<lightmesh.LightMesh of {scene:?}, {points}>")
    }
}

/// What is said of a mesh that another thread renders with, or that was left in pieces.
pub(crate) const IN_USE: &str = "mesh: another thread renders with it, or failed inside while it did";

impl PyLightMesh {
    /// The options of a picture with this mesh, and the scene as the mesh knows it.
    pub(crate) fn keywords_and_scene(
        &self,
        scene: &Bound<'_, PyScene>,
        chosen: &Pairs,
    ) -> PyResult<(Keywords, Arc<Built>)> {
        let py = scene.py();
        if !self.scene.is(scene) {
            return Err(error::option(py, "mesh: belongs to another scene"));
        }
        if self.revision != scene.get().revision() {
            return Err(error::option(py, "mesh: the scene was changed since it was made; make a new one"));
        }
        let keywords = keywords::parse(py, &keywords::over(&self.chosen, chosen))?;
        if *keywords.emitters() != self.built.emitters {
            let what = "mesh: was made for another environment, light_samples or light_radius";
            return Err(error::option(py, what));
        }
        Ok((keywords, Arc::clone(&self.built)))
    }
}
