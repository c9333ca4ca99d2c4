//! A light mesh that several Python objects and threads hold, and that one thread at a time works with.

use std::sync::{Arc, Mutex, MutexGuard};

use lightmesh::LightMesh;
use pyo3::prelude::*;

use crate::error;

/// A mesh behind a lock. Clones share it.
#[derive(Clone)]
pub(crate) struct SharedMesh(Arc<Mutex<LightMesh>>);

impl SharedMesh {
    /// Wraps a mesh.
    pub(crate) fn new(mesh: LightMesh) -> Self {
        Self(Arc::new(Mutex::new(mesh)))
    }

    /// Locks the mesh without waiting; `None` if another thread works with it, or panicked while it did.
    pub(crate) fn lock(&self) -> Option<MutexGuard<'_, LightMesh>> {
        self.0.try_lock().ok()
    }
}

/// The exception for a mesh that could not be locked.
pub(crate) fn in_use(py: Python<'_>) -> PyErr {
    error::general(py, "mesh: another thread works with it, or failed inside while it did")
}
