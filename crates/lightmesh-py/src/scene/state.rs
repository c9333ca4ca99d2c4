//! The state of a scene behind its lock: changed, or made ready for rays.

use std::sync::{Arc, Mutex};

use lightmesh::{Camera, SceneData};
use lightmesh_cli::{Chosen, EmitterArgs};
use pyo3::prelude::*;

use super::{Origin, PyScene};
use crate::built::{Built, State};
use crate::error::{self, Raise};
use crate::keywords::Keywords;
use crate::pool;
use crate::work::{self, AtInterrupt, locked};

pub(super) struct Inner {
    state: State,
    /// What was mended when the scene was first built: a later build finds nothing left to mend.
    warnings: Vec<String>,
    /// Counts changes.
    revision: u64,
}

/// Parsed options, and the scene lit as they say.
pub(crate) struct LitScene {
    pub(crate) keywords: Keywords,
    pub(crate) built: Arc<Built>,
}

impl PyScene {
    /// A scene that is not yet checked.
    pub(crate) fn draft(origin: Origin, data: SceneData) -> Self {
        let inner = Inner { state: State::Draft(Arc::new(data)), warnings: Vec::new(), revision: 0 };
        Self { origin, inner: Mutex::new(inner) }
    }

    /// A scene that is ready for rays.
    pub(crate) fn ready(origin: Origin, built: Arc<Built>) -> Self {
        let warnings = built.warnings.clone();
        Self { origin, inner: Mutex::new(Inner { state: State::Built(built), warnings, revision: 0 }) }
    }

    /// Returns how often the scene was changed.
    pub(crate) fn revision(&self) -> u64 {
        locked(&self.inner).revision
    }

    /// Returns the state as it is now.
    pub(crate) fn state(&self) -> State {
        locked(&self.inner).state.clone()
    }

    /// Returns what was left out or mended, when the file was read and when the scene was built.
    pub(crate) fn all_warnings(&self) -> Vec<String> {
        self.origin.warnings.iter().chain(&locked(&self.inner).warnings).cloned().collect()
    }

    /// Reads the description, checked or not.
    pub(crate) fn with_data<R>(&self, read: impl FnOnce(&SceneData) -> R) -> R {
        read(locked(&self.inner).state.data())
    }

    /// Changes the description; the scene has to be built again.
    pub(crate) fn edit<R>(&self, change: impl FnOnce(&mut SceneData) -> R) -> R {
        let mut inner = locked(&self.inner);
        let state = std::mem::replace(&mut inner.state, State::Draft(Arc::default()));
        let mut data = state.into_data();
        let result = change(&mut data);
        inner.state = State::Draft(Arc::new(data));
        inner.revision += 1;
        result
    }

    /// [`PyScene::edit`] where the change may find something wrong.
    pub(crate) fn try_edit<R>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut SceneData) -> Result<R, String>,
    ) -> PyResult<R> {
        self.edit(change).map_err(|message| error::scene(py, message))
    }

    /// Returns the scene ready for rays, with whatever light it was last built with.
    pub(crate) fn built(&self, py: Python<'_>) -> PyResult<Arc<Built>> {
        match self.state() {
            State::Built(built) => Ok(built),
            State::Draft(_) => self.lit(py, &Keywords::new(py, &Chosen::default())?, None),
        }
    }

    /// Returns the scene ready for rays, lit as the options say, and where they do not, as a picture by the camera needs
    /// it; `None`: by the scene's first one. Builds it unless it is.
    pub(crate) fn lit(&self, py: Python<'_>, keywords: &Keywords, camera: Option<&Camera>) -> PyResult<Arc<Built>> {
        let emitters: EmitterArgs = keywords.emitters().clone();
        let (state, revision) = {
            let inner = locked(&self.inner);
            (inner.state.clone(), inner.revision)
        };
        // What a camera sees is found out by rays.
        if let State::Built(built) = &state
            && built.emitters == emitters
            && pool::detached(py, || built.is_lit_for(camera))?
        {
            return Ok(Arc::clone(built));
        }

        // Build it without holding the lock.
        let max_memory = keywords.mesh_options().limits.max_memory;
        let camera = camera.cloned();
        let work = move |_: &work::Watch| Built::new(state.into_data(), &emitters, max_memory, camera.as_ref());
        let built = work::run(py, keywords.threads(), None, AtInterrupt::Abandon, work)?;
        let built = Arc::new(built.map_err(|error| error.raise(py))?);

        // Keep it, unless another thread has changed the scene meanwhile.
        let mut inner = locked(&self.inner);
        if inner.revision == revision {
            inner.state = State::Built(Arc::clone(&built));
            let new: Vec<String> = built.warnings.iter().filter(|w| !inner.warnings.contains(w)).cloned().collect();
            inner.warnings.extend(new);
        }
        Ok(built)
    }
}
