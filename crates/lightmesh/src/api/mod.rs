//! The front doors: a picture through a camera, and irradiance at meters; and how bright it is about a camera.

mod for_scene;
mod light_around;
mod measure;
mod render;

pub(crate) use light_around::white_around;
pub use measure::{Measured, measure};
pub(crate) use render::new_film;
pub use render::{Frame, render};
