//! Pixels that no display can show: not numbers, or below black.

use glam::{Vec3, Vec4};

use crate::{Image, Layer, Method};

/// Makes pixels black whose light or layers are infinite or not a number, as numbers near the ends of the range of 32-bit
/// floats may leave them; returns how many they are. One such pixel would spread over every picture that is filtered or
/// scaled.
pub(crate) fn blacken_non_finite(image: &mut Image, layers: &mut [Layer]) -> u64 {
    let mut count = 0;
    for (pixel, light) in image.pixels.iter_mut().enumerate() {
        let unlit = image.display.unlit.get_mut(pixel);
        let values = |layer: &Layer| {
            let channels = layer.aov.channels().len();
            pixel * channels..(pixel + 1) * channels
        };
        let is_finite = light.is_finite()
            && unlit.as_ref().is_none_or(|unlit| unlit.is_finite())
            && layers.iter().all(|layer| layer.values[values(layer)].iter().all(|value| value.is_finite()));
        if is_finite {
            continue;
        }
        count += 1;
        *light = Vec3::ZERO;
        if let Some(unlit) = unlit {
            *unlit = Vec4::ZERO;
        }
        for layer in &mut *layers {
            let values = values(layer);
            layer.values[values].fill(0.0);
        }
    }
    count
}

/// Cuts noise below black, once all samples of a pixel are in. Only *unbiased* promises an expectation.
pub(crate) fn cut_noise_below_black(image: &mut Image, method: Method) {
    if !matches!(method, Method::Unbiased { .. }) {
        image.pixels.iter_mut().for_each(|light| *light = light.max(Vec3::ZERO));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aov, DisplayData};

    #[test]
    fn a_pixel_without_a_number_is_black_in_all_layers() {
        let pixels = vec![Vec3::ONE, Vec3::new(1.0, f32::NAN, 1.0), Vec3::ONE, Vec3::ONE];
        let unlit = vec![Vec4::ONE, Vec4::ONE, Vec4::splat(f32::INFINITY), Vec4::ONE];
        let mut image = Image { display: DisplayData { unlit, white_cd_m2: None }, ..Image::new(4, 1, pixels) };
        let mut layers = vec![
            Layer { aov: Aov::Albedo, values: vec![0.5; 12] },
            Layer { aov: Aov::Depth, values: vec![2.0, 2.0, 2.0, f32::NEG_INFINITY] },
        ];
        assert_eq!(blacken_non_finite(&mut image, &mut layers), 3);
        assert_eq!(image.pixels, [Vec3::ONE, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO]);
        assert_eq!(image.display.unlit, [Vec4::ONE, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO]);
        assert_eq!(layers[0].values[..3], [0.5; 3]);
        assert_eq!((&layers[0].values[3..], &layers[1].values[..]), (&[0.0; 9][..], &[2.0, 0.0, 0.0, 0.0][..]));
        assert_eq!(blacken_non_finite(&mut image, &mut layers), 0);
    }

    #[test]
    fn only_unbiased_keeps_noise_below_black() {
        let noisy = Image::new(2, 1, vec![Vec3::new(-1.0, 2.0, 0.0), Vec3::ONE]);
        let (mut cut, mut kept) = (noisy.clone(), noisy.clone());
        cut_noise_below_black(&mut cut, Method::AUTO);
        cut_noise_below_black(&mut kept, Method::unbiased(4));
        assert_eq!((cut.pixels[0], &kept.pixels), (Vec3::new(0.0, 2.0, 0.0), &noisy.pixels));
    }
}
