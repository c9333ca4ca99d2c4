//! Automatic exposure.

use glam::Vec3;

/// The grey on which the logarithmic mean of a picture is put, display-linear: the photographic 18%.
const KEY: f64 = 0.18;
/// The value that highlights may reach, display-linear. At 2 the tone map shows 0.97: still a little drawing in the
/// brightest parts. Empirical: looked at on interiors with lamps in view.
const HIGHLIGHT: f64 = 2.0;
/// The fraction of lit pixels that may be brighter than [`HIGHLIGHT`]: lamps themselves. Empirical, as above.
const LAMPS: f64 = 0.02;
/// The darkest and brightest fractions that the mean leaves out.
const TRIM: f64 = 0.05;
/// Pixels looked at; more do not change the answer visibly.
const SAMPLES: usize = 1 << 18;

/// The exposure, in EV as [`expose`](super::expose) takes it, at which a picture of linear cd/m² looks well.
///
/// The logarithmic mean of the luminance, without the darkest and the brightest twentieth, comes to 18% grey (Reinhard
/// et al., "Photographic tone reproduction for digital images", 2002, eq. 1-2); where that would burn out more than a
/// fiftieth of the picture, the exposure is lowered until it does not. Black pixels (nothing was hit, nothing is lit)
/// and NaN do not count. The result is a multiple of 0.01, so that it can be printed and given again; 0 for a black
/// picture.
pub fn auto_exposure(pixels: &[Vec3]) -> f32 {
    // Luminances of what is lit, from a regular subset of a large picture.
    let stride = pixels.len().div_ceil(SAMPLES).max(1);
    let mut luminances: Vec<f32> = pixels
        .iter()
        .step_by(stride)
        .map(|p| p.dot(Vec3::new(0.212_6, 0.715_2, 0.072_2)))
        .filter(|l| *l > 0.0 && l.is_finite())
        .collect();
    if luminances.is_empty() {
        return 0.0;
    }
    luminances.sort_unstable_by(f32::total_cmp);
    let n = luminances.len();

    // The trimmed logarithmic mean comes to the key.
    let cut = (TRIM * n as f64) as usize;
    let middle = &luminances[cut..n - cut];
    let mean = middle.iter().map(|&l| libm::log2(f64::from(l))).sum::<f64>() / middle.len() as f64;
    let for_key = libm::log2(KEY) - mean;

    // The highlights stay under their limit.
    let bright = f64::from(luminances[((1.0 - LAMPS) * (n - 1) as f64) as usize]);
    let for_highlights = libm::log2(HIGHLIGHT / bright);

    ((for_key.min(for_highlights) * 100.0).round() / 100.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant of luminance L: 2^EV · L = 0.18.
    #[test]
    fn a_constant_picture_comes_to_the_key() {
        let ev = auto_exposure(&[Vec3::splat(50.0); 100]);
        assert!((ev - (0.18_f32 / 50.0).log2()).abs() <= 0.005 + 1e-5, "{ev}");
        assert_eq!((ev * 100.0).round() / 100.0, ev);
    }

    /// Twice the light, one EV less.
    #[test]
    fn scales_with_the_light() {
        let picture: Vec<Vec3> = (1..500).map(|i| Vec3::splat(i as f32)).collect();
        let brighter: Vec<Vec3> = picture.iter().map(|p| *p * 4.0).collect();
        assert!((auto_exposure(&picture) - auto_exposure(&brighter) - 2.0).abs() < 0.011);
    }

    #[test]
    fn the_background_lamps_and_nan_do_not_count() {
        let room = vec![Vec3::ONE; 1000];
        let mut with = room.clone();
        with.extend([Vec3::ZERO; 3000]);
        with.extend([Vec3::splat(1e6); 10]);
        with.extend([Vec3::NAN; 10]);
        assert_eq!(auto_exposure(&room), auto_exposure(&with));
    }

    /// A tenth of the picture in the sun, the rest 2000 times darker: the sun's tenth is kept from burning out.
    #[test]
    fn large_highlights_lower_it() {
        let mut picture = vec![Vec3::ONE; 900];
        picture.extend([Vec3::splat(2000.0); 100]);
        assert!((auto_exposure(&picture) - (2.0_f32 / 2000.0).log2()).abs() < 0.01);
    }

    #[test]
    fn black_pictures_have_an_exposure_too() {
        assert_eq!(auto_exposure(&[Vec3::ZERO; 4]), 0.0);
        assert_eq!(auto_exposure(&[]), 0.0);
    }
}
