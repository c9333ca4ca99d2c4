//! The scenes of the experiments: those of the folder `scenes/`, which the program carries with it.

use glam::Vec3;
use lightmesh::{Camera, Light, SceneData};
use lightmesh_io::{LoadOptions, load_gltf_bytes};

use crate::error::Error;

/// A scene, told from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum SceneName {
    /// The room of about 5,000 triangles under so many point lights, at most 1000, of the same intensity together.
    Room(usize),
    /// A triangle over a floor under one light.
    Triangle,
    /// A box with a red and a green wall under one light.
    Cornell,
}

const ROOM: &[u8] = include_bytes!("../../../scenes/room_1000.glb");
const TRIANGLE: &[u8] = include_bytes!("../../../scenes/triangle.glb");
const CORNELL: &[u8] = include_bytes!("../../../scenes/cornell.glb");

/// Reads a scene and its camera.
pub(crate) fn read(name: SceneName) -> Result<(SceneData, Camera), Error> {
    let (file, bytes) = match name {
        SceneName::Room(_) => ("room_1000.glb", ROOM),
        SceneName::Triangle => ("triangle.glb", TRIANGLE),
        SceneName::Cornell => ("cornell.glb", CORNELL),
    };
    let mut data = load_gltf_bytes(file, bytes, None, &LoadOptions::default())?.data;
    if let SceneName::Room(count) = name {
        let scale = data.lights.len() as f32 / count as f32;
        data.lights.truncate(count);
        for light in &mut data.lights {
            if let Light::Point { intensity_cd, .. } = light {
                *intensity_cd *= scale;
            }
        }
    }
    let camera = data.cameras.first().cloned().unwrap_or_else(|| data.framing_camera());
    Ok((data, camera))
}

/// Returns the position of the only light of a scene.
pub(crate) fn light_of(data: &SceneData) -> Vec3 {
    match data.lights.first() {
        Some(Light::Point { position, .. }) => *position,
        _ => Vec3::Y,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The room with 15 lights is `scenes/room_15.glb`, but for the rounding of its intensities.
    #[test]
    fn rooms_with_fewer_lights_are_those_of_the_folder() {
        let file = include_bytes!("../../../scenes/room_15.glb");
        let kept = load_gltf_bytes("room_15.glb", file, None, &LoadOptions::default()).expect("scene").data;
        let (made, _) = read(SceneName::Room(15)).expect("scene");
        assert_eq!(made.lights.len(), 15);
        for pair in made.lights.iter().zip(&kept.lights) {
            let (Light::Point { position: a, intensity_cd: i, .. }, Light::Point { position: b, intensity_cd: j, .. }) =
                pair
            else {
                panic!("{pair:?}")
            };
            assert!(a == b && (*i - *j).length() < 1e-4 * j.length(), "{pair:?}");
        }
    }
}
