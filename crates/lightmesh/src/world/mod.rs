//! The scene that is rendered: its description, checked, with what is built from it.

mod scene;
mod sheets;

pub use scene::Scene;
