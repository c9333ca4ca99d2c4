//! The state of a scene behind its lock: changed, or made ready for rays.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use lightmesh::SceneData;
use lightmesh_cli::{EmitterArgs, Keywords};
use lightmesh_io::Units;
use pyo3::prelude::*;

use super::PyScene;
use crate::built::{Built, State};
use crate::error::{self, Raise};
use crate::keywords;
use crate::light_mesh::PyLightMesh;
use crate::work::{self, AtInterrupt, locked};

pub(super) struct Inner {
    pub(super) state: State,
    /// What was mended when it was first made ready: later nothing is left to mend.
    pub(super) warnings: Vec<String>,
    /// Counts changes.
    revision: u64,
}

impl PyScene {
    pub(super) fn with_state(
        name: String,
        units: Units,
        load_time: Duration,
        load_warnings: Vec<String>,
        state: State,
        warnings: Vec<String>,
    ) -> Self {
        let inner = Mutex::new(Inner { state, warnings, revision: 0 });
        Self { name, units, load_time, load_warnings, inner }
    }

    /// How often it was changed.
    pub(crate) fn revision(&self) -> u64 {
        locked(&self.inner).revision
    }

    /// Changes the description; what was ready has to be made so again.
    pub(super) fn edit<R>(&self, change: impl FnOnce(&mut SceneData) -> R) -> R {
        let mut inner = locked(&self.inner);
        let state = std::mem::replace(&mut inner.state, State::Draft(Arc::default()));
        let mut data = state.into_data();
        let result = change(&mut data);
        inner.state = State::Draft(Arc::new(data));
        inner.revision += 1;
        result
    }

    /// [`PyScene::edit`] where the change may find something wrong.
    pub(super) fn try_edit<R>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut SceneData) -> Result<R, String>,
    ) -> PyResult<R> {
        self.edit(change).map_err(|what| error::scene(py, what))
    }

    /// The scene ready for rays, however it is lit.
    pub(super) fn ready(&self, py: Python<'_>) -> PyResult<Arc<Built>> {
        let state = locked(&self.inner).state.clone();
        match state {
            State::Built(built) => Ok(built),
            State::Draft(_) => self.built(py, &keywords::parse(py, &keywords::Pairs::new())?),
        }
    }

    /// The options of a picture or of meters, with a mesh or without, and the scene as they light it.
    pub(crate) fn keywords_and_built(
        &self,
        slf: &Bound<'_, Self>,
        mesh: Option<&Bound<'_, PyLightMesh>>,
        chosen: &keywords::Pairs,
    ) -> PyResult<(Keywords, Arc<Built>)> {
        if let Some(mesh) = mesh {
            return mesh.get().keywords_and_scene(slf, chosen);
        }
        let keywords = keywords::parse(slf.py(), chosen)?;
        let built = self.built(slf.py(), &keywords)?;
        Ok((keywords, built))
    }

    /// The scene ready for rays, lit as the options say.
    pub(crate) fn built(&self, py: Python<'_>, keywords: &Keywords) -> PyResult<Arc<Built>> {
        let emitters: EmitterArgs = keywords.emitters().clone();
        let (state, revision) = {
            let inner = locked(&self.inner);
            (inner.state.clone(), inner.revision)
        };
        let state = match state {
            State::Built(built) if built.emitters == emitters => return Ok(built),
            other => other,
        };
        let max_memory = keywords.mesh_options().max_memory;
        let work = move |_: &work::Watch| Built::new(state.into_data(), &emitters, max_memory);
        let built = work::run(py, keywords.threads(), None, AtInterrupt::Abandon, work)?;
        let built = Arc::new(built.map_err(|error| error.raise(py))?);
        let mut inner = locked(&self.inner);
        // Another thread may have changed it meanwhile.
        if inner.revision == revision {
            inner.state = State::Built(Arc::clone(&built));
            let new: Vec<String> = built.warnings.iter().filter(|w| !inner.warnings.contains(w)).cloned().collect();
            inner.warnings.extend(new);
        }
        Ok(built)
    }
}
