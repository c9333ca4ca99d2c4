//! The regular lattice: where mesh points are, and which brick holds them.
//!
//! Points lie at `origin + spacing · (i, j, k)`, i in 0..size.x and so on. A brick is a cube of 8³ points: point (i, j,
//! k) is in brick (⌊i / 8⌋, ⌊j / 8⌋, ⌊k / 8⌋) at index `(i mod 8) + 8 (j mod 8) + 64 (k mod 8)`. Bricks are told apart by
//! their coordinates, packed into one number (see [`BrickKey`]). Example: point (9, −2, 17) is in brick (1, −1, 2), at
//! index 1 + 8 · 6 + 64 · 1 = 113.

use glam::{DVec3, IVec3, UVec3, Vec3};

use crate::Error;
use crate::geometry::Aabb;

/// A lattice coordinate: every component less than 2²¹ from 0.
pub(crate) type Coordinate = IVec3;

/// The coordinates of a brick in one number: x + 2²⁰ in bits 0 to 20, y + 2²⁰ in the next 21, z + 2²⁰ above. Ascending
/// keys go along x first, then y, then z.
pub(crate) type BrickKey = u64;

/// What is added to a brick's coordinates in its key.
const BRICK_BIAS: i32 = 1 << 20;
const BRICK_BITS: u32 = 21;

/// A point closer to a surface than this part of the spacing lies on it: rays from it may start on either side. Walls
/// on lattice planes have such points, but for rounding: 2⁻²⁴ of the scene's extent is a sixteenth of this where 2¹⁰
/// cells lie along it.
pub(super) const ON_SURFACE: f32 = 1.0 / 1024.0;

/// Most cells along an axis: f32 positions then keep a hundredth of a cell (2⁻²⁴ · 2¹⁷ = 1/128).
const MAX_CELLS: f64 = (1 << 17) as f64;

/// A block of lattice points, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PointBlock {
    pub low: Coordinate,
    pub high: Coordinate,
}

/// The lattice of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    origin: Vec3,
    spacing: f32,
    inv_spacing: f32,
    /// Points inside the scene's box.
    inside: u64,
    size: UVec3,
    /// The lower corners of the first and the last cell.
    first: Vec3,
    last: Vec3,
}

impl Lattice {
    /// A lattice over `bounds`. Its points lie half a cell off the box's lower walls, so that a wall on them does not
    /// cut through points, and go on `reach` cells beyond on every side.
    ///
    /// `option` names the spacing in messages.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for too many points along an axis.
    pub(crate) fn new(option: &'static str, bounds: &Aabb, spacing: f32, reach: u32) -> Result<Self, Error> {
        // Count cells, in f64: they may be too many.
        let inside = (bounds.size().as_dvec3() / f64::from(spacing)).ceil().max(DVec3::ONE);
        let cells = inside + f64::from(2 * reach);
        let bricks = (cells / 8.0).ceil();
        if cells.max_element() > MAX_CELLS {
            let what = format!(
                "{spacing} m puts more than {MAX_CELLS} mesh points along the scene's longest edge, too many for memory \
                 and 32-bit positions; choose a larger one"
            );
            return Err(Error::InvalidOption { option, what });
        }

        // The first point inside the box is half a cell off its walls.
        Ok(Self {
            origin: bounds.min - (reach as f32 - 0.5) * spacing,
            spacing,
            inv_spacing: 1.0 / spacing,
            inside: inside.as_u64vec3().element_product(),
            size: (bricks * 8.0).as_uvec3(),
            first: Vec3::ZERO,
            last: (bricks * 8.0 - 2.0).as_vec3(),
        })
    }

    /// Returns the distance between neighbours, metres.
    pub(crate) fn spacing(&self) -> f32 {
        self.spacing
    }

    /// Returns 1 / spacing.
    pub(super) fn inv_spacing(&self) -> f32 {
        self.inv_spacing
    }

    /// Returns whether a brick holds points of the lattice.
    pub(super) fn contains_brick(&self, brick: BrickKey) -> bool {
        brick >> (3 * BRICK_BITS) == 0 && self.contains(coordinate(brick, 0))
    }

    /// Returns whether a point is one of the lattice's.
    pub(crate) fn contains(&self, coordinate: Coordinate) -> bool {
        let coordinate = coordinate.as_vec3();
        coordinate.cmpge(self.first).all() && coordinate.cmple(self.last + 1.0).all()
    }

    /// Returns the number of points inside the scene's box; the lattice goes on beyond it to whole bricks.
    pub(super) fn point_count(&self) -> u64 {
        self.inside
    }

    /// Returns a point's position, metres.
    pub(super) fn point(&self, coordinate: Coordinate) -> Vec3 {
        self.origin + coordinate.as_vec3() * self.spacing
    }

    /// Returns the lower corner of the cell that holds `p`, and the position of p in the cell, each component in [0,
    /// 1]; a point outside the lattice counts as the nearest one inside.
    #[inline(always)]
    pub(crate) fn cell(&self, p: Vec3) -> (Coordinate, Vec3) {
        let (cell, x) = self.cell_and_position(p);
        (cell, x.clamp(Vec3::ZERO, Vec3::ONE))
    }

    /// Returns the same cell, and the position of p from its lower corner, in spacings, also where that is outside the
    /// cell.
    #[inline(always)]
    pub(super) fn cell_and_position(&self, p: Vec3) -> (Coordinate, Vec3) {
        // Added to a number below 2²², this leaves the nearest integer in the low bits. Points on a lattice plane count
        // to the upper side, as do those less than 1e-4 below it.
        const ROUND: f32 = (3 << 22) as f32;
        const HALF: f32 = 0.5 - 1e-4;
        let x = (p - self.origin) * self.inv_spacing;
        let rounded = x.clamp(self.first, self.last) - HALF + ROUND;
        let cell = rounded.to_array().map(|c| c.to_bits().wrapping_sub(ROUND.to_bits()) as i32);
        (IVec3::from_array(cell), x - (rounded - ROUND))
    }

    /// Returns the block of lattice points between two positions, clamped to the lattice.
    pub(super) fn range(&self, min: Vec3, max: Vec3) -> PointBlock {
        let (first, last) = (self.first, self.last + 1.0);
        let low = ((min - self.origin) * self.inv_spacing).ceil().clamp(first, last);
        let high = ((max - self.origin) * self.inv_spacing).floor().clamp(first, last);
        PointBlock { low: low.as_ivec3(), high: high.as_ivec3() }
    }

    /// Returns the lattice as plain numbers.
    pub(crate) fn shape(&self) -> LatticeShape {
        LatticeShape { origin: self.origin.to_array(), spacing: self.spacing, size: self.size.to_array() }
    }

    /// Returns the block of lattice points in a box; `None` where there are none.
    pub(crate) fn points_in(&self, bounds: &Aabb) -> Option<PointBlock> {
        let low = ((bounds.min - self.origin) * self.inv_spacing).ceil().max(self.first);
        let high = ((bounds.max - self.origin) * self.inv_spacing).floor().min(self.last + 1.0);
        low.cmple(high).all().then(|| PointBlock { low: low.as_ivec3(), high: high.as_ivec3() })
    }
}

/// Returns the coordinate of a point of a brick.
pub(crate) fn coordinate(brick: BrickKey, local: usize) -> Coordinate {
    let part = |shift: u32| (brick >> shift & ((1 << BRICK_BITS) - 1)) as i32 - BRICK_BIAS;
    let local = local as i32;
    let brick = IVec3::new(part(0), part(BRICK_BITS), part(2 * BRICK_BITS));
    brick * 8 + IVec3::new(local % 8, local / 8 % 8, local / 64)
}

/// Returns the brick of a point and its index in it.
#[inline(always)]
pub(crate) fn split(coordinate: Coordinate) -> (BrickKey, usize) {
    let local = coordinate & 7;
    let part = |c: i32| ((c >> 3) + BRICK_BIAS) as u64;
    let key = part(coordinate.x) | part(coordinate.y) << BRICK_BITS | part(coordinate.z) << (2 * BRICK_BITS);
    (key, (local.x + 8 * local.y + 64 * local.z) as usize)
}

/// The lattice of one level of a mesh. Point (i, j, k) lies at `origin + spacing · (i, j, k)`, with i in 0..size\[0\]
/// and so on. Computed in f32 as written, component by component, this is the mesh's own position, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeShape {
    /// Point (0, 0, 0), metres.
    pub origin: [f32; 3],
    /// The distance between neighbours, metres.
    pub spacing: f32,
    /// The number of points along x, y and z.
    pub size: [u32; 3],
}

impl LatticeShape {
    /// Returns the position of a point, metres.
    pub fn position(&self, [i, j, k]: [i32; 3]) -> [f32; 3] {
        let [x, y, z] = self.origin;
        [x + self.spacing * i as f32, y + self.spacing * j as f32, z + self.spacing * k as f32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 2.0), max: Vec3::new(9.0, 4.0, 10.0) };
        Lattice::new("spacing", &bounds, 0.25, 1).expect("small")
    }

    /// The example of the module's documentation, and back; keys ascend along x, then y, then z.
    #[test]
    fn bricks_and_indices_follow_the_formula() {
        let (brick, local) = split(IVec3::new(9, -2, 17));
        assert_eq!((brick, local), (split(IVec3::new(8, -8, 16)).0, 113));
        assert_eq!(coordinate(brick, local), IVec3::new(9, -2, 17));
        let keys = [[-9, 0, 0], [0, 0, 0], [8, 0, 0], [-800, 8, 0], [0, -8, 8]].map(|c| split(c.into()).0);
        assert!(keys.is_sorted());
        for c in [IVec3::splat(-(1 << 20)), IVec3::splat((1 << 20) - 1)] {
            let (brick, local) = split(c);
            assert_eq!(coordinate(brick, local), c);
        }
    }

    /// 10 × 4 × 8 m at 0.25 m.
    #[test]
    fn the_box_holds_a_point_per_cell() {
        assert_eq!(lattice().point_count(), 40 * 16 * 32);
    }

    #[test]
    fn a_cell_holds_its_point() {
        let l = lattice();
        for p in [Vec3::new(0.1, 0.2, 3.3), Vec3::new(-1.0, 0.0, 2.0), Vec3::new(9.0, 4.0, 10.0)] {
            let (base, frac) = l.cell(p);
            assert!((l.point(base) + frac * 0.25 - p).length() < 1e-5);
        }
    }

    /// Points are at −1.125, −0.875 … along x.
    #[test]
    fn a_box_is_clipped_to_the_lattice() {
        let l = lattice();
        let thin = Aabb { min: Vec3::new(-0.9, -9.0, 2.1), max: Vec3::new(-0.8, 0.2, 2.4) };
        assert_eq!(l.points_in(&thin), Some(PointBlock { low: IVec3::new(1, 0, 1), high: IVec3::new(1, 1, 2) }));
        let between = Aabb { min: Vec3::new(-0.8, 0.0, 2.0), max: Vec3::new(-0.7, 4.0, 10.0) };
        assert_eq!(l.points_in(&between), None);
        let beyond = Aabb { min: Vec3::splat(20.0), max: Vec3::splat(30.0) };
        assert_eq!(l.points_in(&beyond), None);
        assert_eq!(l.points_in(&Aabb::EMPTY), None);
        let all = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
        assert_eq!(l.points_in(&all), Some(PointBlock { low: IVec3::ZERO, high: l.size.as_ivec3() - 1 }));
    }

    #[test]
    fn the_first_points_inside_stand_half_a_cell_off_the_walls() {
        let l = lattice();
        assert!((l.point(IVec3::ONE) - Vec3::new(-0.875, 0.125, 2.125)).length() < 1e-6);
    }

    #[test]
    fn an_absurd_spacing_is_refused_before_anything_is_allocated() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(10.0) };
        let error = Lattice::new("spacing", &bounds, 1e-9, 1).expect_err("too fine");
        assert!(error.to_string().contains("spacing"), "{error}");
        let wire = Aabb { min: Vec3::ZERO, max: Vec3::new(1e6, 1.0, 1.0) };
        let error = Lattice::new("spacing", &wire, 1.0, 1).expect_err("too long");
        assert!(error.to_string().contains("spacing"), "{error}");
    }
}
