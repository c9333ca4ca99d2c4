//! How far one picture is from another: in linear values ([`difference()`]) and to the eye ([`flip()`]).

mod difference;
mod flip;

pub use difference::{Difference, difference};
pub use flip::{FLIP_PIXELS_PER_DEGREE, flip};
