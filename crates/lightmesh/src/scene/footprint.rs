//! Lookups that average the part of a texture that a sample stands for.

use glam::{Vec2, Vec4};

use super::mipmap::Mipmap;
use super::texture::{ColorEncoding, Filter, ImageData, LookupRow, Texture, UvTransform, wrap_to_period};

/// The part of a texture that a sample covers: the parallelogram of two vectors about a point beside the one that it
/// hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Its sides, in texture coordinates.
    pub sides: [Vec2; 2],
    /// From the point that was hit to its middle, in texture coordinates.
    pub offset: Vec2,
}

/// Lookups at most for one footprint, as GPUs have them. A footprint that is longer than so many times its width is
/// looked up sparsely, not more coarsely: what is missed is noise that more samples remove, and stripes that run along
/// it stay sharp.
const MOST_TAPS: f32 = 16.0;

impl Footprint {
    /// A single point.
    pub(crate) const POINT: Self = Self { sides: [Vec2::ZERO; 2], offset: Vec2::ZERO };

    /// The footprint in the coordinates that a triangle's corners have, if it is one in its second and third
    /// barycentric coordinates.
    pub(crate) fn mapped(self, corners: [Vec2; 3]) -> Self {
        let (b, c) = (corners[1] - corners[0], corners[2] - corners[0]);
        let map = |side: Vec2| b * side.x + c * side.y;
        Self { sides: self.sides.map(map), offset: map(self.offset) }
    }

    /// The footprint in the coordinates that a transform makes.
    pub(crate) fn transformed(self, transform: &UvTransform) -> Self {
        Self { sides: self.sides.map(|side| transform.matrix * side), offset: transform.matrix * self.offset }
    }

    /// Returns the row of lookups that replaces the footprint on an image, or `None` if it is no longer than a texel:
    /// the image is magnified.
    ///
    /// A parallelogram of sides a and b spreads its light as the ellipse does whose axes are the eigenvectors of aaᵀ +
    /// bbᵀ, the roots of its eigenvalues their lengths (Heckbert, "Fundamentals of Texture Mapping and Image Warping",
    /// 1989, section 3.5).
    fn taps(self, image: &ImageData) -> Option<Taps> {
        let size = Vec2::new(image.width as f32, image.height as f32);
        let [a, b] = self.sides.map(|side| side * size);
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let apart = 0.5 * (xx - yy);
        let root = (apart * apart + xy * xy).sqrt();
        let major2 = 0.5 * (xx + yy) + root;
        // Not after an overflow either: the footprint is unknown then.
        if !(major2 > 1.0 && major2 < f32::INFINITY) {
            return None;
        }
        // The square of the minor axis, no less than a texel, times major2.
        let area = a.perp_dot(b);
        let area2 = (area * area).max(major2);
        // The eigenvector's larger component, not 0 for a circle either, and its smaller one.
        let larger = (apart.abs() + root).max(1e-6 * major2);
        let scale = (major2 / (larger * larger + xy * xy)).sqrt();
        let (larger, smaller) = (larger * scale, xy * scale);
        let major = if xx > yy { Vec2::new(larger, smaller) } else { Vec2::new(smaller, larger) };
        let count = (major2 / area2.sqrt() + 0.5).min(MOST_TAPS);
        let (level, above) = level_of(area2 / major2);
        Some(Taps { major, count: count as u32, level, above })
    }
}

/// Lookups along the longer axis of a footprint, each as wide as the shorter one (as Feline and GPUs do: McCormack et
/// al., "Feline: Fast Elliptical Lines for Anisotropic Texture Mapping", SIGGRAPH 1999, with equal weights: a box, not
/// a Gaussian).
struct Taps {
    /// The longer axis, in texels.
    major: Vec2,
    count: u32,
    /// The finer of two levels of the mipmap, and the part of the coarser one.
    level: usize,
    above: f32,
}

/// Which two levels make a lookup of width² `width2` ≥ 1 (texels²), and the part of the coarser one.
///
/// A bilinear lookup in level l, of texels 2ˡ wide that are means themselves, spreads light with a variance of (1/12 +
/// 1/6) 4ˡ − 1/12; a box of width w seen through the image's own bilinear lookup has w² / 12 + 1/6. Levels mix so that
/// they agree, 4ˡ = 1 + w² / 3, up to the third of a texel² that lets a width of one texel be the image itself: 4ˡ =
/// (2 + w²) / 3. At whole levels that is √3 sharper than one texel per width, which GPUs use.
fn level_of(width2: f32) -> (usize, f32) {
    let scale2 = (2.0 + width2) / 3.0;
    let level = (scale2.to_bits() >> 23).saturating_sub(127) / 2;
    let of_level = f32::from_bits((127 + 2 * level) << 23);
    (level as usize, (scale2 / of_level - 1.0) / 3.0)
}

impl Texture {
    /// Returns the mean linear RGBA over `footprint` about `uv`; `mipmap` is called if the image is minified. Where it is
    /// not, and always for [`Filter::Nearest`], whose texels are meant to be seen, the result is that of
    /// [`Texture::sample`], bit for bit.
    pub(crate) fn sample_over<'a>(
        &self,
        image: &'a ImageData,
        mipmap: impl FnOnce() -> &'a Mipmap,
        uv: Vec2,
        footprint: Footprint,
        decode: ColorEncoding,
    ) -> Vec4 {
        let taps = match self.filter {
            Filter::Nearest => None,
            Filter::Bilinear => footprint.taps(image),
        };
        let Some(taps) = taps else { return self.sample(image, uv, decode) };
        // Most lookups are in the first period then, where none has to be divided by the size.
        let middle = uv + footprint.offset;
        let major = taps.major / Vec2::new(image.width as f32, image.height as f32);
        let middle = Vec2::new(wrap_to_period(self.wrap_s, middle.x), wrap_to_period(self.wrap_t, middle.y));
        let along = |image: &ImageData, count: u32| {
            let step = major / count as f32;
            let row = LookupRow { first: middle - step * (0.5 * (count - 1) as f32), step, count };
            self.sample_row(image, row, decode)
        };
        if taps.level == 0 && taps.above == 0.0 {
            return along(image, taps.count);
        }
        let mipmap = mipmap();
        let fine = along(mipmap.level(image, taps.level), taps.count);
        if taps.above == 0.0 {
            return fine;
        }
        // The coarser level is twice as wide, and half as many cover the footprint.
        fine.lerp(along(mipmap.level(image, taps.level + 1), taps.count.div_ceil(2)), taps.above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Texels, Wrap};

    const TEXTURE: Texture = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Bilinear };

    fn image(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> ImageData {
        let texels = (0..width * height).map(|i| {
            let v = value(i % width, i / width);
            [v, v, v, 1.0]
        });
        ImageData { name: String::new(), width, height, texels: Texels::Rgba32F(texels.collect()) }
    }

    fn over(texture: &Texture, image: &ImageData, uv: Vec2, sides: [Vec2; 2]) -> f32 {
        let mipmap = Mipmap::new(image);
        texture.sample_over(image, || &mipmap, uv, Footprint { sides, offset: Vec2::ZERO }, ColorEncoding::Linear).x
    }

    /// A checkerboard of single texels is grey from afar, wherever it is looked at and however it is turned.
    #[test]
    fn a_checkerboard_far_away_is_its_mean() {
        let board = image(64, 64, |x, y| ((x + y) % 2) as f32);
        for i in 0..100 {
            let uv = Vec2::new(0.37 * i as f32, -0.61 * i as f32);
            let turn = Vec2::from_angle(0.1 * i as f32) * 0.2;
            let grey = over(&TEXTURE, &board, uv, [turn, turn.perp() * 1.7]);
            assert!((grey - 0.5).abs() < 1e-5, "{grey}");
        }
    }

    /// Up to a footprint of a texel, turned or not, lookups are those without one, bit for bit, and no mipmap is
    /// needed.
    #[test]
    fn magnified_lookups_are_unchanged() {
        let picture = image(17, 9, |x, y| ((7 * x + 3 * y) % 5) as f32);
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            let texture = Texture { wrap_s: wrap, wrap_t: wrap, ..TEXTURE };
            for i in 0..100 {
                let uv = Vec2::new(0.0173 * i as f32 - 0.5, 0.031 * i as f32 - 1.0);
                let texel = Vec2::new(1.0 / 17.0, 1.0 / 9.0);
                let angle = Vec2::from_angle(i as f32);
                let sides = [angle * texel * 0.999, angle.perp() * texel * 0.999];
                let footprint = Footprint { sides, offset: Vec2::ONE };
                let value =
                    texture.sample_over(&picture, || unreachable!("no mipmap"), uv, footprint, ColorEncoding::Linear);
                assert_eq!(value, texture.sample(&picture, uv, ColorEncoding::Linear));
            }
        }
    }

    /// Stripes of four texels, looked at with a footprint 64 texels long and one wide: along the stripes they stay as
    /// they are, across they become grey.
    #[test]
    fn long_footprints_blur_one_direction_only() {
        let stripes = image(256, 256, |x, _| (x / 4 % 2) as f32);
        let (long, short) = (64.0 / 256.0, 1.0 / 256.0);
        for i in 0..50 {
            let uv = Vec2::new(0.0137 * i as f32, 0.4);
            let along = over(&TEXTURE, &stripes, uv, [Vec2::new(short, 0.0), Vec2::new(0.0, long)]);
            assert!((along - TEXTURE.sample(&stripes, uv, ColorEncoding::Linear).x).abs() < 1e-5);
            let across = over(&TEXTURE, &stripes, uv, [Vec2::new(long, 0.0), Vec2::new(0.0, short)]);
            assert!((across - 0.5).abs() < 0.01, "{across}");
        }
    }

    /// Means commute with linear functions: of a ramp, any footprint has the value in its middle. 64 texels a side,
    /// sides up to 12 texels; coarse levels meet the ramp's ends at the seam, which are kept 16 texels away.
    #[test]
    fn a_ramp_keeps_its_value() {
        let ramp = image(64, 64, |x, y| 2.0 * x as f32 + y as f32);
        for i in 0..50 {
            let uv = Vec2::new(0.5, 0.4 + 0.004 * i as f32);
            let side = Vec2::from_angle(0.3 * i as f32) * (0.004 * i as f32);
            let value = over(&TEXTURE, &ramp, uv, [side, side.perp() * 0.4]);
            let expected = 2.0 * (uv.x * 64.0 - 0.5) + (uv.y * 64.0 - 0.5);
            assert!((value - expected).abs() < 1e-3, "{value} {expected}");
        }
    }

    /// 4ˡ = (2 + w²) / 3 at and between whole levels: the mix of variances is the wanted one.
    #[test]
    fn levels_mix_to_the_width() {
        assert_eq!(level_of(1.0), (0, 0.0));
        assert_eq!(level_of(10.0), (1, 0.0));
        for width2 in [1.0_f32, 1.5, 4.0, 9.9, 10.1, 300.0, 1e6] {
            let (level, above) = level_of(width2);
            let of_level = 4.0_f32.powi(level as i32);
            let mixed = of_level * (1.0 - above) + 4.0 * of_level * above;
            assert!((0.0..1.0).contains(&above) && (mixed * 3.0 / (2.0 + width2) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn nearest_is_not_filtered() {
        let board = image(8, 8, |x, y| ((x + y) % 2) as f32);
        let nearest = Texture { filter: Filter::Nearest, ..TEXTURE };
        assert_eq!(over(&nearest, &board, Vec2::splat(0.01), [Vec2::X, Vec2::Y]), 0.0);
    }

    /// Footprints that overflow are looked up as points.
    #[test]
    fn absurd_footprints_are_points() {
        let board = image(8, 8, |x, y| ((x + y) % 2) as f32);
        for absurd in [f32::NAN, f32::INFINITY, 1e30] {
            let value = over(&TEXTURE, &board, Vec2::splat(0.3), [Vec2::splat(absurd), Vec2::Y]);
            assert_eq!(value, TEXTURE.sample(&board, Vec2::splat(0.3), ColorEncoding::Linear).x);
        }
    }
}
