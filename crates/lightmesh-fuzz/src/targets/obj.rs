//! OBJ, its material library and a texture, as files.

use std::sync::Once;

use super::{outcome, scratch};
use crate::exercise::Depth;
use crate::seeds::texture;

/// The line between an OBJ and its material library in one input.
pub(crate) const LIBRARY: &[u8] = b"# library.mtl\n";

/// Splits an input into both.
pub(crate) fn split(input: &[u8]) -> (&[u8], &[u8]) {
    match input.windows(LIBRARY.len()).position(|window| window == LIBRARY) {
        Some(at) => (&input[..at], &input[at + LIBRARY.len()..]),
        None => (input, b""),
    }
}

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    static TEXTURE: Once = Once::new();
    TEXTURE.call_once(|| drop(scratch::write("t.png", &texture::small_png())));
    let (obj, library) = split(input);
    if !library.is_empty() {
        scratch::write("library.mtl", library);
    }
    let path = scratch::write("input.obj", obj);
    outcome::of_scene(depth, "input.obj", |options| lightmesh_io::load(&path, options))
}
