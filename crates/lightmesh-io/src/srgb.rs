//! The sRGB transfer curve.

/// The linear value of an sRGB-encoded one, both in [0, 1] (IEC 61966-2-1).
pub(crate) fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sRGB 188/255 is linear 0.5029.
    #[test]
    fn known_values() {
        assert_eq!((linear_from_srgb(0.0), linear_from_srgb(1.0)), (0.0, 1.0));
        assert!((linear_from_srgb(188.0 / 255.0) - 0.502_886).abs() < 1e-5);
    }
}
