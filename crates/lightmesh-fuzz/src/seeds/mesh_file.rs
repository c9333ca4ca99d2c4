//! Files of light meshes of one small scene, in every encoding of their values.

use glam::Vec3;
use lightmesh::{Light, LightMesh, Method, RenderOptions, Scene, SceneData, Spacing, render};
use lightmesh_io::{MeshFile, Provenance, mesh_to_bytes};

use super::{Seed, scene_bytes};
use crate::exercise;

/// A method for each way to store values: six axes, a scalar, and what is known of each light.
pub(crate) const METHODS: [Method; 3] = [Method::MESH, Method::PAPER, Method::Hybrid];

/// The scene: a square and two lamps.
pub(crate) fn scene() -> SceneData {
    let lamp = |x: f32| Light::Point {
        position: Vec3::new(x, 1.0, 2.0),
        intensity_cd: Vec3::new(30.0, 20.0, 10.0),
        range: None,
    };
    SceneData { lights: vec![lamp(-1.0), lamp(1.0)], ..scene_bytes::small_scene() }
}

/// How its meshes are made.
pub(crate) fn options(method: Method) -> RenderOptions {
    exercise::options(method).with(|o| {
        (o.mesh.spacing, o.mesh.indirect_spacing) = (Spacing::Fraction(1.5), Spacing::Fraction(1.0));
    })
}

pub(crate) fn seeds() -> Vec<Seed> {
    let scene = Scene::new(scene()).expect("a sound scene");
    let camera = scene.data().framing_camera();
    METHODS
        .into_iter()
        .map(|method| {
            let options = options(method);
            let mut mesh = LightMesh::new(&scene, &options).expect("a small mesh");
            render(&scene, &camera, &options, &mut mesh, &()).expect("a small picture");
            let provenance = Provenance { software: "fuzz", method: method.name(), settings: "{\"spp\":1}" };
            Seed::new(format!("{method}.mesh"), mesh_to_bytes(&MeshFile::new(&scene, &options, &mesh, provenance)))
        })
        .collect()
}
