//! glTF in memory.

use super::outcome;
use crate::exercise::Depth;

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    outcome::of_scene(depth, "input.glb", |options| lightmesh_io::load_gltf_bytes("input.glb", input, None, options))
}
