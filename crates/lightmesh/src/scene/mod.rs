//! What is rendered: the plain description ([`SceneData`]) and the checked, built scene ([`Scene`]).

mod built;
mod camera;
mod data;
pub(crate) mod emitters;
mod environment;
mod footprint;
mod light;
mod light_samples;
mod light_terms;
mod light_tree;
mod material;
mod pyramid;
mod texture;
mod validate;

pub use built::Scene;
pub use camera::{Camera, FilmRays, Projection};
pub use data::{Instance, SceneData, ShapeEntry};
pub use environment::{EmitterOptions, Environment, soft_environment};
pub(crate) use footprint::Footprint;
pub use light::Light;
pub(crate) use light_samples::{Directions, Emission, LANES, LightSamples, Luminaire};
pub(crate) use light_terms::{BlockTerms, LightTerms, Receiver};
pub(crate) use light_tree::{LightTree, Receivers, Refinement, Tolerance};
pub use material::{AlphaMode, Material};
pub(crate) use texture::Decode;
pub use texture::{Filter, ImageData, Texels, Texture, TextureRef, UvTransform, Wrap};
