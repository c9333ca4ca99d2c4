//! Light meshes: illumination computed lazily at points of a mesh in space and interpolated to surfaces, so that shadow
//! rays are paid per mesh point and not per pixel.
//!
//! After V. A. Debelov and I. M. Sevastyanov, "Original approach to simulation of soft shadows and diffuse color
//! bleeding in ray tracing", GraphiCon 2001; *the paper* in all that follows.

#![forbid(unsafe_code)]

pub mod bvh;
mod error;
mod film;
pub mod geometry;
mod image;
mod integrator;
mod light_mesh;
pub mod metrics;
mod options;
mod progress;
mod render;
mod scene;

pub use error::Error;
pub use image::{Image, MeshStats, RayCounts, RenderStats, Seconds};
pub use light_mesh::LightMesh;
pub use options::{Falloff, Interpolation, Method, PaperScale, RenderOptions, Spacing};
pub use progress::{Progress, Stage};
pub use render::{Frame, render};
pub use scene::{
    AlphaMode, Camera, Filter, ImageData, Instance, Light, Material, Projection, Scene, SceneData, ShapeEntry, Texels,
    Texture, TextureRef, UvTransform, Wrap,
};
