//! Tone mapping: from scene luminance to the values of a display.
//!
//! The curve is the highlight compression of the **Khronos PBR Neutral** tone mapper
//! (<https://github.com/KhronosGroup/ToneMapping>, `PBR_Neutral`), without its toe.
//!
//! # Why this one?
//! A picture of a lit room should show an albedo as itself and a coloured lamp in its own colour.
//!
//! | curve | below white | hue of bright colours |
//! |---|---|---|
//! | clipping | unchanged | shifts as channels clip one after the other |
//! | Reinhard, filmic and ACES per channel | contrast and saturation change | shifts, blue towards violet |
//! | AgX | low contrast, wants a grade | drifts on the way to white |
//! | PBR Neutral | unchanged up to 0.8 | kept; only saturation falls on the way to white |
//!
//! Its toe subtracts the 4% that a dielectric's surface reflects of white surroundings. Our pictures are mostly diffuse
//! and their dark parts are soft shadows: the toe would crush what the method is for, so it is left out (F90 = 0).

use glam::Vec3;

/// The value where compression starts; smaller values pass unchanged. Khronos' constant.
const START: f32 = 0.8;
/// The rate at which compressed colours lose saturation. Khronos' constant.
const DESATURATION: f32 = 0.15;

/// The display-linear colour of an exposed one; each channel of the result in [0, 1].
///
/// Monotone in brightness; a colour whose largest channel is under 0.8 passes unchanged. Negative channels and NaN
/// count as 0, infinity as white.
pub fn tone_map(color: Vec3) -> Vec3 {
    // Meet values that no display can show. 1e30 is white to the last bit and leaves room for the products below.
    let finite = |c: f32| if c > 0.0 { c.min(1e30) } else { 0.0 };
    let color = Vec3::new(finite(color.x), finite(color.y), finite(color.z));

    let peak = color.max_element();
    if peak < START {
        return color;
    }
    // Compress the largest channel: slope 1 at START, white at infinity.
    let room = 1.0 - START;
    let compressed = 1.0 - room * room / (peak + room - START);
    // Scale the others with it, which keeps the hue, then mix towards white.
    let scaled = color * (compressed / peak);
    let to_white = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    scaled.lerp(Vec3::splat(compressed), to_white).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The exposed colour: luminance in cd/m² times 2^`ev`. At 0 EV, 1 cd/m² becomes 1.
pub fn expose(color: Vec3, ev: f32) -> Vec3 {
    color * libm::exp2f(ev)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_under_the_start_pass_unchanged() {
        let c = Vec3::new(0.79, 0.2, 0.0);
        assert_eq!(tone_map(c), c);
    }

    /// newPeak = 1 − d²/(peak + d − start): at peak 2, 1 − 0.04/1.4.
    #[test]
    fn the_peak_follows_the_published_formula() {
        let c = tone_map(Vec3::splat(2.0));
        assert!((c - Vec3::splat(1.0 - 0.04 / 1.4)).abs().max_element() < 1e-6, "{c}");
    }

    /// Along every ray of colour, brightness never falls and each result can be shown.
    #[test]
    fn monotone_and_displayable() {
        for hue in [Vec3::ONE, Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.0, 0.3, 1.0)] {
            let mut last = 0.0;
            for i in 0..400 {
                let c = tone_map(hue * libm::exp2f(0.05 * i as f32 - 10.0));
                assert!(c.min_element() >= 0.0 && c.max_element() <= 1.0);
                assert!(c.max_element() >= last, "{hue} at step {i}");
                last = c.max_element();
            }
            assert!(last > 0.99);
        }
    }

    /// The order of the channels, and the hue angle (Preucil's, from the differences of channels), stay.
    #[test]
    fn hue_is_kept() {
        let hue = |c: Vec3| libm::atan2f(3.0_f32.sqrt() * (c.y - c.z), 2.0 * c.x - c.y - c.z);
        for c in [Vec3::new(9.0, 3.0, 1.0), Vec3::new(0.2, 1.5, 4.0), Vec3::new(1.0, 30.0, 20.0)] {
            assert!((hue(c) - hue(tone_map(c))).abs() < 1e-4);
        }
    }

    #[test]
    fn values_that_are_no_light_are_met() {
        assert_eq!(tone_map(Vec3::new(f32::NAN, -1.0, 0.5)), Vec3::new(0.0, 0.0, 0.5));
        let white = tone_map(Vec3::splat(f32::INFINITY));
        assert!((white - Vec3::ONE).abs().max_element() < 1e-6);
    }

    #[test]
    fn an_ev_is_a_factor_of_two() {
        assert_eq!(expose(Vec3::new(100.0, 50.0, 4.0), -2.0), Vec3::new(25.0, 12.5, 1.0));
    }
}
