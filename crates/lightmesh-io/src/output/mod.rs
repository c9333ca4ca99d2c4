//! Finished pictures into files: PNG to look at, EXR to compute with.
//!
//! | | PNG | EXR |
//! |---|---|---|
//! | values | exposed, tone mapped, sRGB; unlit colours as they are | linear cd/m² |
//! | bits per channel | 8, dithered | 32-bit float, or 16-bit |
//! | layers | none | those of the frame, beside the light |
//! | carries | program, method, scene, settings, exposure, denoiser | the same, seconds, samples, estimated error, camera matrices |
//!
//! A PNG depends on the picture and the settings alone, so that equal renders are equal files; the seconds that a
//! render took stand in the EXR.

mod display;
mod dither;
mod exposure;
mod exr;
mod exr_channels;
mod file;
mod format;
mod metadata;
mod png;
mod tone_map;

#[cfg(test)]
pub(crate) use self::file::{Step, during};
pub use self::{
    exposure::{auto_exposure, exposure_of},
    exr::{Precision, write_exr},
    file::{Batch, StagedFile, claim, is_same_file},
    format::Format,
    metadata::{Denoised, Metadata},
    png::write_png,
    tone_map::{expose, tone_map},
};
pub use crate::srgb::{linear_from_srgb, srgb_from_linear};
