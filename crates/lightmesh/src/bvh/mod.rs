//! The ray kernel: which surface does a ray meet first, and does it meet any?
//!
//! An 8-wide bounding volume hierarchy over blocks of four triangles, traversed with SIMD chosen at run time, with
//! results that are the same bit for bit at every SIMD level. Closed meshes are closed for rays too: no ray passes
//! between two triangles that share an edge.

mod binary_tree;
mod brute_force;
mod collapse;
mod flatten;
mod hit;
mod node;
mod presplit;
mod scene_bvh;
mod top_level;
mod traverse;
mod triangle_block;
mod triangle_bvh;

#[cfg(test)]
mod tests;

pub use brute_force::closest_brute_force;
pub(crate) use flatten::flattened_meshes;
pub use hit::{Hit, Target};
pub use scene_bvh::SceneBvh;
pub use triangle_bvh::TriangleBvh;
