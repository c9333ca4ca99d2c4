//! What a mesh point sees of its neighbourhood: how far the next surface is along each axis, up to its neighbours.
//!
//! Six numbers per point, found by six short rays, tell readers which corners of a cell see each other and whether something
//! stands between a corner and the surface that reads it: nothing leaks through a wall, and no pixel pays a ray for that
//! unless its own cell is divided.

use glam::{Vec3, Vec4};

use super::neighbourhood::ByCorner;

/// Distances to the next solid surface along +x, −x, +y, −y, +z, −z, in 1/255 of the spacing, rounded down; 255: none
/// before the neighbour. The seventh byte has a bit per side that is set where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(align(8))]
pub(super) struct Clearance([u8; 8]);

impl Clearance {
    const FREE: u8 = 255;
    const FREE_SIDES: usize = 6;

    /// Nothing near on any side.
    pub(super) const ALL_FREE: Self = Self([255, 255, 255, 255, 255, 255, 0b11_1111, 0]);

    /// From the parts of the spacing (in (0, 1)) at which a surface is met, by side; `None`: nothing is.
    pub(super) fn new(met: [Option<f32>; 6]) -> Self {
        let mut bytes = [0; 8];
        for (side, t) in met.into_iter().enumerate() {
            bytes[side] = t.map_or(Self::FREE, |t| ((t * 255.0) as u8).min(254));
            bytes[Self::FREE_SIDES] |= u8::from(t.is_none()) << side;
        }
        Self(bytes)
    }
}

/// The clearances of a cell's corners towards one side, in 1/255 of the spacing.
#[inline(always)]
pub(super) fn room(corners: &[Clearance; 8], side: usize) -> ByCorner {
    [0, 4].map(|z| Vec4::from_array(std::array::from_fn(|k| f32::from(corners[z + k].0[side]))))
}

/// The corners that have surfaces near on four sides or more, as points have that are inside something thin: they say nothing
/// about what is around it.
pub(super) fn enclosed(corners: &[Clearance; 8]) -> u8 {
    let is_enclosed = |k: usize| corners[k].0[Clearance::FREE_SIDES].count_ones() <= 2;
    (0..8).map(|k| u8::from(is_enclosed(k)) << k).sum()
}

/// Which edges of a cell are free: for each axis a bit per corner at the lower end of its edge.
pub(super) type Links = [u8; 3];

/// The lower ends of the edges along x, y and z: corners without bit 0, 1 and 2 of their number.
const LOWER: Links = [0b0101_0101, 0b0011_0011, 0b0000_1111];

/// The free edges of a cell. Both ends must see each other: a wall may lie on one of them.
pub(super) fn links(corners: &[Clearance; 8]) -> Links {
    let rows = corners.map(|corner| corner.0[Clearance::FREE_SIDES]);
    // By side, a bit per corner.
    let free = transpose(u64::from_le_bytes(rows)).to_le_bytes();
    std::array::from_fn(|axis| free[2 * axis] & (free[2 * axis + 1] >> (1 << axis)) & LOWER[axis])
}

/// The transpose of a matrix of 8 × 8 bits, a row per byte (Warren, "Hacker's Delight", 2nd edition, section 7-3).
fn transpose(mut x: u64) -> u64 {
    for (shift, mask) in [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)] {
        let t = (x ^ (x >> shift)) & mask;
        x ^= t ^ (t << shift);
    }
    x
}

/// The corners of `mask` that can be reached from its lowest one along free edges between corners of `mask`. `mask` must
/// not be empty.
#[inline(always)]
pub(super) fn piece(links: &Links, mask: u8) -> u8 {
    let mut reached = mask & mask.wrapping_neg();
    loop {
        let mut next = reached;
        for (axis, &free) in links.iter().enumerate() {
            let step = 1 << axis;
            next |= (next & free) << step | (next >> step) & free;
            next &= mask;
        }
        if next == reached {
            return reached;
        }
        reached = next;
    }
}

/// How much nearer than the plane something must be to stand before it, in 1/255 of the spacing: a tenth of the spacing.
/// Roundings and surfaces that are not quite flat stay below it. Measured on Sponza with 25 lights: a fortieth calls for a quarter
/// more rays, nine in ten of which find nothing.
const SLACK: f32 = 25.0;

/// The side of a cell that looks most against a unit normal, and the cosine between them.
#[inline(always)]
pub(super) fn down(n: Vec3) -> (usize, f32) {
    let axis = n.abs().max_position();
    (2 * axis + usize::from(n[axis] > 0.0), n[axis].abs())
}

/// The corners of `mask` that have something between them and the plane through a reader: seen from the corner [`down`] the
/// reader's normal, at cosine `steep`, where they have so much `room`, another surface comes first. `heights` are the corners'
/// heights above the plane in spacings, along the normal.
#[inline(always)]
pub(super) fn parted_from_plane(room: &ByCorner, mask: u8, steep: f32, heights: &ByCorner) -> u8 {
    let scale = 255.0 / steep;
    let parted = [0, 1].map(|z| {
        let to_plane = heights[z] * scale;
        let nearer = (room[z] + SLACK).cmplt(to_plane);
        (to_plane.cmplt(Vec4::splat(255.0)) & nearer).bitmask() as u8
    });
    (parted[0] | parted[1] << 4) & mask
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposing_moves_bit_i_of_row_j_to_bit_j_of_row_i() {
        for (i, j) in [(0, 0), (7, 0), (3, 5), (6, 7)] {
            assert_eq!(transpose(1 << (8 * j + i)), 1 << (8 * i + j));
        }
    }

    /// A wall across x = 0.4 of the cell: the four corners on either side are linked, the two sides are not.
    #[test]
    fn a_wall_divides_a_cell() {
        let corners: [Clearance; 8] = std::array::from_fn(|k| {
            let mut met = [None; 6];
            if k & 1 == 0 {
                met[0] = Some(0.4)
            } else {
                met[1] = Some(0.6)
            }
            Clearance::new(met)
        });
        let links = links(&corners);
        assert_eq!(links, [0, 0b0011_0011, 0b0000_1111]);
        assert_eq!(piece(&links, 0b1111_1111), 0b0101_0101);
        assert_eq!(piece(&links, 0b1010_1010), 0b1010_1010);
        assert_eq!(piece(&links, 0b0000_1001), 0b0000_0001);
    }

    /// Corners 0.5 above a floor: the floor itself hides nothing, a shelf 0.2 above it does, a shelf above the corners not.
    #[test]
    fn a_shelf_hides_the_floor_below_it() {
        let below = |t, n| {
            let (side, steep) = down(n);
            let room = room(&[Clearance::new([None, None, Some(0.9), Some(t), None, None]); 8], side);
            parted_from_plane(&room, 0xf7, steep, &[Vec4::splat(0.5); 2])
        };
        assert_eq!(below(0.5, Vec3::Y), 0);
        assert_eq!(below(0.3, Vec3::Y), 0xf7);
        assert_eq!(below(0.3, Vec3::NEG_Y), 0);
    }
}
