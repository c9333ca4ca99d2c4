//! Takes the noise out of pictures of `lightmesh` with Open Image Denoise (<https://www.openimagedenoise.org>), a library
//! that is looked for and loaded when a program asks for it: nothing here needs it to build.
//!
//! ```no_run
//! use lightmesh::{Frame, Method};
//! use lightmesh_denoise::{Denoiser, Effort, Resources, denoise_picture, noisy_layers};
//!
//! fn clean(frame: &mut Frame, method: Method) -> Result<(), lightmesh_denoise::Error> {
//!     let denoiser = Denoiser::load()?;
//!     let resources = Resources { threads: 8, max_memory: 1 << 30, effort: Effort::Full };
//!     // The frame was rendered with `layers_to_denoise(noisy)` among its layers.
//!     let noisy = noisy_layers(method, true);
//!     denoise_picture(&denoiser, &mut frame.image, &frame.layers, noisy, resources, &())
//! }
//! ```

#![deny(unsafe_code)]

mod denoiser;
mod error;
mod library;
mod noise;
mod picture;
mod resources;
mod search;

pub use denoiser::{Denoiser, Guides};
pub use error::Error;
pub use noise::{layers_to_denoise, noisy_layers};
pub use picture::{DenoisingBytes, denoise_picture};
pub use resources::{Effort, Resources};
pub use search::Places;
