//! Light from all sides, the command line's or the file's, and the light that a black picture gets.

use glam::{Quat, Vec3};
use lightmesh::{Camera, Environment, Error, FirstLight, Scene, SceneData, Survey};

use crate::args::{EmitterArgs, EnvironmentArg};

/// Reads the environment that `--environment` names; `None` if it is not given. Warnings go to `warn`.
///
/// # Errors
/// What [`lightmesh_io::read_environment`] says of a map.
pub fn read(
    args: &EmitterArgs,
    max_memory: u64,
    mut warn: impl FnMut(&str),
) -> Result<Option<Environment>, lightmesh_io::Error> {
    let (map, radiance) = match &args.environment {
        None => return Ok(None),
        Some(EnvironmentArg::Color(color)) => (None, *color),
        Some(EnvironmentArg::File(path)) => {
            let read = lightmesh_io::read_environment(path, max_memory)?;
            read.warnings.iter().for_each(|w| warn(w));
            (Some(read.map), Vec3::ONE)
        }
    };
    Ok(Some(Environment { map, radiance, world_from_map: Quat::IDENTITY }))
}

/// Sets the environment of a scene to the one that the user chose, if any, and applies strength and rotation.
pub fn apply(data: &mut SceneData, asked_for: Option<Environment>, args: &EmitterArgs) {
    if asked_for.is_some() {
        data.environment = asked_for;
    }
    if let Some(environment) = &mut data.environment {
        environment.radiance *= args.environment_strength;
        environment.world_from_map = Quat::from_rotation_y(rotation(args)) * environment.world_from_map;
    }
}

/// Adds light to a scene that would be black through `camera`, unless the user chose an environment. Returns it with
/// the light that was added, and warnings.
///
/// # Errors
/// As [`Scene::with_emitters`].
pub fn add_first_light(scene: Scene, camera: &Camera, args: &EmitterArgs) -> Result<FirstLit, Error> {
    let mut warnings = Vec::new();
    let has_environment = scene.data().environment.is_some();
    let survey = Survey::new(&scene, camera)?;
    warnings.extend(place_of_camera(&survey));
    let added = if args.environment.is_some() { FirstLight::Own } else { survey.wanted };
    warnings.extend(said(added, &survey));
    let changed = (args.environment_strength, args.environment_rotation) != (1.0, 0.0);
    if changed && !has_environment && added != FirstLight::Studio {
        warnings.push(
            "there is no environment that --environment-strength or --environment-rotation could change".to_owned(),
        );
    }
    let scene = match added {
        FirstLight::Own => scene,
        _ => scene.with_first_light(&survey, args.environment_strength, rotation(args))?,
    };
    Ok(FirstLit { scene, added, survey, warnings })
}

/// A scene with the light that its first picture needs.
#[derive(Debug)]
pub struct FirstLit {
    /// The scene, ready for rays.
    pub scene: Scene,
    /// What was added to its own light.
    pub added: FirstLight,
    /// What its camera sees.
    pub survey: Survey,
    /// One sentence each.
    pub warnings: Vec<String>,
}

/// Radians.
fn rotation(args: &EmitterArgs) -> f32 {
    args.environment_rotation.to_radians()
}

/// Says what light was added, why, and how it is left out; or why the picture is black.
fn said(added: FirstLight, survey: &Survey) -> Option<String> {
    let sentence = match (added, survey.has_own_light) {
        (FirstLight::Own, _) if survey.wanted == FirstLight::Headlight => {
            "no light reaches the camera: it stands in a closed room without a lamp"
        }
        (FirstLight::Own, _) => return None,
        (FirstLight::Studio, false) => {
            "the file has no lights and nothing emits: lighting it by a soft environment, that of a studio \
             (--environment with a colour or a picture is another sky, black leaves it dark)"
        }
        (FirstLight::Studio, true) => {
            "the file's own light hardly lights anything that the camera sees: adding a soft environment, that of a \
             studio (--environment with a colour or a picture is another sky, black leaves it out)"
        }
        (FirstLight::Headlight, _) => {
            "no light reaches the camera, and none can come in from outside: lighting what it sees by a lamp at the \
             camera (--environment black leaves it dark)"
        }
    };
    Some(sentence.to_owned())
}

/// Says that a camera stands or looks where hardly anybody wants it to.
fn place_of_camera(survey: &Survey) -> Option<String> {
    if survey.seen == 0.0 {
        let what = "the camera sees nothing of the scene: it looks past it or away from it; choose another with \
                    --camera, or move it";
        return Some(what.to_owned());
    }
    // Cameras in rooms whose walls face outwards see backs, too.
    (survey.back_faces > 0.9 && survey.seen > 0.9 && !survey.open).then(|| {
        format!(
            "the camera is inside a solid, or in a room whose walls face outwards: {:.0}% of what it sees are the backs \
             of one-sided surfaces",
            100.0 * survey.back_faces
        )
    })
}
