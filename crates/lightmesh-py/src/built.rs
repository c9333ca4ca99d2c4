//! A scene while it is put together, and when it is ready for rays.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lightmesh::{Environment, Scene, SceneData};
use lightmesh_cli::EmitterArgs;

use crate::error::{Raise, without_dashes};

/// A scene that is ready for rays, lit as options say.
pub(crate) struct Built {
    pub(crate) scene: Scene,
    /// The environment and the light samples that the options added to its own lights.
    pub(crate) emitters: EmitterArgs,
    /// Its own environment, which the options may have replaced.
    own_environment: Option<Environment>,
    /// Warnings from building it, one sentence each.
    pub(crate) warnings: Vec<String>,
    /// How long building it took.
    pub(crate) time: Duration,
}

/// Why a scene cannot be built.
#[derive(Debug)]
pub(crate) enum BuildError {
    Scene(lightmesh::Error),
    File(lightmesh_io::Error),
}

impl Raise for BuildError {
    fn raise(self, py: pyo3::Python<'_>) -> pyo3::PyErr {
        match self {
            Self::Scene(error) => error.raise(py),
            Self::File(error) => error.raise(py),
        }
    }
}

impl Built {
    /// Lights the scene as asked, or softly if nothing does, and builds it: as the command line does.
    pub(crate) fn new(mut data: SceneData, emitters: &EmitterArgs, max_memory: u64) -> Result<Self, BuildError> {
        let started = Instant::now();
        let mut warnings = Vec::new();
        let asked_for =
            lightmesh_cli::read_environment(emitters, max_memory, |warning| warnings.push(warning.to_owned()))
                .map_err(BuildError::File)?;
        let own_environment = data.environment.clone();
        let applied = lightmesh_cli::apply_environment(&mut data, asked_for, emitters);
        warnings.extend(applied.iter().map(|warning| without_dashes(warning)));
        let scene = Scene::with_emitters(data, &emitters.options).map_err(BuildError::Scene)?;
        warnings.extend_from_slice(scene.warnings());
        Ok(Self { scene, emitters: emitters.clone(), own_environment, warnings, time: started.elapsed() })
    }

    /// Returns the description that it was built from, to be changed or lit otherwise.
    fn data(&self) -> SceneData {
        SceneData { environment: self.own_environment.clone(), ..self.scene.data().clone() }
    }
}

/// The state of a scene.
#[derive(Clone)]
pub(crate) enum State {
    /// Not yet checked.
    Draft(Arc<SceneData>),
    /// Ready.
    Built(Arc<Built>),
}

impl State {
    /// Returns the description, checked or not.
    pub(crate) fn data(&self) -> &SceneData {
        match self {
            Self::Draft(data) => data,
            Self::Built(built) => built.scene.data(),
        }
    }

    /// Returns a description to build from or to change, without a copy where nobody shares it.
    pub(crate) fn into_data(self) -> SceneData {
        match self {
            Self::Draft(data) => Arc::unwrap_or_clone(data),
            Self::Built(built) => built.data(),
        }
    }
}
