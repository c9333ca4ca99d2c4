//! The least and the most that a picture of emission has in a rectangle: a pyramid, so that asking takes few steps.

use glam::Vec2;

use super::luminance;
use crate::scene::{ColorEncoding, Filter, ImageData, Texture, Wrap};

/// Cells along an axis that a question reads, at most.
const READ: usize = 4;

/// The least and the most luminance of an image, in cells of 2, 4, 8 … texels.
#[derive(Debug)]
pub(super) struct EmissionBounds {
    size: [usize; 2],
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    size: [usize; 2],
    cells: Vec<[f32; 2]>,
}

impl EmissionBounds {
    /// Reads an image.
    pub(super) fn new(image: &ImageData) -> Self {
        let size = [image.width as usize, image.height as usize];
        let texel = |x: usize, y: usize| {
            let l = luminance(ColorEncoding::Srgb.texel(&image.texels, y * size[0] + x).truncate());
            [l, l]
        };
        let mut levels = vec![Level::halved(size, texel)];
        while let Some(last) = levels.last()
            && last.cells.len() > 1
        {
            let next = Level::halved(last.size, |x, y| last.cells[y * last.size[0] + x]);
            levels.push(next);
        }
        Self { size, levels }
    }

    /// Returns the least and the most luminance of lookups in a rectangle of texture coordinates.
    pub(super) fn within(&self, texture: &Texture, min: Vec2, max: Vec2) -> [f32; 2] {
        let columns = texels(texture.wrap_s, texture.filter, min.x, max.x, self.size[0]);
        let rows = texels(texture.wrap_t, texture.filter, min.y, max.y, self.size[1]);
        let mut found = [f32::INFINITY, 0.0];
        for &[x0, x1] in &columns {
            for &[y0, y1] in &rows {
                // Choose the level on which the rectangle is a few cells.
                let fits = |l: usize, a: usize, b: usize| (b >> (l + 1)) - (a >> (l + 1)) < READ;
                let last = self.levels.len() - 1;
                let l = (0..last).find(|&l| fits(l, x0, x1) && fits(l, y0, y1)).unwrap_or(last);
                let level = &self.levels[l];
                for y in y0 >> (l + 1)..=(y1 >> (l + 1)).min(level.size[1] - 1) {
                    for x in x0 >> (l + 1)..=(x1 >> (l + 1)).min(level.size[0] - 1) {
                        found = joined(found, level.cells[y * level.size[0] + x]);
                    }
                }
            }
        }
        found
    }
}

impl Level {
    /// Joins cells two by two.
    fn halved(size: [usize; 2], cell: impl Fn(usize, usize) -> [f32; 2]) -> Self {
        let half = size.map(|n| n.div_ceil(2));
        let mut cells = Vec::with_capacity(half[0] * half[1]);
        for y in 0..half[1] {
            for x in 0..half[0] {
                let mut found = [f32::INFINITY, 0.0];
                for j in 2 * y..(2 * y + 2).min(size[1]) {
                    for i in 2 * x..(2 * x + 2).min(size[0]) {
                        found = joined(found, cell(i, j));
                    }
                }
                cells.push(found);
            }
        }
        Self { size: half, cells }
    }
}

fn joined(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Returns the texels, first and last, that lookups from `min` to `max` read: two runs where they wrap around.
fn texels(wrap: Wrap, filter: Filter, min: f32, max: f32, n: usize) -> Vec<[usize; 2]> {
    let all = vec![[0, n - 1]];
    // A little more than exact arithmetic would have.
    let reach = if filter == Filter::Bilinear { 0.501 } else { 0.001 };
    let (a, b) = ((f64::from(min) * n as f64 - reach).floor(), (f64::from(max) * n as f64 + reach).floor());
    if a.is_nan() || b.is_nan() || a.abs().max(b.abs()) > 1e9 {
        return all;
    }
    let (a, b, count) = (a as i64, b as i64, n as i64);
    let clamped = |i: i64| i.clamp(0, count - 1) as usize;
    match wrap {
        _ if a >= 0 && b < count => vec![[a as usize, b as usize]],
        Wrap::ClampToEdge => vec![[clamped(a), clamped(b)]],
        Wrap::Repeat if b - a + 1 < count => {
            let first = a.rem_euclid(count);
            let last = first + (b - a);
            if last < count {
                vec![[first as usize, last as usize]]
            } else {
                vec![[first as usize, n - 1], [0, (last - count) as usize]]
            }
        }
        Wrap::Repeat | Wrap::MirroredRepeat => all,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Texels;

    /// Against lookups in many rectangles, with each way to wrap and to filter.
    #[test]
    fn lookups_are_within_the_bounds() {
        let texels: Vec<[f32; 4]> = (0..13 * 9).map(|i| [((i * 37) % 101) as f32, 0.0, 0.0, 1.0]).collect();
        let image = ImageData { name: String::new(), width: 13, height: 9, texels: Texels::Rgba32F(texels.into()) };
        let bounds = EmissionBounds::new(&image);
        let unit = |i: u32| crate::sampling::unit_f32(crate::sampling::hash(i));
        for i in 0..600 {
            let wrap = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge][i as usize % 3];
            let filter = if i % 2 == 0 { Filter::Nearest } else { Filter::Bilinear };
            let texture = Texture { image: 0, wrap_s: wrap, wrap_t: wrap, filter };
            let min = Vec2::new(unit(4 * i) * 3.0 - 1.0, unit(4 * i + 1) * 3.0 - 1.0);
            let size = Vec2::new(unit(4 * i + 2), unit(4 * i + 3)).powf(3.0);
            let [least, most] = bounds.within(&texture, min, min + size);
            for k in 0..40 {
                let at = min + size * Vec2::new(unit(9000 + 2 * k), unit(9001 + 2 * k));
                let l = luminance(texture.sample(&image, at, ColorEncoding::Srgb).truncate());
                assert!(l >= least - 1e-3 && l <= most + 1e-3, "{wrap:?} {filter:?} {min} {size}: {l} {least} {most}");
            }
        }
        let texture = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Nearest };
        let one = |x: f32, y: f32| Vec2::new(x / 13.0, y / 9.0);
        let [least, most] = bounds.within(&texture, one(4.2, 4.2), one(5.7, 5.7));
        assert!(least < most && most < 25.0);
    }
}
