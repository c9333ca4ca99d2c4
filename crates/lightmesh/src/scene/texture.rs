//! Images and how surfaces look them up.

use std::sync::Arc;

use glam::{Mat2, Vec2, Vec4};

/// Texels of an image, row by row from the upper left corner.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Texels {
    /// 8 bits per channel, RGBA; colours are sRGB-encoded or linear as their use says.
    Rgba8(Arc<[[u8; 4]]>),
    /// 32-bit float RGBA, linear.
    Rgba32F(Arc<[[f32; 4]]>),
}

/// A decoded image.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ImageData {
    /// Name or URI, for messages; may be empty.
    pub name: String,
    /// Texels per row, > 0.
    pub width: u32,
    /// Rows, > 0.
    pub height: u32,
    /// `width · height` texels.
    pub texels: Texels,
}

/// How an image continues outside [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// Every other copy is mirrored.
    MirroredRepeat,
    /// The border texel continues.
    ClampToEdge,
}

/// How texels are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Filter {
    /// The four nearest, weighted.
    #[default]
    Bilinear,
    /// The one nearest.
    Nearest,
}

/// An image with its sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Texture {
    /// Index into [`SceneData::images`](super::data::SceneData::images).
    pub image: usize,
    /// Horizontally.
    pub wrap_s: Wrap,
    /// Vertically.
    pub wrap_t: Wrap,
    /// How texels are combined. With [`Filter::Bilinear`], colours are averaged over the footprint of a camera sample
    /// if it is larger than a texel.
    pub filter: Filter,
}

/// KHR_texture_transform: `uv' = translation · rotation · scale · uv`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct UvTransform {
    /// The linear part.
    pub matrix: Mat2,
    /// The translation.
    pub offset: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { matrix: Mat2::IDENTITY, offset: Vec2::ZERO }
    }
}

impl UvTransform {
    /// From the extension's three properties; `rotation` in radians, counter-clockwise as KHR_texture_transform defines
    /// it.
    pub fn new(offset: Vec2, rotation: f32, scale: Vec2) -> Self {
        let (sin, cos) = (libm::sinf(rotation), libm::cosf(rotation));
        let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        Self { matrix: rotation * Mat2::from_diagonal(scale), offset }
    }

    /// The transformed coordinate.
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        self.matrix * uv + self.offset
    }
}

/// A material's reference to a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TextureRef {
    /// Index into [`SceneData::textures`](super::data::SceneData::textures).
    pub texture: usize,
    /// 0 or 1: which of the mesh's texture coordinate sets.
    pub uv_set: usize,
    /// KHR_texture_transform; identity by default.
    pub transform: UvTransform,
}

/// Lookups at equal distances.
#[derive(Clone, Copy, Debug)]
pub(super) struct LookupRow {
    /// Texture coordinates of the first.
    pub first: Vec2,
    /// From each to the next.
    pub step: Vec2,
    /// How many they are, at least 1.
    pub count: u32,
}

impl Texture {
    /// The linear RGBA at `uv`; `decode` turns a stored texel into linear RGBA.
    pub(crate) fn sample(&self, image: &ImageData, uv: Vec2, decode: ColorEncoding) -> Vec4 {
        self.sample_row(image, LookupRow { first: uv, step: Vec2::ZERO, count: 1 }, decode)
    }

    /// Returns the mean of a row of lookups.
    pub(super) fn sample_row(&self, image: &ImageData, row: LookupRow, decode: ColorEncoding) -> Vec4 {
        // One loop body for each way to store texels: many lookups make a picture.
        match (&image.texels, decode) {
            (Texels::Rgba32F(t), _) => self.mean(image, row, t, |t| Vec4::from_array(*t)),
            (Texels::Rgba8(t), ColorEncoding::Linear) => self.mean(image, row, t, |t| linear_from_bytes(*t)),
            (Texels::Rgba8(t), ColorEncoding::Srgb) => {
                let table = srgb_table();
                self.mean(image, row, t, |t| linear_from_srgb_bytes(table, *t))
            }
        }
    }

    #[inline(always)]
    fn mean<T>(&self, image: &ImageData, row: LookupRow, texels: &[T], decode: impl Fn(&T) -> Vec4) -> Vec4 {
        let LookupRow { first, step, count } = row;
        let scale = 1.0 / count as f32;
        if self.filter == Filter::Bilinear {
            let size = Vec2::new(image.width as f32, image.height as f32);
            let (start, step) = (first * size - 0.5, step * size);
            let end = start + step * (count - 1) as f32;
            // Most rows are inside, where nothing wraps.
            if start.min(end).cmpge(Vec2::ZERO).all() && start.max(end).cmplt(size - 1.0).all() {
                let lookup = |i: u32| inside(texels, image.width as usize, start + step * i as f32, &decode);
                return if count == 1 { lookup(0) } else { (0..count).map(lookup).sum::<Vec4>() * scale };
            }
        }
        let lookup = |i: u32| self.combine(image, first + step * i as f32, |i| decode(&texels[i]));
        if count == 1 { lookup(0) } else { (0..count).map(lookup).sum::<Vec4>() * scale }
    }

    /// The texels about `uv`, as the filter says.
    #[inline(always)]
    fn combine(&self, image: &ImageData, uv: Vec2, texel: impl Fn(usize) -> Vec4) -> Vec4 {
        let (x, y) = (uv.x * image.width as f32, uv.y * image.height as f32);
        let column = |i: i32| wrap(self.wrap_s, i, image.width);
        let row = |j: i32| wrap(self.wrap_t, j, image.height) * image.width as usize;
        match self.filter {
            Filter::Nearest => texel(row(floor(y)) + column(floor(x))),
            Filter::Bilinear => {
                let (x, y) = (x - 0.5, y - 0.5);
                let (i, j) = (floor(x), floor(y));
                let (fx, fy) = (fraction(x, i), fraction(y, j));
                let (left, right) = (column(i), column(i + 1));
                let (above, below) = (row(j), row(j + 1));
                let top = texel(above + left).lerp(texel(above + right), fx);
                let bottom = texel(below + left).lerp(texel(below + right), fx);
                top.lerp(bottom, fy)
            }
        }
    }
}

/// The four texels about a position in an image's inside, in texels from the centre of the first one.
#[inline(always)]
fn inside<T>(texels: &[T], width: usize, at: Vec2, decode: impl Fn(&T) -> Vec4) -> Vec4 {
    let (i, j) = (at.x as u32, at.y as u32);
    let (fx, fy) = (at.x - i as f32, at.y - j as f32);
    let above = &texels[j as usize * width + i as usize..];
    let below = &above[width..];
    let top = decode(&above[0]).lerp(decode(&above[1]), fx);
    top.lerp(decode(&below[0]).lerp(decode(&below[1]), fx), fy)
}

/// How stored texels become linear values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColorEncoding {
    /// RGB through the sRGB curve (8-bit only), alpha linear.
    Srgb,
    /// As stored.
    Linear,
}

impl ColorEncoding {
    pub(crate) fn texel(self, texels: &Texels, index: usize) -> Vec4 {
        match texels {
            Texels::Rgba32F(t) => Vec4::from_array(t[index]),
            Texels::Rgba8(t) => match self {
                Self::Linear => linear_from_bytes(t[index]),
                Self::Srgb => linear_from_srgb_bytes(srgb_table(), t[index]),
            },
        }
    }
}

/// Each byte over 255: divisions are slow.
static UNIT: [f32; 256] = {
    let mut unit = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        unit[i] = i as f32 / 255.0;
        i += 1;
    }
    unit
};

#[inline]
fn linear_from_bytes([r, g, b, a]: [u8; 4]) -> Vec4 {
    Vec4::new(UNIT[r as usize], UNIT[g as usize], UNIT[b as usize], UNIT[a as usize])
}

#[inline]
fn linear_from_srgb_bytes(table: &[f32; 256], [r, g, b, a]: [u8; 4]) -> Vec4 {
    Vec4::new(table[r as usize], table[g as usize], table[b as usize], UNIT[a as usize])
}

/// Linear value of an sRGB byte.
pub(super) fn linear_from_byte(byte: u8) -> f32 {
    srgb_table()[byte as usize]
}

/// Linear value of each sRGB byte (IEC 61966-2-1).
fn srgb_table() -> &'static [f32; 256] {
    static TABLE: std::sync::OnceLock<[f32; 256]> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| {
        std::array::from_fn(|i| {
            let c = i as f32 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
        })
    })
}

/// Floor as an integer; coordinates beyond ±2³⁰ (and NaN) count as 0, so that an absurd uv stays in range.
#[inline]
fn floor(x: f32) -> i32 {
    if x.abs() < (1 << 30) as f32 {
        let towards_zero = x as i32;
        towards_zero - i32::from(x < towards_zero as f32)
    } else {
        0
    }
}

/// What is left of a coordinate above its floor, in [0, 1]: nothing where `floor` counts it as 0.
#[inline]
fn fraction(x: f32, floor: i32) -> f32 {
    let rest = x - floor as f32;
    if (0.0..=1.0).contains(&rest) { rest } else { 0.0 }
}

/// Returns the coordinate in the first period of the wrap mode, or itself if the mode has none.
pub(crate) fn wrap_to_period(mode: Wrap, u: f32) -> f32 {
    match mode {
        Wrap::Repeat => u - u.floor(),
        Wrap::MirroredRepeat => u - 2.0 * (0.5 * u).floor(),
        Wrap::ClampToEdge => u,
    }
}

/// The texel index in 0..n that `mode` gives index `i`.
#[inline]
fn wrap(mode: Wrap, i: i32, n: u32) -> usize {
    // Most are inside, and divisions are slow.
    if (i as u32) < n {
        return i as usize;
    }
    let (i, n) = (i64::from(i), i64::from(n));
    let j = match mode {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::ClampToEdge => i.clamp(0, n - 1),
        Wrap::MirroredRepeat => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
    };
    j as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(texels: &[[u8; 4]], width: u32) -> ImageData {
        ImageData {
            name: String::new(),
            width,
            height: texels.len() as u32 / width,
            texels: Texels::Rgba8(texels.into()),
        }
    }

    #[test]
    fn bilinear_passes_through_texel_centres_and_wraps() {
        let image = image(&[[0, 0, 0, 255], [255, 255, 255, 255]], 2);
        let texture = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Bilinear };
        let at = |u: f32| texture.sample(&image, Vec2::new(u, 0.5), ColorEncoding::Linear).x;
        assert_eq!((at(0.25), at(0.75), at(0.5)), (0.0, 1.0, 0.5));
        assert_eq!((at(0.0), at(1.25)), (0.5, 0.0));
        let clamped = Texture { wrap_s: Wrap::ClampToEdge, ..texture };
        assert_eq!(clamped.sample(&image, Vec2::new(-3.0, 0.5), ColorEncoding::Linear).x, 0.0);
    }

    /// IEC 61966-2-1: sRGB 188 is linear 0.5029.
    #[test]
    fn srgb_is_decoded_before_filtering() {
        assert!((srgb_table()[188] - 0.502_886).abs() < 1e-5);
        let image = image(&[[0, 0, 0, 128], [255, 255, 255, 128]], 2);
        let texture = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Bilinear };
        let c = texture.sample(&image, Vec2::new(0.5, 0.5), ColorEncoding::Srgb);
        assert!((c.x - 0.5).abs() < 1e-6 && (c.w - 128.0 / 255.0).abs() < 1e-6);
    }

    /// Coordinates without a place in the image, and without a number.
    #[test]
    fn absurd_coordinates_give_a_texel() {
        let image = image(&[[0, 0, 0, 255], [255, 255, 255, 255]], 2);
        for wrap in [Wrap::Repeat, Wrap::ClampToEdge, Wrap::MirroredRepeat] {
            for filter in [Filter::Bilinear, Filter::Nearest] {
                let texture = Texture { image: 0, wrap_s: wrap, wrap_t: wrap, filter };
                for u in [1e8, -1e8, 1e12, -1e30, f32::MAX, f32::INFINITY, f32::NAN] {
                    let texel = texture.sample(&image, Vec2::new(u, -u), ColorEncoding::Linear);
                    assert!((0.0..=1.0).contains(&texel.x) && texel.w == 1.0, "{wrap:?} {filter:?} {u}: {texel}");
                }
            }
        }
    }

    #[test]
    fn wrap_modes() {
        let all = |mode| (-3..5).map(|i| wrap(mode, i, 2)).collect::<Vec<_>>();
        assert_eq!(all(Wrap::Repeat), [1, 0, 1, 0, 1, 0, 1, 0]);
        assert_eq!(all(Wrap::MirroredRepeat), [1, 1, 0, 0, 1, 1, 0, 0]);
        assert_eq!(all(Wrap::ClampToEdge), [0, 0, 0, 0, 1, 1, 1, 1]);
    }

    /// KHR_texture_transform's example: a quarter turn maps +u to −v in the image's y-down frame.
    #[test]
    fn uv_transform_scales_then_rotates_then_translates() {
        let t = UvTransform::new(Vec2::new(0.5, 0.25), std::f32::consts::FRAC_PI_2, Vec2::new(2.0, 3.0));
        let p = t.apply(Vec2::new(1.0, 0.0));
        assert!((p - Vec2::new(0.5, 0.25 - 2.0)).length() < 1e-6, "{p}");
    }
}
