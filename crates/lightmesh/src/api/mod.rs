//! The front doors: a picture through a camera, and irradiance at meters.

mod measure;
mod render;

pub use measure::{Measured, measure};
pub(crate) use render::new_film;
pub use render::{Frame, render};
