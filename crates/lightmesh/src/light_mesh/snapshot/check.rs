//! Values as numbers in a row, and checking those that come from elsewhere.

use glam::{Vec3, Vec4};

use crate::Error;

/// Red, green and blue of each value; the fourth component is 0 everywhere.
pub(super) fn rgb(values: &[Vec4]) -> Vec<f32> {
    values.iter().flat_map(|v| v.truncate().to_array()).collect()
}

/// The inverse of [`rgb`].
pub(super) fn values(rgb: &[f32]) -> impl Iterator<Item = Vec4> {
    rgb.chunks_exact(3).map(|c| Vec3::from_slice(c).extend(0.0))
}

/// Something is wrong with contents.
pub(super) fn refuse<T>(place: impl Into<String>, what: impl Into<String>) -> Result<T, Error> {
    Err(Error::InvalidContents { place: place.into(), what: what.into() })
}

/// Refuses an array that has not the length that its shape asks for.
pub(super) fn check_length(place: &str, length: usize, shape: &[usize]) -> Result<(), Error> {
    let expected = shape.iter().fold(1_usize, |product, &n| product.saturating_mul(n));
    if length == expected {
        return Ok(());
    }
    refuse(place, format!("has {length} numbers; its shape {shape:?} has {expected}"))
}

/// Refuses numbers that no light has.
pub(super) fn check_finite(place: &str, numbers: &[f32]) -> Result<(), Error> {
    match numbers.iter().position(|x| !x.is_finite()) {
        Some(i) => refuse(place, format!("number {i} is {}, not finite", numbers[i])),
        None => Ok(()),
    }
}
