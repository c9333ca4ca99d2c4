//! The eight corners of a cell: corner k is the lower one plus bit 0 of k in x, bit 1 in y and bit 2 in z.

use glam::{IVec3, Vec4};

use super::lattice::Coordinate;
use crate::sampling;

/// A number per corner: four with the lower z, four with the upper.
pub(crate) type ByCorner = [Vec4; 2];

/// For each set of four corners, 1 for those in it: 1 for each bit that is set.
pub(crate) const ONES: [Vec4; 16] = {
    let mut ones = [Vec4::ZERO; 16];
    let mut i = 0;
    while i < 16 {
        ones[i] = Vec4::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32, (i >> 3 & 1) as f32);
        i += 1;
    }
    ones
};

/// Returns the corners of a mask, ascending.
#[inline(always)]
pub(crate) fn corners_of(mask: u8) -> impl Iterator<Item = usize> + Clone {
    sampling::set_bits::<8>(mask)
}

/// Returns the coordinate of corner k of a cell.
#[inline(always)]
pub(super) fn corner(cell: Coordinate, k: usize) -> Coordinate {
    cell + IVec3::new(k as i32 & 1, k as i32 >> 1 & 1, k as i32 >> 2)
}
