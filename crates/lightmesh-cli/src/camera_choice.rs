//! Chooses the camera of a picture.

use lightmesh::{Camera, SceneData};

/// Returns the camera that `wanted` names (by name first, then by index), or the first one. If the file has none,
/// returns a camera that frames the scene, and a warning.
///
/// # Errors
/// If there is no such camera; says which there are.
pub fn choose(data: &SceneData, wanted: Option<&str>) -> Result<(Camera, Option<String>), anyhow::Error> {
    let cameras = &data.cameras;
    let Some(wanted) = wanted else {
        return Ok(match cameras.first() {
            Some(camera) => (camera.clone(), None),
            None => {
                let warning = "the file has no camera: taking one that frames the scene";
                (data.framing_camera(), Some(warning.to_owned()))
            }
        });
    };
    let by_name = cameras.iter().find(|camera| camera.name == wanted);
    let by_index = || wanted.parse().ok().and_then(|index: usize| cameras.get(index));
    match by_name.or_else(by_index) {
        Some(camera) => Ok((camera.clone(), None)),
        None if cameras.is_empty() => Err(anyhow::anyhow!("camera: there is no {wanted:?}; the file has no cameras")),
        None => {
            let known: Vec<String> =
                cameras.iter().enumerate().map(|(index, camera)| format!("{index} {:?}", camera.name)).collect();
            Err(anyhow::anyhow!("camera: there is no {wanted:?}; the file has {}", known.join(", ")))
        }
    }
}

/// The height of a picture `width` pixels wide that has the camera's aspect; at least 1.
pub fn height_for(camera: &Camera, width: u32) -> u32 {
    // The cast saturates; a height that no memory holds is refused with the sizes.
    ((f64::from(width) / f64::from(camera.aspect())).round() as u32).max(1)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use lightmesh::Projection;

    use super::*;

    fn scene(names: &[&str]) -> SceneData {
        let camera = |name: &&str| Camera { name: (*name).into(), ..Camera::look_at(Vec3::Z, Vec3::ZERO, 0.7) };
        SceneData { cameras: names.iter().map(camera).collect(), ..SceneData::default() }
    }

    #[test]
    fn a_name_goes_before_an_index() {
        let scene = scene(&["1", "door"]);
        let name = |wanted| choose(&scene, wanted).unwrap().0.name;
        assert_eq!(name(None), "1");
        assert_eq!(name(Some("1")), "1");
        assert_eq!(name(Some("0")), "1");
        assert_eq!(name(Some("door")), "door");
    }

    #[test]
    fn an_unknown_one_is_named_with_those_that_exist() {
        let message = choose(&scene(&["hall", "door"]), Some("nobody")).unwrap_err().to_string();
        assert!(["nobody", "0 \"hall\"", "1 \"door\""].iter().all(|w| message.contains(w)), "{message}");
        assert!(choose(&scene(&["hall"]), Some("1")).is_err());
    }

    #[test]
    fn none_in_the_file_is_a_warning() {
        let (_, warning) = choose(&scene(&[]), None).unwrap();
        assert!(warning.unwrap().contains("no camera"));
        assert!(choose(&scene(&[]), Some("0")).is_err());
    }

    #[test]
    fn the_height_follows_the_aspect() {
        let camera = |aspect| Camera {
            projection: Projection::Perspective { yfov: 1.0, aspect },
            ..Camera::look_at(Vec3::Z, Vec3::ZERO, 0.7)
        };
        assert_eq!(height_for(&camera(Some(16.0 / 9.0)), 1280), 720);
        assert_eq!(height_for(&camera(Some(1e6)), 1280), 1);
        assert_eq!(height_for(&camera(Some(1e-20)), 1280), u32::MAX);
    }
}
