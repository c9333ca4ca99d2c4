//! Light at surfaces: the four tracers and what they share.
//!
//! The reflection model is documented at [`Material`](crate::Material).

mod direct;
mod path;
mod place;
mod sampling;
mod surface;
mod visibility;
mod wave;

pub(crate) use path::render_path;
pub(crate) use sampling::{film_samples, hash};
pub(crate) use surface::{Vertex, is_back_face};
pub(crate) use visibility::{VisibilityScratch, visibility};
pub(crate) use wave::{Lighting, render_waves};
