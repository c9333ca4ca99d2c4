//! What is done with an input of each kind.

pub(crate) mod environment;
pub(crate) mod gltf;
pub(crate) mod mesh_file;
pub(crate) mod obj;
mod outcome;
pub(crate) mod ply;
pub(crate) mod scene_bytes;
mod scratch;
pub(crate) mod texture;

/// The memory that a reader gets, bytes.
const MEMORY: u64 = 4 << 20;
