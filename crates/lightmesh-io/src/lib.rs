//! Scenes in, pictures out.
mod stub_reader;
pub use stub_reader::{Error, LoadOptions, Loaded, Units, load};
