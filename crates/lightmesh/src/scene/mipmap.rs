//! Smaller copies of an image, for lookups that average many of its texels.

use glam::Vec4;
use rayon::prelude::*;

use super::data::SceneData;
use super::texture::{ColorEncoding, Filter, ImageData, Texels, linear_from_byte};

/// An image's mip levels (Williams, "Pyramidal Parametrics", SIGGRAPH 1983): each has half the texels of the one before
/// in each direction, rounded down, and ends with a single texel. A texel is the mean of the part of the finer level
/// that it covers, in linear light, stored as the image is: 8-bit levels are sRGB again, within half a step of the
/// byte.
///
/// It takes a third of the image's memory, and up to as much as the image where that is a line of texels:
/// [`ImageData::mipmap_texels`].
#[derive(Debug)]
pub(crate) struct Mipmap {
    /// From level 1 on; the image itself is level 0.
    levels: Vec<ImageData>,
}

/// The mipmaps of a checked scene's images, in their order; empty ones of those that are never averaged. They are built
/// with the scene, not when a lookup first wants one: neighbouring pixels want the same one, and threads would wait for
/// it.
pub(crate) fn build_mipmaps(data: &SceneData) -> Vec<Mipmap> {
    let mut wanted = vec![false; data.images.len()];
    for r in data.materials.iter().flat_map(|material| material.averaged_textures()).flatten() {
        let texture = &data.textures[r.texture];
        wanted[texture.image] |= texture.filter == Filter::Bilinear;
    }
    let build = |(image, wanted): (&ImageData, &bool)| match wanted {
        true => Mipmap::new(image),
        false => Mipmap { levels: Vec::new() },
    };
    data.images.par_iter().zip(&wanted).map(build).collect()
}

impl Mipmap {
    /// The mipmap of an image of colours.
    pub(crate) fn new(image: &ImageData) -> Self {
        let mut levels: Vec<ImageData> = Vec::new();
        let mut finer: Vec<Vec4> = Vec::new();
        let (mut width, mut height) = (image.width, image.height);
        while width > 1 || height > 1 {
            let coarser = if levels.is_empty() {
                halve(width, height, |i| ColorEncoding::Srgb.texel(&image.texels, i))
            } else {
                halve(width, height, |i| finer[i])
            };
            (width, height) = (half(width), half(height));
            levels.push(ImageData { name: String::new(), width, height, texels: store(&coarser, &image.texels) });
            finer = coarser;
        }
        Self { levels }
    }

    /// Level `level` of the mipmap of `image`; the last one where there is none so coarse.
    pub(crate) fn level<'a>(&'a self, image: &'a ImageData, level: usize) -> &'a ImageData {
        match level.min(self.levels.len()) {
            0 => image,
            n => &self.levels[n - 1],
        }
    }
}

impl ImageData {
    /// Texels of all the smaller copies together that a built scene has of an image of colours of this size. 8 × 2:
    /// 4 × 1, 2 × 1 and 1 × 1, 7 texels.
    pub fn mipmap_texels(width: u32, height: u32) -> u64 {
        let (mut width, mut height, mut texels) = (width.max(1), height.max(1), 0_u64);
        while width > 1 || height > 1 {
            (width, height) = (half(width), half(height));
            texels = texels.saturating_add(u64::from(width) * u64::from(height));
        }
        texels
    }
}

fn half(n: u32) -> u32 {
    (n / 2).max(1)
}

/// The means of a level's texels, with half as many in each direction.
fn halve(width: u32, height: u32, texel: impl Fn(usize) -> Vec4) -> Vec<Vec4> {
    let columns: Vec<Span> = (0..half(width)).map(|i| Span::new(width, i)).collect();
    let mut means = Vec::with_capacity(columns.len() * half(height) as usize);
    for row in (0..half(height)).map(|j| Span::new(height, j)) {
        means.extend(columns.iter().map(|column| {
            let mut sum = Vec4::ZERO;
            for (y, &wy) in (row.first..).zip(row.weights()) {
                let start = y * width as usize + column.first;
                for (i, &wx) in (start..).zip(column.weights()) {
                    sum += texel(i) * (wx * wy);
                }
            }
            sum
        }));
    }
    means
}

/// What a texel covers of the finer level, in one direction.
struct Span {
    first: usize,
    weights: [f32; 3],
    count: usize,
}

impl Span {
    /// Texel `i` of the ⌊n / 2⌋ that n texels become. Two each where n is even; where it is odd, n = 2 m + 1, a texel
    /// is 2 + 1 / m finer ones wide, and these have the parts (m − i) / n, m / n and (i + 1) / n of it (Guthe and
    /// Heckbert, "Non-Power-of-Two Mipmapping", NVIDIA, 2005).
    pub(crate) fn new(n: u32, i: u32) -> Self {
        let (weights, count) = match n {
            1 => ([1.0, 0.0, 0.0], 1),
            _ if n.is_multiple_of(2) => ([0.5, 0.5, 0.0], 2),
            _ => ([n / 2 - i, n / 2, i + 1].map(|part| part as f32 / n as f32), 3),
        };
        Self { first: 2 * i as usize, weights, count }
    }

    fn weights(&self) -> &[f32] {
        &self.weights[..self.count]
    }
}

/// A level's texels, kept as those of the image are.
fn store(level: &[Vec4], like: &Texels) -> Texels {
    match like {
        Texels::Rgba32F(_) => Texels::Rgba32F(level.iter().map(Vec4::to_array).collect()),
        Texels::Rgba8(_) => {
            let bytes = bytes_of_linear();
            let index = |value: f32| (value * f32::from(u16::MAX) + 0.5) as u16;
            let color = |value: f32| bytes[usize::from(index(value))];
            let alpha = |value: f32| (value * 255.0 + 0.5) as u8;
            Texels::Rgba8(level.iter().map(|c| [color(c.x), color(c.y), color(c.z), alpha(c.w)]).collect())
        }
    }
}

/// The sRGB byte whose linear value is nearest to i / 65535. The darkest bytes lie twenty of these steps apart.
fn bytes_of_linear() -> &'static [u8] {
    static TABLE: std::sync::OnceLock<Box<[u8]>> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| {
        let mut byte = 0_u8;
        let nearest = |i: u16| {
            let value = f32::from(i) / f32::from(u16::MAX);
            while byte < u8::MAX && 2.0 * value > linear_from_byte(byte) + linear_from_byte(byte + 1) {
                byte += 1;
            }
            byte
        };
        (0..=u16::MAX).map(nearest).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{hash, unit_f32};

    /// A number in [0, 1) for each texel, without any order.
    fn noise(i: usize) -> f32 {
        unit_f32(hash(i as u32))
    }

    fn float_image(width: u32, height: u32) -> ImageData {
        let texels = (0..(width * height) as usize).map(|i| [noise(4 * i), noise(4 * i + 1), noise(4 * i + 2), 1.0]);
        ImageData { name: String::new(), width, height, texels: Texels::Rgba32F(texels.collect()) }
    }

    fn mean(image: &ImageData) -> Vec4 {
        let n = (image.width * image.height) as usize;
        (0..n).map(|i| ColorEncoding::Srgb.texel(&image.texels, i)).sum::<Vec4>() / n as f32
    }

    /// Whatever the size, each level has the mean of the image; rounding of f32 sums.
    #[test]
    fn every_level_keeps_the_mean() {
        for (width, height) in [(64, 16), (37, 21), (1, 13), (255, 2), (1, 1)] {
            let image = float_image(width, height);
            let mipmap = Mipmap::new(&image);
            for level in &mipmap.levels {
                assert!((mean(level) - mean(&image)).abs().max_element() < 1e-5, "{width}x{height}");
            }
            let texels: u64 = mipmap.levels.iter().map(|l| u64::from(l.width) * u64::from(l.height)).sum();
            assert_eq!(texels, ImageData::mipmap_texels(width, height));
            assert!(mipmap.levels.last().is_none_or(|l| (l.width, l.height) == (1, 1)));
        }
    }

    /// Where a side is a power of two, a texel of level 2 is the mean of the 4 × 4 texels that it covers.
    #[test]
    fn texels_are_means_of_what_they_cover() {
        let image = float_image(16, 8);
        let mipmap = Mipmap::new(&image);
        let texel = |image: &ImageData, x: u32, y: u32| {
            ColorEncoding::Srgb.texel(&image.texels, (y * image.width + x) as usize)
        };
        for (x, y) in [(0, 0), (3, 1), (2, 0)] {
            let sum: Vec4 = (0..16).map(|i| texel(&image, 4 * x + i % 4, 4 * y + i / 4)).sum();
            let level = mipmap.level(&image, 2);
            assert!((texel(level, x, y) - sum / 16.0).abs().max_element() < 1e-6);
        }
    }

    /// Bytes are averaged as light: black and white make linear ½, sRGB 188, and equal bytes stay what they are.
    #[test]
    fn bytes_are_averaged_in_linear_light() {
        let bytes = |texels: &[[u8; 4]]| {
            let image = ImageData { name: String::new(), width: 2, height: 1, texels: Texels::Rgba8(texels.into()) };
            match &Mipmap::new(&image).levels[0].texels {
                Texels::Rgba8(t) => t[0],
                Texels::Rgba32F(_) => unreachable!("levels are kept as the image is"),
            }
        };
        assert_eq!(bytes(&[[0, 255, 0, 255], [255, 255, 0, 0]]), [188, 255, 0, 128]);
        for byte in 0..=255 {
            assert_eq!(bytes(&[[byte; 4]; 2]), [byte; 4]);
        }
    }
}
