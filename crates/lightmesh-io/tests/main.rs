//! All tests of files in and out, as one program: it links once.

mod common;
mod environment_maps;
mod gltf_environment;
mod gltf_files;
mod gltf_geometry;
mod gltf_materials;
mod gltf_nodes;
mod gltf_shared;
mod mesh_files;
mod own_scenes;
mod pictures;
