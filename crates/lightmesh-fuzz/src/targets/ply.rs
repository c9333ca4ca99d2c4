//! PLY as a file.

use super::{outcome, scratch};
use crate::exercise::Depth;

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    let path = scratch::write("input.ply", input);
    outcome::of_scene(depth, "input.ply", |options| lightmesh_io::load(&path, options))
}
