//! A file of a light mesh, and pictures of its scene with it.

use std::path::Path;
use std::sync::LazyLock;

use lightmesh::{Camera, DirectValues, Fingerprint, RenderOptions, Scene};
use lightmesh_io::MeshFile;

use super::{MEMORY, outcome};
use crate::exercise::{Depth, render_small};
use crate::memory::within;
use crate::seeds::mesh_file::{self, METHODS};

/// The scene that all these meshes are of, and its options for each method.
static SCENE: LazyLock<(Scene, Camera, Vec<RenderOptions>)> = LazyLock::new(|| {
    let scene = Scene::new(mesh_file::scene()).expect("a sound scene");
    let camera = scene.data().framing_camera();
    (scene, camera, METHODS.map(mesh_file::options).into())
});

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    let name = "input.mesh";
    let mut file = match within(MEMORY, || lightmesh_io::mesh_from_bytes(name, input, MEMORY)) {
        Err(error) => return outcome::of_error(name, &error),
        Ok(file) => file,
    };
    check_finite(&file);

    // Whatever scene and settings it names: those of its kind of values.
    let (scene, camera, options) = &*SCENE;
    let options = match file.contents.direct.values {
        DirectValues::SixAxis(_) | DirectValues::SixAxisParts(_) => &options[0],
        DirectValues::Scalar(_) => &options[1],
        DirectValues::Lights { .. } | DirectValues::Runs { .. } => &options[2],
    };
    file.scene = Fingerprint::of_scene(scene);
    file.settings_fingerprint = Fingerprint::of_settings(options);
    if depth < Depth::Build {
        return format!("mesh of {} bounces", file.bounces().min(3));
    }
    match file.into_mesh(Path::new(name), scene, options) {
        Err(error) => outcome::of_error(name, &error),
        Ok(mesh) => {
            if depth == Depth::Render {
                render_small(scene, camera, options, Some(mesh));
            }
            "merged mesh".to_owned()
        }
    }
}

/// Checks that all values which light has are finite.
fn check_finite(file: &MeshFile) {
    let direct = match &file.contents.direct.values {
        DirectValues::SixAxis(values) | DirectValues::SixAxisParts(values) | DirectValues::Scalar(values) => values,
        DirectValues::Lights { .. } | DirectValues::Runs { .. } => &Vec::new(),
    };
    let indirect = file.contents.indirect.as_ref().map_or(&[][..], |indirect| &indirect.values);
    assert!(direct.iter().chain(indirect).all(|x| x.is_finite()), "not finite: a value of a mesh that was read");
}
