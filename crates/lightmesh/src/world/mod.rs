//! The scene that is rendered: its description, checked, with what is built from it.

mod background;
mod scene;
mod sheets;

pub(crate) use background::{Background, GroundShadow};
pub use scene::Scene;
