//! Sound inputs, all made here: small ones, so that each is tried quickly, and each with something that others have not.

pub(crate) mod environment;
pub(crate) mod gltf;
mod gltf_document;
pub(crate) mod mesh_file;
pub(crate) mod obj;
pub(crate) mod ply;
pub(crate) mod scene_bytes;
pub(crate) mod texture;

/// A sound input.
#[derive(Clone, Debug)]
pub struct Seed {
    /// The name of its file.
    pub name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

impl Seed {
    fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), bytes: bytes.into() }
    }
}
