//! Finished pictures: the noisy part is taken out, denoised, and put back.

use glam::Vec3;
use lightmesh::{Aov, Aovs, Image, Layer, Progress};
use rayon::prelude::*;

use crate::noise::layers_to_denoise;
use crate::{Denoiser, Error, Guides, Resources};

/// Albedos below this count as this much: light divided by less would spread far beyond its surface where the library
/// blurs it. Empirical: 0.02 has the same error, 0.1 a larger one.
const LEAST_ALBEDO: f32 = 0.05;
/// Light whose neighbours are so close to it, relative to the brightest of them, has no noise and is left as it is; up
/// to [`NOISY`] it is blended. Empirical: the library changes lamps that are seen by up to 41% at their edges, and they
/// keep their light so; with 2 to 10%, errors of noisy pictures are larger.
const SMOOTH: f32 = 0.001;
/// See [`SMOOTH`].
const NOISY: f32 = 0.01;

/// Memory that [`denoise_picture`] takes beside the picture, its layers and what the library takes, bytes per pixel: the
/// light, before and after, what it is divided by, a white albedo, the result, and how smooth the light is.
const BYTES_PER_PIXEL: u64 = 5 * 12 + 4;
/// What the library takes for itself where it must do with little: so much, bytes per pixel up to the size of its tiles,
/// and some whatever the size. Measured with version 2.5: 25 MiB for 64 x 64 pixels, 193 for 512 x 512, 416 for
/// 1024 x 1024, 395 for 1920 x 1080; without a limit it takes 1378 there, and half the time.
const LIBRARY_BYTES_PER_PIXEL: u64 = 720;
/// See [`LIBRARY_BYTES_PER_PIXEL`].
const LIBRARY_TILE_BYTES: u64 = 400 << 20;
/// See [`LIBRARY_BYTES_PER_PIXEL`].
const LIBRARY_BYTES: u64 = 24 << 20;

/// Memory that denoising takes, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DenoisingBytes {
    /// The picture, its layers and what [`denoise_picture`] makes of them.
    pub picture: u64,
    /// The least that the library works with; it takes more, and less time, where it may.
    pub library: u64,
}

impl DenoisingBytes {
    /// Returns what a picture with these layers takes.
    pub fn of(width: u32, height: u32, layers: Aovs) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        let per_pixel = size_of::<Vec3>() as u64 + layers.bytes_per_pixel() + BYTES_PER_PIXEL;
        let tile = pixels.saturating_mul(LIBRARY_BYTES_PER_PIXEL).min(LIBRARY_TILE_BYTES);
        Self { picture: pixels.saturating_mul(per_pixel), library: LIBRARY_BYTES + tile }
    }
}

/// Takes the noise out of a picture, of which only the `noisy` layers have any: what the others and neither layer show
/// stays as it is, and so do pixels that see nothing, or unlit surfaces.
///
/// Each layer is divided by the albedo, denoised along the edges of the normals, and multiplied by the albedo again: no
/// pattern on a surface gets lost. Tried: the albedo as a guide beside that leaves patterns in light that has none, 16.8
/// instead of 8.6% error on a staircase of planks.
///
/// # Errors
/// [`Error::MissingLayers`], [`Error::Size`], [`Error::Library`], [`Error::Cancelled`]; the picture is unchanged then.
pub fn denoise_picture(
    denoiser: &Denoiser,
    image: &mut Image,
    layers: &[Layer],
    noisy: Aovs,
    resources: Resources,
    progress: &dyn Progress,
) -> Result<(), Error> {
    // Find the layers, all of one size.
    let find = |aov: Aov| layers.iter().find(|layer| layer.aov == aov);
    let missing: Vec<&str> =
        layers_to_denoise(noisy).iter().filter(|&aov| find(aov).is_none()).map(Aov::name).collect();
    if !missing.is_empty() {
        return Err(Error::MissingLayers { missing });
    }
    let values = |aov: Aov| -> Result<&[Vec3], Error> {
        let values = find(aov).map_or(&[][..], |layer| &layer.values);
        let (width, height, found) = (image.width, image.height, values.len() as u64);
        let expected = 3 * u64::from(width) * u64::from(height);
        let is_whole = found == expected && image.pixels.len() as u64 * 3 == expected;
        is_whole.then(|| bytemuck::cast_slice(values)).ok_or(Error::Size {
            image: aov.name(),
            width,
            height,
            expected,
            found,
        })
    };
    if noisy.is_empty() {
        return Ok(());
    }
    let (albedo, normal) = (values(Aov::Albedo)?, values(Aov::Normal)?);

    // Denoise the light of white surfaces, layer by layer, and add what changes.
    let width = image.width as usize;
    let white = vec![1.0; 3 * albedo.len()];
    let mut pixels = image.pixels.clone();
    for aov in noisy.iter() {
        let layer = values(aov)?;
        let divisors = divisors(width, layer, albedo);
        let light: Vec<Vec3> = layer.par_iter().zip(&divisors).map(|(&light, &divisor)| light / divisor).collect();
        let guides = Guides { albedo: &white, normal: bytemuck::cast_slice(normal) };
        let denoised =
            denoiser.denoise(image.width, image.height, bytemuck::cast_slice(&light), guides, resources, progress)?;
        let denoised: &[Vec3] = bytemuck::cast_slice(&denoised);
        let spreads = spreads(width, &light);
        pixels.par_iter_mut().enumerate().for_each(|(i, pixel)| {
            let weight = noise_weight(least_of_windows(width, &spreads, i));
            let denoised = denoised[i].min(brightest_possible(width, &light, i));
            *pixel += weight * (denoised - light[i]) * divisors[i];
        });
    }

    // Keep pixels that surfaces do not light, or not all of them, and those that the sum would make no numbers.
    let unlit = &image.display.unlit;
    image.pixels.par_iter_mut().enumerate().zip(pixels).zip(albedo).for_each(|(((i, pixel), denoised), &albedo)| {
        let is_lit = albedo != Vec3::ZERO && unlit.get(i).is_none_or(|unlit| unlit.w == 0.0);
        if is_lit && denoised.is_finite() {
            *pixel = denoised.max(Vec3::ZERO);
        }
    });
    Ok(())
}

/// What the light of each pixel is divided by: its albedo, and 1 where there is none.
///
/// Beside pixels without albedo, a sky or a black lamp, a pixel may show a part of their light; divided by the small
/// albedo of what else it shows, that would be far too bright for its neighbours. There, what comes out is at most as
/// bright as the sky, or as what neighbours have that do not see it.
fn divisors(width: usize, light: &[Vec3], albedo: &[Vec3]) -> Vec<Vec3> {
    let about = |center| window(width, albedo.len(), center);
    let is_black = |i: usize| albedo[i] == Vec3::ZERO;
    let is_edge = |i: usize| !is_black(i) && about(i).any(is_black);
    let plain = |i: usize| if is_black(i) { Vec3::ONE } else { albedo[i].max(Vec3::splat(LEAST_ALBEDO)) };
    let divisor = |center: usize| {
        let (plain_here, own) = (plain(center), light[center].max_element());
        if !is_edge(center) {
            return plain_here;
        }
        let sky = about(center).filter(|&i| is_black(i)).map(|i| light[i].max_element()).fold(0.0, f32::max);
        let inside = about(center).filter(|&i| !is_black(i) && !is_edge(i));
        let brightest = inside.map(|i| (light[i] / plain(i)).max_element()).fold(sky, f32::max);
        if own > 0.0 && own <= sky { plain_here.max(Vec3::splat(own / brightest)) } else { plain_here }
    };
    (0..albedo.len()).into_par_iter().map(divisor).collect()
}

/// The eight neighbours of a pixel and itself, as far as the picture has them.
fn window(width: usize, pixels: usize, center: usize) -> impl Iterator<Item = usize> {
    window_of(1, width, pixels, center)
}

/// The pixels of a square about one, as far as the picture has them: `reach` to each side.
fn window_of(reach: usize, width: usize, pixels: usize, center: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (center % width, center / width);
    let height = pixels / width;
    let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
    let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
    rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// How bright light may become: a pixel that is among the bright ones of dark surroundings, 5 x 5, as on a sill in the
/// sun, no brighter than the brightest there, which the library made up to twice as bright. All others, such as those
/// that noise has left dark, become what they become.
fn brightest_possible(width: usize, light: &[Vec3], center: usize) -> Vec3 {
    let about = || window_of(2, width, light.len(), center).map(|i| light[i]);
    let (brightest, count) = about().fold((Vec3::ZERO, 0.0), |(brightest, n), light| (brightest.max(light), n + 1.0));
    let (most, mean) = (brightest.max_element(), about().map(Vec3::max_element).sum::<f32>() / count);
    let stands_out = 2.0 * light[center].max_element() >= most && 2.0 * mean <= most;
    if stands_out { brightest } else { Vec3::INFINITY }
}

/// By pixel, how far the light of its window is apart, as a part of the brightest; 1 where all of it is black, because
/// noise may have missed the light there.
fn spreads(width: usize, light: &[Vec3]) -> Vec<f32> {
    let spread = |center| {
        let none = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY));
        let (low, high) =
            window(width, light.len(), center).fold(none, |(low, high), i| (low.min(light[i]), high.max(light[i])));
        let brightest = high.max_element();
        if brightest > 0.0 { (high - low).max_element() / brightest } else { 1.0 }
    };
    (0..light.len()).into_par_iter().map(spread).collect()
}

/// The spread of the smoothest window that holds the pixel: on the edge of a lamp, one that lies on the lamp.
fn least_of_windows(width: usize, spreads: &[f32], pixel: usize) -> f32 {
    window(width, spreads.len(), pixel).map(|i| spreads[i]).fold(1.0, f32::min)
}

/// How much of what denoising changes is taken, 0 to 1.
fn noise_weight(spread: f32) -> f32 {
    ((spread - SMOOTH) / (NOISY - SMOOTH)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Effort;
    use crate::denoiser::tests::{self, with_library};

    const WIDTH: u32 = 64;
    const HEIGHT: u32 = 48;
    const PIXELS: usize = (WIDTH * HEIGHT) as usize;
    const RESOURCES: Resources = Resources { threads: 1, max_memory: 1 << 30, effort: Effort::Full };

    fn layer(aov: Aov, value: impl Fn(usize) -> Vec3) -> Layer {
        Layer { aov, values: (0..PIXELS).flat_map(|i| value(i).to_array()).collect() }
    }

    /// A picture of its direct light, with the layers that denoising reads.
    fn picture(albedo: impl Fn(usize) -> Vec3, direct: impl Fn(usize) -> Vec3) -> (Image, Vec<Layer>) {
        let image = Image::new(WIDTH, HEIGHT, (0..PIXELS).map(&direct).collect());
        let layers = vec![layer(Aov::Albedo, albedo), layer(Aov::Normal, |_| Vec3::Z), layer(Aov::Direct, direct)];
        (image, layers)
    }

    fn direct() -> Aovs {
        [Aov::Direct].into_iter().collect()
    }

    /// A number in [0, 1) for each channel of a pixel.
    fn random(pixel: usize) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|channel| tests::random(3 * pixel + channel)))
    }

    #[test]
    fn missing_layers_are_named() {
        with_library(|denoiser| {
            let (mut image, mut layers) = picture(|_| Vec3::ONE, |_| Vec3::ONE);
            layers.remove(1);
            let noisy = [Aov::Direct, Aov::Indirect].into_iter().collect();
            let error = denoise_picture(denoiser, &mut image, &layers, noisy, RESOURCES, &()).expect_err("no normals");
            assert_eq!(error.to_string(), "the picture lacks the layer(s) normal, indirect, which denoising reads");
        });
    }

    #[test]
    fn layers_of_another_size_are_refused() {
        with_library(|denoiser| {
            let (mut image, mut layers) = picture(|_| Vec3::ONE, |_| Vec3::ONE);
            layers[2].values.pop();
            let result = denoise_picture(denoiser, &mut image, &layers, direct(), RESOURCES, &());
            assert!(matches!(result, Err(Error::Size { image: "direct", .. })), "{result:?}");
        });
    }

    /// Light without noise stays, bit for bit: on one surface, on two, and on a lamp that is 10,000 times as bright.
    #[test]
    fn light_without_noise_stays() {
        with_library(|denoiser| {
            let half = |i: usize| i % WIDTH as usize >= 32;
            for (left, right) in [(0.5, 0.5), (0.2, 0.9), (0.5, 5000.0)] {
                let light = |i| Vec3::splat(if half(i) { right } else { left });
                let (mut image, layers) = picture(|_| Vec3::splat(0.7), light);
                denoise_picture(denoiser, &mut image, &layers, direct(), RESOURCES, &()).expect("a picture");
                assert!(image.pixels.iter().enumerate().all(|(i, &pixel)| pixel == light(i)), "{left} {right}");
            }
        });
    }

    /// Noise goes, the pattern of the surface and the mean of the light stay, and pixels that see no surface, too.
    #[test]
    fn noise_goes_and_patterns_stay() {
        with_library(|denoiser| {
            let sky = |i: usize| i < 10 * WIDTH as usize;
            let albedo = |i: usize| match (sky(i), (i / 3) % 2) {
                (true, _) => Vec3::ZERO,
                (false, 0) => Vec3::new(0.8, 0.4, 0.1),
                _ => Vec3::new(0.1, 0.2, 0.05),
            };
            let noisy = |i: usize| if sky(i) { random(i) } else { albedo(i) * 10.0 * random(i) };
            let (mut image, layers) = picture(albedo, noisy);
            denoise_picture(denoiser, &mut image, &layers, direct(), RESOURCES, &()).expect("a picture");
            // A mean of 5, with a standard deviation of 10/√12.
            let relative = |i: usize, pixel: Vec3| {
                ((pixel / albedo(i) - 5.0) / (10.0 / 12_f32.sqrt())).powf(2.0).element_sum() / 3.0
            };
            let surface: Vec<(usize, Vec3)> =
                image.pixels.iter().copied().enumerate().filter(|&(i, _)| !sky(i)).collect();
            let variance = surface.iter().map(|&(i, pixel)| relative(i, pixel)).sum::<f32>() / surface.len() as f32;
            assert!(variance < 0.02, "{variance}");
            let sum =
                |light: &dyn Fn(usize, Vec3) -> Vec3| surface.iter().map(|&(i, pixel)| light(i, pixel)).sum::<Vec3>();
            let ratio = sum(&|_, pixel| pixel) / sum(&|i, _| noisy(i));
            assert!((ratio - 1.0).abs().max_element() < 0.03, "{ratio}");
            assert!((0..PIXELS).filter(|&i| sky(i)).all(|i| image.pixels[i] == noisy(i)));
        });
    }

    /// What control variates make negative comes out at 0 or above, and finite.
    #[test]
    fn pixels_are_finite_and_not_negative() {
        with_library(|denoiser| {
            let light = |i: usize| if i == 777 { Vec3::splat(1e30) } else { random(i) - 0.6 };
            let (mut image, layers) = picture(|i| random(i) * 0.001, light);
            denoise_picture(denoiser, &mut image, &layers, direct(), RESOURCES, &()).expect("a picture");
            assert!(image.pixels.iter().all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0));
        });
    }

    /// The albedo, but at least a twentieth, and 1 in a sky. Beside the sky it is so much that what may be light of the
    /// sky stays below it; a surface that is brighter than the sky shows its own.
    #[test]
    fn light_is_divided_by_the_albedo() {
        let divided = |sky: f32| {
            let albedo = [0.0, 0.1, 0.5, 0.01].map(Vec3::splat);
            divisors(4, &[sky, 0.9, 0.25, 1.0].map(Vec3::splat), &albedo).iter().map(|d| d.x).collect::<Vec<_>>()
        };
        assert_eq!(divided(1.0), [1.0, 0.9, 0.5, 0.05]);
        assert_eq!(divided(0.4), [1.0, 0.1, 0.5, 0.05]);
    }

    /// A bright sky behind the edge of a surface does not shine on the surface, although pixels there see a tenth of the
    /// surface and nine tenths of the sky.
    #[test]
    fn skies_do_not_bleed() {
        with_library(|denoiser| {
            let row = |i: usize| i / WIDTH as usize;
            let albedo = |i: usize| {
                Vec3::splat(match row(i) {
                    0..=19 => 0.0,
                    20 => 0.05,
                    _ => 0.5,
                })
            };
            let light = |i: usize| match row(i) {
                0..=19 => Vec3::splat(1000.0),
                20 => Vec3::splat(900.0) + random(i) * 0.1,
                _ => random(i),
            };
            let (mut image, layers) = picture(albedo, light);
            denoise_picture(denoiser, &mut image, &layers, direct(), RESOURCES, &()).expect("a picture");
            let mean = |first: usize, last: usize| {
                let rows = &image.pixels[first * WIDTH as usize..last * WIDTH as usize];
                rows.iter().copied().sum::<Vec3>().element_sum() / (3 * rows.len()) as f32
            };
            // The surface has 0.5 in the mean.
            assert!((mean(22, 24) - 0.5).abs() < 0.1, "{}", mean(22, 24));
            assert!((mean(30, 48) - 0.5).abs() < 0.03, "{}", mean(30, 48));
        });
    }

    #[test]
    fn windows_end_at_the_picture() {
        assert!(window(3, 9, 0).eq([0, 1, 3, 4]));
        assert!(window(3, 9, 4).eq(0..9));
        assert!(window(3, 9, 8).eq([4, 5, 7, 8]));
        assert!(window(1, 1, 0).eq([0]));
    }

    /// Of a bright line in the dark, the line is held and the dark is not; nor is an even light.
    #[test]
    fn bright_lines_are_held() {
        let bounds = |light: &dyn Fn(usize) -> f32| -> Vec<f32> {
            let light: Vec<Vec3> = (0..8).flat_map(|_| (0..8).map(|x| Vec3::splat(light(x)))).collect();
            (0..8).map(|x| brightest_possible(8, &light, 24 + x).x).collect()
        };
        let free = f32::INFINITY;
        assert_eq!(bounds(&|x| if x == 4 { 9.0 } else { 1.0 }), [free, free, free, free, 9.0, free, free, free]);
        assert_eq!(bounds(&|x| 1.0 + x as f32 / 8.0), [free; 8]);
    }

    /// A step is smooth on both of its sides and black is not; noise is smooth nowhere.
    #[test]
    fn smooth_light_is_found() {
        let weights = |light: &dyn Fn(usize) -> f32| -> Vec<f32> {
            let light: Vec<Vec3> = (0..8).flat_map(|_| (0..8).map(|x| Vec3::splat(light(x)))).collect();
            let spreads = spreads(8, &light);
            (0..8).map(|x| noise_weight(least_of_windows(8, &spreads, 24 + x))).collect()
        };
        assert_eq!(weights(&|x| if x < 4 { 1.0 } else { 9.0 }), [0.0; 8]);
        assert_eq!(weights(&|_| 0.0), [1.0; 8]);
        assert_eq!(weights(&|x| if x % 2 == 0 { 1.0 } else { 1.1 }), [1.0; 8]);
    }

    /// 64 B for each pixel beside its light and its layers, and what was measured of the library.
    #[test]
    fn memory_is_counted() {
        let layers = layers_to_denoise(direct());
        assert_eq!(DenoisingBytes::of(100, 10, layers).picture, 1000 * (12 + 36 + 64));
        assert_eq!(DenoisingBytes::of(u32::MAX, u32::MAX, layers).picture, u64::MAX);
        for (width, height, measured_mib) in
            [(64, 64, 25), (256, 256, 65), (512, 512, 193), (1024, 1024, 416), (3840, 2160, 395)]
        {
            let mib = DenoisingBytes::of(width, height, layers).library >> 20;
            assert!((measured_mib..measured_mib + 32).contains(&mib), "{width} x {height}: {mib} MiB");
        }
    }
}
