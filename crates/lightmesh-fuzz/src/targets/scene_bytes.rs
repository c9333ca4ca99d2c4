//! A scene as bytes.

use super::outcome;
use crate::exercise::{Depth, exercise};

pub(crate) fn run(input: &[u8], depth: Depth) -> String {
    match lightmesh_io::scene_from_bytes(input) {
        Err(error) => outcome::of_error("scene bytes", &error),
        Ok(data) => {
            let words = format!("scene, meshes {} lights {}", data.meshes.len().min(3), data.lights.len().min(3));
            exercise(data, depth);
            words
        }
    }
}
