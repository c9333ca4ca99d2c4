//! Values as plain arrays of numbers, and the checks of arrays that come from elsewhere.

use glam::{Vec3, Vec4};

use crate::Error;

/// Returns red, green and blue of each value; the fourth component is 0 everywhere.
pub(crate) fn rgb(values: &[Vec4]) -> impl Iterator<Item = f32> {
    values.iter().flat_map(|v| v.truncate().to_array())
}

/// Returns the values of which [`rgb`] made these numbers.
pub(crate) fn values(rgb: &[f32]) -> impl Iterator<Item = Vec4> {
    rgb.chunks_exact(3).map(|c| Vec3::from_slice(c).extend(0.0))
}

/// Returns an error that names a place in a snapshot and what is wrong there.
pub(crate) fn refuse<T>(place: impl Into<String>, what: impl Into<String>) -> Result<T, Error> {
    Err(Error::InvalidContents { place: place.into(), what: what.into() })
}

/// Refuses an array whose length is not the product of its shape.
pub(crate) fn check_length(place: &str, length: usize, shape: &[usize]) -> Result<(), Error> {
    let expected = shape.iter().fold(1_usize, |product, &n| product.saturating_mul(n));
    if length == expected {
        return Ok(());
    }
    refuse(place, format!("has {length} numbers; its shape {shape:?} has {expected}"))
}

/// Refuses numbers that are not finite.
pub(crate) fn check_finite(place: &str, numbers: &[f32]) -> Result<(), Error> {
    match numbers.iter().position(|x| !x.is_finite()) {
        Some(i) => refuse(place, format!("number {i} is {}, not finite", numbers[i])),
        None => Ok(()),
    }
}
