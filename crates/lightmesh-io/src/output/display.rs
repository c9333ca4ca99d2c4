//! A pixel as a display shows it.

use glam::Vec3;
use lightmesh::Image;

use super::{expose, tone_map};

/// A pixel's part that is lit, under which it counts as unlit: rounding errors of a sum over samples.
const UNLIT: f32 = 1e-4;

/// Whether a pixel shows nothing but an unlit surface.
pub(super) fn is_unlit(image: &Image, pixel: usize) -> bool {
    image.display.unlit.get(pixel).is_some_and(|unlit| unlit.w > 1.0 - UNLIT)
}

/// Returns the display-linear colour of a pixel: its light exposed by `ev` and tone mapped, but for the part that unlit
/// surfaces cover, which keep their colour.
pub(super) fn color(image: &Image, pixel: usize, ev: f32) -> Vec3 {
    let light = image.pixels[pixel];
    let unlit = match image.display.unlit.get(pixel) {
        Some(unlit) if unlit.w > 0.0 => unlit,
        _ => return tone_map(expose(light, ev)),
    };
    let (color, lit) = (unlit.truncate(), 1.0 - unlit.w.min(1.0));
    if lit < UNLIT {
        return color.clamp(Vec3::ZERO, Vec3::ONE);
    }
    let rest = (light - color).max(Vec3::ZERO) / lit;
    (tone_map(expose(rest, ev)) * lit + color).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use glam::Vec4;
    use lightmesh::DisplayData;

    use super::*;

    /// A whole pixel keeps the colour at any exposure; half of one is the mean of both sides, each as it is alone.
    #[test]
    fn unlit_colours_stand_outside_the_exposure() {
        let (paint, light) = (Vec3::new(1.0, 0.5, 0.1), Vec3::splat(300.0));
        let mut image = Image::new(3, 1, vec![paint, 0.5 * (paint + light), light]);
        image.display =
            DisplayData { unlit: vec![paint.extend(1.0), (0.5 * paint).extend(0.5), Vec4::ZERO], white_cd_m2: None };
        for ev in [-12.0, -8.0, 0.0, 9.0] {
            let [whole, half, none] = [0, 1, 2].map(|i| color(&image, i, ev));
            assert_eq!(whole, paint);
            assert_eq!(none, tone_map(expose(light, ev)));
            assert!((half - 0.5 * (whole + none)).abs().max_element() < 1e-5, "{half}");
        }
    }
}
