//! The sRGB transfer curve, IEC 61966-2-1.

/// The encoded value of a linear one, both in [0, 1]; values outside are clamped, NaN gives 0.
pub fn srgb_from_linear(linear: f32) -> f32 {
    let c = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * libm::powf(c, 1.0 / 2.4) - 0.055 }
}

/// The linear value of an encoded one, both in [0, 1].
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every byte survives the way to linear light and back.
    #[test]
    fn bytes_round_trip() {
        for byte in 0..=255_u8 {
            let linear = linear_from_srgb(f32::from(byte) / 255.0);
            assert_eq!((255.0 * srgb_from_linear(linear)).round() as u8, byte);
        }
    }

    /// 18% grey is sRGB 0.4613; sRGB 188/255 is linear 0.5029.
    #[test]
    fn known_values_and_the_ends() {
        assert!((srgb_from_linear(0.18) - 0.461_356).abs() < 1e-5);
        assert!((linear_from_srgb(188.0 / 255.0) - 0.502_886).abs() < 1e-5);
        assert_eq!((linear_from_srgb(0.0), linear_from_srgb(1.0)), (0.0, 1.0));
        assert_eq!((srgb_from_linear(-1.0), srgb_from_linear(f32::NAN)), (0.0, 0.0));
        assert!((srgb_from_linear(7.0) - 1.0).abs() < 1e-6);
    }
}
