//! The readers that are tried.

use crate::exercise::Depth;
use crate::seeds::{self, Seed};
use crate::{mutate, targets};

/// A reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// glTF, text and binary.
    Gltf,
    /// OBJ with its material library: one text, cut at the line `# library.mtl`.
    Obj,
    /// PLY, text and binary.
    Ply,
    /// PNG, JPEG and WebP, as the texture of a glTF.
    Texture,
    /// Environment maps, OpenEXR and Radiance.
    Environment,
    /// Files of light meshes.
    MeshFile,
    /// Scenes as bytes.
    SceneBytes,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Gltf, Self::Obj, Self::Ply, Self::Texture, Self::Environment, Self::MeshFile, Self::SceneBytes];

    /// Returns its name, which is also that of its program in `fuzz_targets/`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Texture => "texture",
            Self::Environment => "environment",
            Self::MeshFile => "mesh_file",
            Self::SceneBytes => "scene_bytes",
        }
    }

    /// Returns the target of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|target| target.name() == name)
    }

    /// Returns sound inputs.
    pub fn seeds(self) -> Vec<Seed> {
        match self {
            Self::Gltf => seeds::gltf::seeds(),
            Self::Obj => seeds::obj::seeds(),
            Self::Ply => seeds::ply::seeds(),
            Self::Texture => seeds::texture::seeds(),
            Self::Environment => seeds::environment::seeds(),
            Self::MeshFile => seeds::mesh_file::seeds(),
            Self::SceneBytes => seeds::scene_bytes::seeds(),
        }
    }

    /// Damages an input in one to six places; the same seed damages it in the same way. Lengths and checksums around the
    /// damage are mostly made right again, so that it is not found out at once.
    pub fn mutate(self, input: &[u8], seed: u64) -> Vec<u8> {
        let rng = &mut fastrand::Rng::with_seed(seed);
        match self {
            Self::Gltf => mutate::gltf::mutate(input, rng),
            Self::Obj => mutate::obj::mutate(input, rng),
            Self::Ply => mutate::ply::mutate(input, rng),
            Self::Texture => mutate::texture::mutate(input, rng),
            Self::Environment => mutate::environment::mutate(input, rng),
            Self::MeshFile => mutate::mesh_file::mutate(input, rng),
            Self::SceneBytes => mutate::scene_bytes::mutate(input, rng),
        }
    }

    /// Reads an input, and builds and renders what was read as far as `depth` says. Returns what became of it, in words:
    /// an error's message without its numbers, or what kind of scene it is.
    ///
    /// # Panics
    /// Where a reader does, where it takes more memory than it may, where a message is not one line that names the
    /// file, and where a picture has a value that is not finite: all that is looked for.
    pub fn run(self, input: &[u8], depth: Depth) -> String {
        match self {
            Self::Gltf => targets::gltf::run(input, depth),
            Self::Obj => targets::obj::run(input, depth),
            Self::Ply => targets::ply::run(input, depth),
            Self::Texture => targets::texture::run(input, depth),
            Self::Environment => targets::environment::run(input, depth),
            Self::MeshFile => targets::mesh_file::run(input, depth),
            Self::SceneBytes => targets::scene_bytes::run(input, depth),
        }
    }
}
