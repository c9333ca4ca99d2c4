//! A picture as the texture of a glTF.

use super::outcome;
use crate::exercise::Depth;
use crate::seeds::gltf;

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    let file = gltf::with_texture(input);
    outcome::of_scene(depth, "input.glb", |options| lightmesh_io::load_gltf_bytes("input.glb", &file, None, options))
}
