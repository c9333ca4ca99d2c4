//! What is rendered: the plain description ([`SceneData`]) and the checked, built scene ([`Scene`]).

mod built;
mod camera;
mod data;
mod light;
mod light_samples;
mod material;
mod texture;
mod validate;

pub use built::Scene;
pub(crate) use camera::FilmRays;
pub use camera::{Camera, Projection};
pub use data::{Instance, SceneData, ShapeEntry};
pub use light::Light;
pub(crate) use light_samples::{Directions, LightSamples};
pub use material::{AlphaMode, Material};
pub(crate) use texture::Decode;
pub use texture::{Filter, ImageData, Texels, Texture, TextureRef, UvTransform, Wrap};
