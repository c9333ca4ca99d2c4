//! What is rendered: the plain description ([`SceneData`]) and the checked, built scene ([`Scene`]).

mod built;
mod camera;
mod data;
mod headlight;
mod light;
mod material;
mod texture;

pub use built::Scene;
pub use camera::{Camera, Projection};
pub use data::{Instance, SceneData, ShapeEntry};
pub use headlight::headlight;
pub use light::Light;
pub use material::{AlphaMode, Material};
pub use texture::{Filter, ImageData, Texels, Texture, TextureRef, UvTransform, Wrap};
