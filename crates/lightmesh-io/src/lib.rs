//! Scenes in, pictures and light meshes out: the files around `lightmesh`.
//!
//! [`load`] reads a scene file into a [`lightmesh::SceneData`]. What comes out has been checked: every index is in
//! range, every number is finite, and no file can make the reader panic or take more memory than
//! [`LoadOptions::max_memory`].
//! [`output`] writes pictures, [`read_picture`] reads them back, [`read_environment`] reads maps of light from all
//! sides. [`write_mesh`] and [`read_mesh`] keep what a light mesh knows.
//!
//! ```
//! # fn main() -> Result<(), lightmesh_io::Error> {
//! // A glTF in memory; `load` reads the same from a path.
//! let gltf = br#"{
//!     "asset": {"version": "2.0"},
//!     "scenes": [{"nodes": [0]}],
//!     "nodes": [{"mesh": 0}],
//!     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
//!     "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
//!     "bufferViews": [{"buffer": 0, "byteLength": 36}],
//!     "buffers": [{"byteLength": 36, "uri":
//!         "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]
//! }"#;
//! let loaded = lightmesh_io::load_gltf_bytes("inline.gltf", gltf, None, &Default::default())?;
//! assert_eq!(loaded.data.meshes[0].triangles, [[0, 1, 2]]);
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

mod beside;
mod budget;
mod environment_map;
mod error;
mod exr_chunk;
mod exr_dwa;
mod exr_file;
mod gltf;
mod load_options;
mod mesh_file;
mod obj;
pub mod output;
#[cfg(test)]
mod output_faults;
mod picture;
mod picture_file;
mod ply;
mod polygon;
mod radiance_file;
mod scene_bytes;
mod scene_file;
mod srgb;
mod texture_image;
mod warnings;
mod world_origin;

pub use environment_map::{EnvironmentMap, read_environment};
pub use error::Error;
pub use gltf::load_gltf_bytes;
pub use load_options::{LoadOptions, Loaded, Units};
pub use mesh_file::{
    MeshFile, Provenance, mesh_from_bytes, mesh_to_bytes, read_mesh, setting, write_mesh, write_mesh_to,
};
pub use picture::{Encoding, Picture, read_picture};
pub use scene_bytes::{scene_from_bytes, scene_to_bytes};
pub use scene_file::load;
