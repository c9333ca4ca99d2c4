//! Light meshes that outlive pictures: the class and its state. `methods` has what Python calls.

mod arrays;
mod fill;

use std::sync::{Arc, Mutex};

use lightmesh::{Camera, LightMesh};
use lightmesh_cli::Chosen;
use pyo3::prelude::*;

pub(crate) use self::arrays::{Part, PyMeshArrays};
pub(crate) use self::fill::Target;
use crate::built::Built;
use crate::keywords::Keywords;
use crate::scene::{LitScene, PyScene};
use crate::shared_mesh::{self, SharedMesh};
use crate::work::locked;
use crate::{arrays as numbers, error, meters, pool};

/// Light at points in space, computed where pictures or meters first ask for it and kept from one to the next.
///
/// scene: what it belongs to; when that is changed, the mesh no longer serves it.
/// The options are those of Scene.render; the ones that decide about the mesh (method, bounces, spacings,
/// interpolation, weight, falloffs, refine, lod_distance, error, light_error, gather_rays, seed, and what lights the scene)
/// cannot be changed afterwards, and all of them hold for pictures with this mesh that do not say otherwise.
///
/// >>> mesh = LightMesh(scene, spacing="1/80")
/// >>> pictures = [scene.render(camera=camera, mesh=mesh) for camera in scene.cameras]
/// >>> lux = mesh.irradiance([[0, 0.85, 0]], [0, 1, 0])
///
/// Every method ends soon after Ctrl-C, and then the mesh keeps what it has learned. One thread at a time works with a
/// mesh: another one does not wait but gets an Error, and so does a process that is forked meanwhile. Give each thread a
/// mesh of its own, or a lock around the one that they share.
#[pyclass(name = "LightMesh", module = "lightmesh", frozen)]
pub(crate) struct PyLightMesh {
    pub(crate) scene: Py<PyScene>,
    /// Of the scene when the mesh was made.
    revision: u64,
    chosen: Chosen,
    /// Keeps the scene that the mesh was made for.
    built: Arc<Built>,
    pub(crate) mesh: SharedMesh,
    /// The arrays that Python last asked for.
    arrays: Mutex<Option<Py<PyMeshArrays>>>,
}

/// Parses the options of a picture by the camera, or of meters, with a mesh or without, and lights the scene as they say.
pub(crate) fn lit_scene(
    scene: &Bound<'_, PyScene>,
    mesh: Option<&Bound<'_, PyLightMesh>>,
    chosen: &Chosen,
    camera: Option<&Camera>,
) -> PyResult<LitScene> {
    if let Some(mesh) = mesh {
        return mesh.get().lit_scene(scene, chosen);
    }
    let keywords = Keywords::new(scene.py(), chosen)?;
    let built = scene.get().lit(scene.py(), &keywords, camera)?;
    Ok(LitScene { keywords: keywords.for_scene(&built.scene), built })
}

impl PyLightMesh {
    /// Makes an object of the mesh that `make` returns.
    pub(crate) fn with(
        scene: &Bound<'_, PyScene>,
        chosen: Chosen,
        make: impl FnOnce(&LitScene) -> PyResult<LightMesh>,
    ) -> PyResult<Self> {
        let py = scene.py();
        let keywords = Keywords::new(py, &chosen)?;
        if !keywords.mesh_options().method.has_mesh() {
            return Err(error::option(py, "method: standard and path have no mesh"));
        }
        let revision = scene.get().revision();
        let built = scene.get().lit(py, &keywords, None)?;
        let lit = LitScene { keywords: keywords.for_scene(&built.scene), built };
        let mesh = SharedMesh::new(make(&lit)?);
        let scene = scene.clone().unbind();
        Ok(Self { scene, revision, chosen, built: lit.built, mesh, arrays: Mutex::new(None) })
    }

    /// Returns the options of a picture with this mesh, and the scene that the mesh was made for.
    fn lit_scene(&self, scene: &Bound<'_, PyScene>, chosen: &Chosen) -> PyResult<LitScene> {
        let py = scene.py();
        if !self.scene.is(scene) {
            return Err(error::option(py, "mesh: belongs to another scene"));
        }
        if self.revision != scene.get().revision() {
            return Err(error::option(py, "mesh: the scene was changed since it was made; make a new one"));
        }
        let keywords = Keywords::new(py, &self.chosen.over(chosen))?;
        if *keywords.emitters() != self.built.emitters {
            let message = "mesh: was made for another environment, light_samples or light_radius";
            return Err(error::option(py, message));
        }
        Ok(LitScene { keywords: keywords.for_scene(&self.built.scene), built: Arc::clone(&self.built) })
    }

    /// Returns the mesh's own options, and the scene that it was made for.
    pub(crate) fn own_scene(&self, py: Python<'_>) -> PyResult<LitScene> {
        self.lit_scene(self.scene.bind(py), &Chosen::default())
    }

    /// Reads the mesh as it is.
    pub(crate) fn with_mesh<T: Send>(&self, py: Python<'_>, read: impl FnOnce(&LightMesh) -> T + Send) -> PyResult<T> {
        let result = pool::detached(py, || self.mesh.lock().map(|mesh| read(&mesh)))?;
        result.ok_or_else(|| shared_mesh::in_use(py))
    }

    /// Measures what arrives at meters; after `bounces` reflections instead of the mesh's own, where that is given.
    pub(crate) fn read<'py>(
        &self,
        positions: &Bound<'py, PyAny>,
        normals: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
        bounces: Option<u32>,
    ) -> PyResult<meters::Reading> {
        let py = positions.py();
        let meters = numbers::meters(positions, normals)?;
        let lit = self.own_scene(py)?;
        let options = lit.keywords.mesh_options();
        let bounces = bounces.unwrap_or(options.transport.bounces);
        let options = options.with(|o| o.transport.bounces = bounces);
        meters::measure(py, lit, options, meters, Some(&self.mesh), progress)
    }

    /// Returns the mesh's points and values as arrays; the same ones as before unless the mesh has changed.
    pub(crate) fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyMeshArrays>> {
        let kept = locked(&self.arrays).as_ref().map(|arrays| arrays.clone_ref(py));
        if let Some(arrays) = kept {
            let arrays = arrays.into_bound(py);
            let old = arrays.get();
            if self.with_mesh(py, |mesh| old.is_current(mesh))? {
                return Ok(arrays);
            }
        }
        let bounces = Keywords::new(py, &self.chosen)?.mesh_options().transport.bounces;
        let arrays = self.with_mesh(py, |mesh| PyMeshArrays::new(mesh, bounces))?;
        let arrays = Bound::new(py, arrays)?;
        *locked(&self.arrays) = Some(arrays.clone().unbind());
        Ok(arrays)
    }
}
