//! Light from all sides: the command line's, the file's, or the soft one of scenes without light.

use glam::{Quat, Vec3};
use lightmesh::{Environment, SceneData, soft_environment};

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

/// Sets the environment of a scene: the one that the user chose, else the scene's own, else a soft one if nothing else
/// shines. Then applies strength and rotation. Returns warnings.
pub fn apply(data: &mut SceneData, asked_for: Option<Environment>, args: &EmitterArgs) -> Vec<String> {
    let mut warnings = Vec::new();
    if asked_for.is_some() {
        data.environment = asked_for;
    } else if data.lights.is_empty() && data.environment.is_none() && !emits(data) {
        warnings.push("the file has no lights and nothing emits: lighting it by a soft environment".to_owned());
        data.environment = Some(soft_environment());
    }
    match &mut data.environment {
        Some(environment) => {
            environment.radiance *= args.environment_strength;
            let turn = Quat::from_rotation_y(args.environment_rotation.to_radians());
            environment.world_from_map = turn * environment.world_from_map;
        }
        None if (args.environment_strength, args.environment_rotation) != (1.0, 0.0) => warnings.push(
            "there is no environment that --environment-strength or --environment-rotation could change".to_owned(),
        ),
        None => {}
    }
    warnings
}

/// Returns whether a surface of the scene emits light.
fn emits(data: &SceneData) -> bool {
    let meshes = data.instances.iter().filter_map(|i| data.meshes.get(i.mesh)).map(|mesh| mesh.material);
    let spheres = data.spheres.iter().map(|sphere| sphere.material);
    let shapes = data.shapes.iter().map(|shape| shape.material);
    let mut used = meshes.chain(spheres).chain(shapes).filter_map(|m| data.materials.get(m));
    used.any(|material| material.emission.max_element() > 0.0)
}
