//! What work on a part of a picture needs.

use std::sync::{Arc, Mutex, TryLockError};

use lightmesh::portions::{self, Prepared};
use lightmesh::{Camera, Fingerprint, LightMesh, RenderOptions, Snapshot};
use lightmesh_cli::{EmitterArgs, SOFTWARE, method_name, settings_json};
use lightmesh_io::{MeshFile, Units};
use pyo3::prelude::*;

use crate::built::Built;
use crate::error::{self, Raise};
use crate::light_mesh::IN_USE;
use crate::work::{Watch, locked};

/// What the work needs.
pub(crate) struct Job {
    pub(super) name: String,
    pub(super) units: Units,
    pub(super) emitters: EmitterArgs,
    pub(crate) built: Arc<Built>,
    pub(super) camera: Camera,
    pub(crate) options: RenderOptions,
    pub(super) mesh: Arc<Mutex<LightMesh>>,
    pub(super) prepared: Mutex<Option<Prepared>>,
    pub(super) scene: Fingerprint,
}

/// Why a part cannot be had.
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
            Self::InUse => error::general(py, IN_USE),
        }
    }
}

impl From<lightmesh::Error> for JobError {
    fn from(error: lightmesh::Error) -> Self {
        Self::Library(error)
    }
}

impl Job {
    /// Works with the mesh.
    pub(crate) fn with_mesh<T>(
        &self,
        work: impl FnOnce(&mut LightMesh) -> Result<T, lightmesh::Error>,
    ) -> Result<T, JobError> {
        match self.mesh.try_lock() {
            Ok(mut mesh) => Ok(work(&mut mesh)?),
            Err(TryLockError::WouldBlock | TryLockError::Poisoned(_)) => Err(JobError::InUse),
        }
    }

    /// Works with the mesh, made ready for the picture.
    pub(super) fn with_prepared<T>(
        &self,
        watch: &Watch,
        work: impl FnOnce(&mut LightMesh, &Prepared) -> Result<T, lightmesh::Error>,
    ) -> Result<T, JobError> {
        self.with_mesh(|mesh| {
            let mut prepared = locked(&self.prepared);
            let ready = match prepared.take().filter(|prepared| prepared.holds(mesh)) {
                Some(ready) => ready,
                None => portions::prepare(&self.built.scene, &self.camera, &self.options, mesh, watch)?,
            };
            work(mesh, prepared.insert(ready))
        })
    }

    /// Contents as the bytes of a mesh file, for other processes.
    pub(crate) fn to_bytes(&self, contents: Snapshot) -> Vec<u8> {
        lightmesh_io::mesh_to_bytes(&MeshFile {
            scene: self.scene,
            settings_fingerprint: Fingerprint::of_settings(&self.options),
            software: SOFTWARE.to_owned(),
            method: method_name(self.options.method).to_owned(),
            settings: "{}".to_owned(),
            contents,
        })
    }

    pub(super) fn settings(&self) -> String {
        settings_json(&self.options, &self.emitters, self.units, &self.camera.name)
    }
}
