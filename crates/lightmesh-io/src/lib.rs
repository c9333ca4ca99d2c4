//! Scenes in, pictures out.

pub mod output;
mod picture;
mod picture_error;
mod stub_reader;

pub use picture::{Encoding, Picture, read_picture};
pub use picture_error::PictureError;
pub use stub_reader::{Error, LoadOptions, Loaded, Units, load};
