//! Automatic exposure.

use glam::Vec3;
use lightmesh::Image;

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
/// Display-linear value of a white surface in the light about the camera. Empirical: rooms by lamps are as bright as by
/// the mean of their pictures.
const WHITE: f64 = 0.42;
/// Stops between the exposure of the light and that of the picture up to which the light decides alone, and the part of
/// the rest by which the picture changes it, to more and to less: a dark model stays dark, and a view into another room
/// can be seen. What burns out is lost, what is dark is not.
const KEEP: f64 = 0.5;
const MORE: f64 = 0.2;
const LESS: f64 = 0.5;
/// A pixel of which less is lit says nothing.
const LEAST_PART: f32 = 0.02;

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

/// The exposure of a picture whose light is known ([`DisplayData::white_cd_m2`](lightmesh::DisplayData::white_cd_m2)):
/// a white surface in it comes to 0.42, whatever colours are in view, so that neighbouring views have nearly the same
/// one. Where the picture itself would have another one by more than half a stop ([`auto_exposure`] without its unlit
/// surfaces), the exposure goes a fifth of the way beyond that to more, half of it to less. [`auto_exposure`] where the light is not known.
pub fn exposure_of(image: &Image) -> f32 {
    let unlit = &image.display.unlit;
    let stride = image.pixels.len().div_ceil(SAMPLES).max(1);
    let lit = image.pixels.iter().enumerate().step_by(stride).filter_map(|(i, p)| match unlit.get(i) {
        Some(unlit) => {
            let part = 1.0 - unlit.w;
            (part > LEAST_PART).then(|| (luminance(*p - unlit.truncate()) / part, part))
        }
        None => Some((luminance(*p), 1.0)),
    });
    let metered: Vec<Metered> = lit.filter(|(l, _)| *l > 0.0 && l.is_finite()).collect();
    let is_black = metered.is_empty();
    let of_picture = of_metered(metered);
    rounded(match image.display.white_cd_m2.filter(|white| *white > 0.0) {
        None => of_picture,
        Some(white) => {
            let of_light = libm::log2(WHITE / f64::from(white));
            let away = if is_black { 0.0 } else { of_picture - of_light };
            let follow = if away > 0.0 { MORE } else { LESS };
            of_light + ((away.abs() - KEEP).max(0.0) * follow).copysign(away)
        }
    })
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

    /// A lit surface with more and more unlit paint beside it and on its edges.
    #[test]
    fn unlit_paint_does_not_count() {
        let lit: Vec<f32> = (0..400).map(|i| 1.0 + 0.01 * i as f32).collect();
        let picture = |others: usize, edge: f32| {
            let mut image = Image::new(1, 1, Vec::new());
            for &l in &lit {
                image.pixels.push(Vec3::splat(l * (1.0 - edge) + edge));
                image.display.unlit.push(Vec3::splat(edge).extend(edge));
            }
            image.pixels.extend(vec![Vec3::ONE; others]);
            image.display.unlit.extend(vec![glam::Vec4::ONE; others]);
            exposure_of(&image)
        };
        let alone = picture(0, 0.0);
        assert!((alone - (0.18_f32 / 2.8).log2()).abs() < 0.1, "{alone}");
        for (others, edge) in [(10, 0.0), (4000, 0.0), (100, 0.3)] {
            assert!((picture(others, edge) - alone).abs() <= 0.011, "{others} {edge}");
        }
    }

    /// Where the light is known a white, a grey and a black model have one exposure, and a room that is far darker than
    /// its light has a little more.
    #[test]
    fn the_light_decides_before_the_picture() {
        let of = |luminance: f32| {
            let mut image = Image::new(10, 10, vec![Vec3::splat(luminance); 100]);
            image.display.white_cd_m2 = Some(100.0);
            exposure_of(&image)
        };
        let of_light = (0.42_f32 / 100.0).log2();
        for luminance in [60.0, 40.0, 31.0] {
            assert!((of(luminance) - of_light).abs() < 0.006, "{luminance}");
        }
        let of_picture = (0.18_f32 / 0.5).log2();
        assert!((of(0.5) - (of_light + 0.2 * (of_picture - of_light - 0.5))).abs() < 0.01);
        assert!((of(0.0) - of_light).abs() < 0.006);
        let of_picture = (0.18_f32 / 400.0).log2();
        assert!((of(400.0) - (of_light + 0.5 * (of_picture - of_light + 0.5))).abs() < 0.01);
        // A little darker, a little more: never a jump.
        let steps: Vec<f32> = (0..60).map(|i| of(60.0 * 0.9_f32.powi(i))).collect();
        assert!(steps.windows(2).all(|w| w[1] >= w[0] && w[1] - w[0] < 0.1), "{steps:?}");
    }

    #[test]
    fn black_pictures_have_an_exposure_too() {
        assert_eq!(auto_exposure(&[Vec3::ZERO; 4]), 0.0);
        assert_eq!(auto_exposure(&[]), 0.0);
    }
}
