//! The scene that is rendered: its description, checked, with what is built from it.

mod background;
mod field_memory;
mod scene;
mod scene_memory;
mod sheets;

pub(crate) use background::{Background, GroundShadow};
pub(crate) use field_memory::FieldMemory;
pub use scene::Scene;
