//! What processes need to work on parts of one picture.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use lightmesh::distributed::{self, Prepared};
use lightmesh::{Camera, Fingerprint, LightMesh, RenderOptions, Snapshot};
use lightmesh_cli::{EmitterArgs, SOFTWARE, settings_json};
use lightmesh_io::{MeshFile, Units};
use pyo3::prelude::*;

use crate::built::Built;
use crate::error::Raise;
use crate::shared_mesh::{self, SharedMesh};
use crate::work::{Watch, locked};

/// A picture to be made in parts.
pub(crate) struct Job {
    pub(crate) name: String,
    pub(crate) units: Units,
    /// The files of the scene.
    pub(crate) files: Arc<[PathBuf]>,
    pub(crate) emitters: EmitterArgs,
    pub(crate) built: Arc<Built>,
    pub(crate) camera: Camera,
    pub(crate) options: RenderOptions,
    pub(crate) mesh: SharedMesh,
    pub(crate) prepared: Mutex<Option<Prepared>>,
    pub(crate) scene: Fingerprint,
}

/// Why work on a part failed.
pub(crate) enum JobError {
    Library(lightmesh::Error),
    File(lightmesh_io::Error),
    /// Another thread works with it.
    InUse,
}

impl Raise for JobError {
    fn raise(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Library(error) => error.raise(py),
            Self::File(error) => error.raise(py),
            Self::InUse => shared_mesh::in_use(py),
        }
    }
}

impl From<lightmesh::Error> for JobError {
    fn from(error: lightmesh::Error) -> Self {
        Self::Library(error)
    }
}

impl Job {
    /// Works with the mesh, which nobody else may be doing.
    pub(crate) fn with_mesh<T>(
        &self,
        work: impl FnOnce(&mut LightMesh) -> Result<T, lightmesh::Error>,
    ) -> Result<T, JobError> {
        let mut mesh = self.mesh.lock().ok_or(JobError::InUse)?;
        Ok(work(&mut mesh)?)
    }

    /// Works with the mesh after it was prepared for the picture, which happens once.
    pub(crate) fn with_prepared<T>(
        &self,
        watch: &Watch,
        work: impl FnOnce(&mut LightMesh, &Prepared) -> Result<T, lightmesh::Error>,
    ) -> Result<T, JobError> {
        self.with_mesh(|mesh| {
            let mut prepared = locked(&self.prepared);
            let ready = match prepared.take().filter(|prepared| prepared.holds(mesh)) {
                Some(ready) => ready,
                None => distributed::prepare(&self.built.scene, &self.camera, &self.options, mesh, watch)?,
            };
            work(mesh, prepared.insert(ready))
        })
    }

    /// Writes contents as the bytes of a mesh file, for other processes.
    pub(crate) fn to_bytes(&self, contents: Snapshot) -> Vec<u8> {
        lightmesh_io::mesh_to_bytes(&MeshFile {
            scene: self.scene,
            settings_fingerprint: Fingerprint::of_settings(&self.options),
            software: SOFTWARE.to_owned(),
            method: self.options.method.to_string(),
            settings: "{}".to_owned(),
            contents,
        })
    }

    /// Returns every option and the camera's name as a JSON object.
    pub(crate) fn settings(&self) -> String {
        settings_json(&self.options, &self.emitters, self.units, &self.camera.name)
    }
}
