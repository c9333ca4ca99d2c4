//! Automatic exposure.

use glam::Vec3;
use lightmesh::{DisplayData, Image};

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

/// Stops from the median at which a pixel counts no more than that: a few black corners or bright spots do not move the
/// mean.
const FAR: f64 = 5.0;
/// The least part of a picture that decides about its exposure; where lit surfaces are less, all of it does.
const LEAST_LIT: f64 = 0.002;
/// A pixel of which less is lit says nothing.
const LEAST_PART: f32 = 0.02;
/// Display-linear value of a white surface in the studio that is added to scenes without light.
const WHITE: f64 = 0.85;
/// Stops between the exposure that shows such a white and the one of the picture's mean up to which the white counts
/// alone, and from which on the mean does: a model keeps its colours, but a room that only a window lights is not dark.
const KEEP: f64 = 2.0;
const FOLLOW: f64 = 4.5;

/// The part of the picture that shows no lit surface up to which the mean may count, and from which on it does not: a
/// black model stands before the background, a room has windows. Empirical, as the stops.
const WINDOWS: f64 = 0.3;
const BACKGROUND: f64 = 0.6;

/// A luminance, cd/m², and how much it counts.
type Metered = (f32, f32);

/// The exposure, in EV as [`expose`](super::expose) takes it, at which a picture of linear cd/m² looks well.
///
/// The logarithmic mean of the luminance, without the darkest and the brightest twentieth, comes to 18% grey (Reinhard
/// et al., "Photographic tone reproduction for digital images", 2002, eq. 1-2); where that would burn out more than a
/// fiftieth of the picture, the exposure is lowered until it does not. Black pixels (nothing was hit, nothing is lit)
/// and NaN do not count. The result is a multiple of 0.01, so that it can be printed and given again; 0 for a black
/// picture.
pub fn auto_exposure(pixels: &[Vec3]) -> f32 {
    let stride = pixels.len().div_ceil(SAMPLES).max(1);
    rounded(of_metered(pixels.iter().step_by(stride).map(|p| (luminance(*p), 1.0)).collect()))
}

/// [`auto_exposure`] of what is lit in a picture: the background, lamps and unlit surfaces do not count, so that a
/// camera which turns towards a window or a lamp changes little. Where the renderer has added the light of a studio, a
/// white surface in it is shown as white as long as the mean is not far from that.
pub fn exposure_of(image: &Image) -> f32 {
    let DisplayData { unmetered, white_cd_m2, .. } = &image.display;
    if unmetered.len() != image.pixels.len() {
        return auto_exposure(&image.pixels);
    }
    let stride = image.pixels.len().div_ceil(SAMPLES).max(1);
    let parts = image.pixels.iter().zip(unmetered).step_by(stride).filter_map(|(p, left_out)| {
        let part = 1.0 - left_out.x;
        (part > LEAST_PART).then(|| ((luminance(*p) - left_out.y) / part, part))
    });
    let metered: Vec<Metered> = parts.filter(|(l, _)| *l > 0.0 && l.is_finite()).collect();
    let lit: f64 = metered.iter().map(|&(_, part)| f64::from(part)).sum();
    if lit * (stride as f64) < LEAST_LIT * image.pixels.len() as f64 {
        return auto_exposure(&image.pixels);
    }
    let ev = of_metered(metered);
    rounded(match white_cd_m2.filter(|white| *white > 0.0) {
        None => ev,
        Some(white) => {
            let anchor = libm::log2(WHITE / f64::from(white));
            let away = ev - anchor;
            let others = 1.0 - lit * stride as f64 / image.pixels.len() as f64;
            anchor + away * smooth_step(away.abs(), KEEP, FOLLOW) * (1.0 - smooth_step(others, WINDOWS, BACKGROUND))
        }
    })
}

/// From 0 at `from` to 1 at `to`.
fn smooth_step(x: f64, from: f64, to: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.212_6, 0.715_2, 0.072_2))
}

/// A multiple of 0.01.
fn rounded(ev: f64) -> f32 {
    ((ev * 100.0).round() / 100.0) as f32
}

/// The exposure of luminances with weights; 0 where all are black.
fn of_metered(mut metered: Vec<Metered>) -> f64 {
    metered.retain(|(l, _)| *l > 0.0 && l.is_finite());
    if metered.is_empty() {
        return 0.0;
    }
    metered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let all: f64 = metered.iter().map(|&(_, w)| f64::from(w)).sum();
    let quantile = |q: f64| {
        let mut sum = 0.0;
        let found = metered.iter().find(|&&(_, w)| {
            sum += f64::from(w);
            sum >= q * all
        });
        libm::log2(f64::from(found.or(metered.last()).map_or(1.0, |&(l, _)| l)))
    };

    // The logarithmic mean comes to the key, without both ends, and with what is far off drawn near.
    let (median, mut before, mut sum, mut weights) = (quantile(0.5), 0.0, 0.0, 0.0);
    for &(l, w) in &metered {
        // The part of its weight that lies between the ends.
        let (from, to) = (before, before + f64::from(w));
        let inside = to.min((1.0 - TRIM) * all) - from.max(TRIM * all);
        if inside > 0.0 {
            sum += inside * libm::log2(f64::from(l)).clamp(median - FAR, median + FAR);
            weights += inside;
        }
        before = to;
    }
    let for_key = libm::log2(KEY) - sum / weights;

    // The highlights stay under their limit.
    let for_highlights = libm::log2(HIGHLIGHT) - quantile(1.0 - LAMPS);
    for_key.min(for_highlights)
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

    /// The same lit surface, with more and more of a bright background, a lamp and unlit paint beside and behind it.
    #[test]
    fn what_is_not_lit_does_not_count() {
        let lit: Vec<f32> = (0..400).map(|i| 1.0 + 0.01 * i as f32).collect();
        let picture = |others: usize, edge: f32| {
            let mut image = Image::new(1, 1, Vec::new());
            for &l in &lit {
                image.pixels.push(Vec3::splat(l * (1.0 - edge) + 500.0 * edge));
                image.display.unmetered.push(glam::Vec2::new(edge, 500.0 * edge));
            }
            for i in 0..others {
                image.pixels.push(Vec3::splat(7.0 * i as f32));
                image.display.unmetered.push(glam::Vec2::new(1.0, 7.0 * i as f32));
            }
            exposure_of(&image)
        };
        let alone = picture(0, 0.0);
        assert!((alone - (0.18_f32 / 2.8).log2()).abs() < 0.1, "{alone}");
        for (others, edge) in [(10, 0.0), (4000, 0.0), (100, 0.3)] {
            assert!((picture(others, edge) - alone).abs() <= 0.011, "{others} {edge}");
        }
    }

    /// In the studio a white, a grey and a black model have one exposure; a room 100 times darker has another one.
    #[test]
    fn white_stays_white_in_the_studio() {
        let of = |luminance: f32| {
            let mut image = Image::new(10, 10, vec![Vec3::splat(luminance); 100]);
            image.display.unmetered = vec![glam::Vec2::ZERO; 100];
            image.display.white_cd_m2 = Some(100.0);
            exposure_of(&image)
        };
        let anchor = (0.85_f32 / 100.0).log2();
        for luminance in [60.0, 20.0, 6.0] {
            assert!((of(luminance) - anchor).abs() < 0.006, "{luminance}");
        }
        assert!((of(0.5) - (0.18_f32 / 0.5).log2()).abs() < 0.01);
        // Black before a background of two thirds.
        let mut image = Image::new(10, 30, [vec![Vec3::splat(0.5); 100], vec![Vec3::splat(25.0); 200]].concat());
        image.display.unmetered = [vec![glam::Vec2::ZERO; 100], vec![glam::Vec2::new(1.0, 25.0); 200]].concat();
        image.display.white_cd_m2 = Some(100.0);
        assert!((exposure_of(&image) - anchor).abs() < 0.006);
        // A little darker, a little more: never a jump.
        let steps: Vec<f32> = (0..60).map(|i| of(60.0 * 0.9_f32.powi(i))).collect();
        assert!(steps.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 0.5), "{steps:?}");
    }

    #[test]
    fn black_pictures_have_an_exposure_too() {
        assert_eq!(auto_exposure(&[Vec3::ZERO; 4]), 0.0);
        assert_eq!(auto_exposure(&[]), 0.0);
    }
}
