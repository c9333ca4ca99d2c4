//! Cells of the sky: rectangles of a latitude-longitude map, small where much light comes from, and strata of them.

use std::f32::consts::{PI, TAU};
use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};

use super::luminance;
use super::strata::{Count, Item, stratify};

/// A cell is no longer than this, radian.
const LONGEST: f32 = 0.15;

/// A cell is not divided below this, radian.
const SHORTEST: f32 = 0.004;

/// Rows of the sums, at least.
const LEAST_ROWS: usize = 256;

/// The sky of a map, or an even one, in cells.
#[derive(Debug)]
pub(super) struct SkyCells {
    /// Stratum by stratum.
    cells: Vec<Cell>,
    /// Luminous flux per area of all cells up to and with each, lux.
    cdf: Vec<f64>,
    strata: Vec<Range<u32>>,
}

/// A rectangle of the map.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// u and v in [0, 1].
    min: Vec2,
    max: Vec2,
    /// Radiance times solid angle, per channel: lux on a surface that faces it.
    flux: Vec3,
}

impl Cell {
    /// Returns the direction of its middle.
    fn middle(&self) -> Vec3 {
        direction_of(0.5 * (self.min + self.max))
    }

    fn solid_angle(&self) -> f32 {
        TAU * (self.max.x - self.min.x) * (libm::cosf(PI * self.min.y) - libm::cosf(PI * self.max.y))
    }
}

/// A representative of a stratum of the sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyPatch {
    /// Unit, towards it.
    pub direction: Vec3,
    /// Per channel, lux on a surface that faces it.
    pub illuminance: Vec3,
    /// How far the stratum's directions are from it.
    pub radius: f32,
}

/// A random direction of a stratum of the sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyPoint {
    /// Unit, towards it.
    pub direction: Vec3,
    /// Solid angle over probability, steradian.
    pub solid_angle: f32,
}

impl SkyCells {
    /// Divides a map whose cells, row by row, have these mean radiances, into at most `count` strata.
    pub(super) fn new(radiances: &[Vec3], width: usize, count: u32) -> (Self, Vec<SkyPatch>) {
        // Divide the map into cells.
        let sums = Sums::new(radiances, width);
        let most = f64::from(luminance(sums.flux(Vec2::ZERO, Vec2::ONE).as_vec3())) / f64::from(4 * count);
        let mut cells = Vec::new();
        sums.divide(Vec2::ZERO, Vec2::ONE, most, &mut cells);
        // Gather them into strata.
        let weight = |i: usize| luminance(cells[i].flux);
        let item = |i: usize| Item::of_sky(cells[i].middle(), weight(i), i as u32);
        let mut items: Vec<Item> = (0..cells.len()).filter(|&i| weight(i) > 0.0).map(item).collect();
        let runs = stratify(&mut items, Count { wanted: count, most: count, facing: 0.0 });
        let patch = |run: &Range<u32>| {
            let (mut direction, mut illuminance) = (Vec3::ZERO, Vec3::ZERO);
            for item in &items[run.start as usize..run.end as usize] {
                direction += Vec3::from_slice(&item.at[..3]) * item.weight;
                illuminance += cells[item.index as usize].flux;
            }
            let direction = direction.normalize_or(Vec3::Y);
            let corner = |item: &Item| direction_of(cells[item.index as usize].min).distance(direction);
            let radius = items[run.start as usize..run.end as usize].iter().map(corner).fold(0.0, f32::max);
            // Corners are about as far from the middle of a cell as each other.
            SkyPatch { direction, illuminance, radius: 1.5 * radius + 1e-3 }
        };
        let patches = runs.iter().map(patch).collect();
        // Sum their flux.
        let cells: Vec<Cell> = items.iter().map(|item| cells[item.index as usize]).collect();
        let mut sum = 0.0;
        let mut add = |cell: &Cell| {
            sum += f64::from(luminance(cell.flux));
            sum
        };
        let cdf = cells.iter().map(&mut add).collect();
        (Self { cells, cdf, strata: runs }, patches)
    }

    /// Returns a random direction of a stratum by u in [0, 1)².
    pub(super) fn sample(&self, stratum: u32, u: Vec2) -> SkyPoint {
        let Range { start, end } = self.strata[stratum as usize];
        let before = |i: u32| if i > 0 { self.cdf[i as usize - 1] } else { 0.0 };
        let (first, whole) = (before(start), before(end) - before(start));
        let target = first + whole * f64::from(u.x);
        let i = start + self.cdf[start as usize..end as usize].partition_point(|&c| c <= target) as u32;
        let i = i.min(end - 1);
        let share = self.cdf[i as usize] - before(i);
        let inside = (((target - before(i)) / share) as f32).clamp(0.0, 1.0);
        // Evenly over the cell's solid angle: in longitude and in height.
        let cell = &self.cells[i as usize];
        let (top, bottom) = (libm::cosf(PI * cell.min.y), libm::cosf(PI * cell.max.y));
        let height = top + (bottom - top) * u.y;
        let phi = TAU * (cell.min.x + (cell.max.x - cell.min.x) * inside);
        let r = (1.0 - height * height).max(0.0).sqrt();
        let direction = Vec3::new(-libm::cosf(phi) * r, height, -libm::sinf(phi) * r);
        SkyPoint { direction, solid_angle: (f64::from(cell.solid_angle()) * whole / share) as f32 }
    }
}

/// Radiance times solid angle, summed over the map from its upper left corner.
struct Sums {
    width: usize,
    height: usize,
    /// At the corners of the cells, one row and column more than these.
    sums: Vec<DVec3>,
}

impl Sums {
    fn new(radiances: &[Vec3], width: usize) -> Self {
        // Rows are divided: in them light is spread evenly, which it is not over a high one.
        let rows = radiances.len() / width;
        let parts = LEAST_ROWS.div_ceil(rows);
        let height = rows * parts;
        let mut sums = vec![DVec3::ZERO; (width + 1) * (height + 1)];
        for y in 0..height {
            let edge = |y: usize| f64::from(libm::cosf(PI * y as f32 / height as f32));
            let solid_angle = f64::from(TAU) / width as f64 * (edge(y) - edge(y + 1));
            let mut row = DVec3::ZERO;
            for x in 0..width {
                row += radiances[y / parts * width + x].as_dvec3() * solid_angle;
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        Self { width, height, sums }
    }

    /// Returns the sum up to (u, v): what cells have is spread evenly over them.
    fn at(&self, uv: Vec2) -> DVec3 {
        let place = |x: f32, n: usize| {
            let x = f64::from(x) * n as f64;
            let i = (x as usize).min(n - 1);
            (i, (x - i as f64).clamp(0.0, 1.0))
        };
        let ((x, fx), (y, fy)) = (place(uv.x, self.width), place(uv.y, self.height));
        let corner = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        let above = corner(x, y).lerp(corner(x + 1, y), fx);
        above.lerp(corner(x, y + 1).lerp(corner(x + 1, y + 1), fx), fy)
    }

    fn flux(&self, min: Vec2, max: Vec2) -> DVec3 {
        let corner = |x: f32, y: f32| self.at(Vec2::new(x, y));
        (corner(max.x, max.y) - corner(min.x, max.y) - corner(max.x, min.y) + corner(min.x, min.y)).max(DVec3::ZERO)
    }

    /// Adds the parts of a rectangle that have at most `most` of the luminous flux.
    fn divide(&self, min: Vec2, max: Vec2, most: f64, cells: &mut Vec<Cell>) {
        let middle = 0.5 * (min + max);
        let size = Vec2::new((max.x - min.x) * TAU * libm::sinf(PI * middle.y), (max.y - min.y) * PI);
        let flux = self.flux(min, max).as_vec3();
        let longest = size.max_element();
        let much = f64::from(luminance(flux)) > most && longest > SHORTEST;
        if flux == Vec3::ZERO || !(much || longest > LONGEST) {
            cells.push(Cell { min, max, flux });
        } else if size.x >= size.y {
            self.divide(min, Vec2::new(middle.x, max.y), most, cells);
            self.divide(Vec2::new(middle.x, min.y), max, most, cells);
        } else {
            self.divide(min, Vec2::new(max.x, middle.y), most, cells);
            self.divide(Vec2::new(min.x, middle.y), max, most, cells);
        }
    }
}

/// Returns the map's direction at (u, v): see [`Environment::map`](crate::scene::Environment::map).
pub(super) fn direction_of(uv: Vec2) -> Vec3 {
    let (phi, theta) = (TAU * uv.x, PI * uv.y);
    let sin = libm::sinf(theta);
    Vec3::new(-libm::cosf(phi) * sin, libm::cosf(theta), -libm::sinf(phi) * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{hash, unit_f32};

    /// An even sky: strata of equal flux, each within a narrow cone about its patch.
    #[test]
    fn strata_of_an_even_sky_are_compact() {
        let (cells, patches) = SkyCells::new(&[Vec3::ONE; 64 * 32], 64, 64);
        assert_eq!(patches.len(), 64);
        for (i, patch) in patches.iter().enumerate() {
            assert!((patch.illuminance.x / (4.0 * PI / 64.0) - 1.0).abs() < 0.3, "{}", patch.illuminance);
            for k in 0..50 {
                let unit = |j: u32| unit_f32(hash(100 * i as u32 + 2 * k + j));
                let point = cells.sample(i as u32, Vec2::new(unit(0), unit(1)));
                assert!((point.solid_angle / patch.illuminance.x - 1.0).abs() < 0.01);
                assert!(point.direction.dot(patch.direction) > 0.86, "{}", point.direction.dot(patch.direction));
            }
        }
    }

    /// A sun of one cell with nearly all of the light gets most strata, all of them in it.
    #[test]
    fn a_small_sun_is_divided() {
        let mut map = vec![Vec3::splat(0.01); 64 * 32];
        map[10 * 64 + 20] = Vec3::splat(1e4);
        let (_, patches) = SkyCells::new(&map, 64, 64);
        let sun = direction_of(Vec2::new(20.5 / 64.0, 10.5 / 32.0));
        assert!(patches.iter().filter(|patch| patch.direction.dot(sun) > 0.995).count() > 32);
    }
}
