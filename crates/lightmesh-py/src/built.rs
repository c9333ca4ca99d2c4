//! A scene while it is put together, and when it is ready for rays.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lightmesh::{Camera, Environment, FirstLight, Limits, Scene, SceneData, Survey};
use lightmesh_cli::EmitterArgs;

use crate::error::{Raise, without_dashes};

/// A scene that is ready for rays, lit as options say.
pub(crate) struct Built {
    pub(crate) scene: Scene,
    /// The environment and the light samples that the options added to its own lights.
    pub(crate) emitters: EmitterArgs,
    /// Its own environment, which the options may have replaced.
    own_environment: Option<Environment>,
    /// How many lights are its own.
    own_lights: usize,
    /// What was added to its own light, for pictures by this camera.
    added: FirstLight,
    camera: Camera,
    /// Whether it has any light of its own.
    has_own_light: bool,
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
    /// Lights the scene as asked, or as its first picture needs it, and builds it: as the command line does. Without a
    /// camera it is lit for the scene's first one.
    pub(crate) fn new(
        mut data: SceneData,
        emitters: &EmitterArgs,
        max_memory: u64,
        camera: Option<&Camera>,
    ) -> Result<Self, BuildError> {
        let started = Instant::now();
        let mut warnings = Vec::new();
        let asked_for =
            lightmesh_cli::read_environment(emitters, max_memory, |warning| warnings.push(warning.to_owned()))
                .map_err(BuildError::File)?;
        let own_environment = data.environment.clone();
        let own_lights = data.lights.len();
        lightmesh_cli::apply_environment(&mut data, asked_for, emitters);
        let scene = Scene::within(data, &emitters.options, &Limits { max_memory }).map_err(BuildError::Scene)?;
        warnings.extend_from_slice(scene.warnings());
        let camera = camera.cloned().unwrap_or_else(|| first_camera(&scene));
        let lit = lightmesh_cli::add_first_light(scene, &camera, emitters).map_err(BuildError::Scene)?;
        warnings.extend(lit.warnings.iter().map(|warning| without_dashes(warning)));
        Ok(Self {
            scene: lit.scene,
            emitters: emitters.clone(),
            own_environment,
            own_lights,
            added: lit.added,
            camera,
            has_own_light: lit.survey.has_own_light,
            warnings,
            time: started.elapsed(),
        })
    }

    /// Returns the description that it was built from, to be changed or lit otherwise.
    fn data(&self) -> SceneData {
        let mut data = self.scene.data().clone();
        data.environment = self.own_environment.clone();
        data.lights.truncate(self.own_lights);
        data
    }

    /// Whether a picture by this camera, or by the first one, gets the light that the scene has now.
    pub(crate) fn is_lit_for(&self, camera: Option<&Camera>) -> bool {
        if self.emitters.environment.is_some() {
            return true;
        }
        let camera = camera.cloned().unwrap_or_else(|| first_camera(&self.scene));
        if camera == self.camera {
            return true;
        }
        // The light that was added does not change what another view needs, where there is no other light.
        let known = match self.added {
            FirstLight::Own => true,
            FirstLight::Studio => !self.has_own_light,
            FirstLight::Headlight => false,
        };
        known
            && Survey::new(&self.scene, &camera).is_ok_and(|survey| match self.added {
                FirstLight::Studio => survey.open || survey.seen == 0.0,
                added => survey.wanted == added,
            })
    }
}

/// The camera of pictures for which none is named.
fn first_camera(scene: &Scene) -> Camera {
    scene.data().cameras.first().cloned().unwrap_or_else(|| scene.data().framing_camera())
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
