//! What is rendered, as a plain description: meshes, materials, lights, cameras.

mod camera;
mod data;
mod emitter_options;
mod environment;
mod far_view;
mod footprint;
pub(crate) mod light;
mod material;
mod mipmap;
mod texture;
pub(crate) mod validate;

pub use camera::{Camera, FilmRays, Projection};
pub use data::{Instance, SceneData, ShapeEntry};
pub use emitter_options::EmitterOptions;
pub use environment::{Environment, soft_environment};
pub(crate) use footprint::Footprint;
pub use light::Light;
pub use material::{AlphaMode, Material};
pub(crate) use mipmap::{Mipmap, build_mipmaps};
pub(crate) use texture::ColorEncoding;
pub use texture::{Filter, ImageData, Texels, Texture, TextureRef, UvTransform, Wrap};
