//! Regular subdivision of triangles, each into four, and finding the part that has a point.
//!
//! A *cell* is a part of a triangle after some steps: child 0, 1, 2 is at that corner, child 3 in the middle. Its number
//! is its first place on the curve through all cells of the last level, [`LEVELS`] base-4 digits, then four bits with
//! its level; cells that fill a triangle are sorted by it.

use glam::Vec3;

/// The last level: a thousandth of the triangle's edges.
pub(super) const LEVELS: u32 = 10;

/// The cell of the whole triangle.
pub(super) const WHOLE: u32 = 0;

/// Returns how often a cell has been divided.
pub(super) fn level(cell: u32) -> u32 {
    cell & 15
}

/// Returns a cell's k-th child; its level must be below [`LEVELS`].
pub(super) fn child(cell: u32, k: u32) -> u32 {
    let level = level(cell);
    (cell + 1) + (k << (4 + 2 * (LEVELS - 1 - level)))
}

/// Returns the barycentric coordinates of a cell's corners.
pub(super) fn corners(cell: u32) -> [Vec3; 3] {
    let mut corners = [Vec3::X, Vec3::Y, Vec3::Z];
    for l in 0..level(cell) {
        corners = child_corners(corners, cell >> (4 + 2 * (LEVELS - 1 - l)) & 3);
    }
    corners
}

/// Returns the corners of the k-th child of a triangle.
pub(super) fn child_corners([a, b, c]: [Vec3; 3], k: u32) -> [Vec3; 3] {
    let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
    match k {
        0 => [a, ab, ca],
        1 => [ab, b, bc],
        2 => [ca, bc, c],
        _ => [bc, ca, ab],
    }
}

/// Returns which of the sorted cells, which fill the triangle, has a point.
pub(super) fn find(cells: &[u32], point: Vec3) -> usize {
    if cells.len() < 2 {
        return 0;
    }
    let (mut place, mut w) = (0, point);
    for _ in 0..LEVELS {
        let k = if w.x >= 0.5 {
            w = 2.0 * w - Vec3::X;
            0
        } else if w.y >= 0.5 {
            w = 2.0 * w - Vec3::Y;
            1
        } else if w.z >= 0.5 {
            w = 2.0 * w - Vec3::Z;
            2
        } else {
            w = 1.0 - 2.0 * w;
            3
        };
        place = place << 2 | k;
    }
    cells.partition_point(|&cell| cell >> 4 <= place).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The middle of each cell is found in it, after uneven subdivision.
    #[test]
    fn cells_are_found_by_their_points() {
        let mut cells = vec![WHOLE];
        for i in 0..60 {
            let cell = cells.remove(i * 7 % cells.len());
            if level(cell) < LEVELS {
                cells.extend((0..4).map(|k| child(cell, k)));
            } else {
                cells.push(cell);
            }
        }
        cells.sort_unstable();
        let mut area = 0.0;
        for (i, &cell) in cells.iter().enumerate() {
            let [a, b, c] = corners(cell);
            assert_eq!(find(&cells, (a + b + c) / 3.0), i);
            area += (b - a).cross(c - a).length();
        }
        let whole = (Vec3::Y - Vec3::X).cross(Vec3::Z - Vec3::X).length();
        assert!((area / whole - 1.0).abs() < 1e-4);
    }
}
