//! The paper's trilinear interpolation, figs. 10-11: the cell that a surface point is in, and rules for the corners of
//! it that are missing because they are behind the surface or inside a solid.
//!
//! > Ĩ(y) = Σ_{k present} w_k Ĩ_k + Σ_{k missing} w_k m_k,
//!
//! w_k the trilinear weights, m_k the rule's value: 0, 1, or the Ĩ of a corner that is present. In the last case weight
//! moves from corner to corner; in the first two the sum of the weights is less than 1, and the reader adds the rest.

use glam::Vec3;

use super::bricks::Slot;
use super::corners::{corner, corners_of};
use super::lattice::{Coordinate, ON_SURFACE};
use super::read_result::ReadResult;
use super::refinement::RefinementLevel;
use super::stencil::{Stencil, stencil};
use crate::MissingCorners;
use crate::interaction::ShadingPoint;

/// The cell is looked up so far off the surface, in spacings: more than [`super::lattice::Lattice::cell`] rounds by, so
/// that a surface on a lattice plane has the cell before it, not the one behind.
const OFFSET: f32 = ON_SURFACE;

/// Visits (index, weight) of the corners of the vertex' cell that are present, with the weights that the rule moves to
/// them. If any is still empty it visits none and marks the empty ones.
pub(super) fn read_with(
    level: &RefinementLevel,
    rule: MissingCorners,
    vertex: &ShadingPoint,
    mut mark: impl FnMut(Coordinate),
    mut visit: impl FnMut(u32, f32),
) -> ReadResult {
    let stencil = stencil(&level.lattice, vertex, OFFSET);
    // Mark the empty corners before the surface; visit nothing if there are any.
    let (slots, before) = (level.slots(stencil.cell), before_plane(&stencil));
    let is = |k: &usize, condition: fn(Slot) -> bool| condition(slots[*k]);
    let mut empty = false;
    for k in corners_of(before).filter(|k| is(k, |slot| slot == Slot::Empty)) {
        mark(corner(stencil.cell, k));
        empty = true;
    }
    if empty {
        return ReadResult::Pending;
    }

    // Visit those that are not inside solids.
    let present = mask(corners_of(before).filter(|k| is(k, |slot| matches!(slot, Slot::Filled(_)))));
    if present == 0 {
        return ReadResult::Unavailable;
    }
    let weights = weights_by_rule(rule, &stencil, vertex, present);
    for k in corners_of(present) {
        if let Slot::Filled(index) = slots[k] {
            visit(index, weights[k]);
        }
    }
    ReadResult::Value
}

/// Returns the part of the trilinear weight that corners have which are present; all of them have been evaluated.
pub(super) fn usable_share(level: &RefinementLevel, vertex: &ShadingPoint) -> f32 {
    let stencil = stencil(&level.lattice, vertex, OFFSET);
    let slots = level.slots(stencil.cell);
    stencil.sum(mask(corners_of(before_plane(&stencil)).filter(|&k| matches!(slots[k], Slot::Filled(_)))))
}

/// Returns the corners before the vertex' plane. One that is less than [`ON_SURFACE`] off it lies on it.
fn before_plane(stencil: &Stencil) -> u8 {
    mask((0..8).filter(|&k| stencil.heights[k / 4][k % 4] > ON_SURFACE))
}

/// Returns the set of some corners.
fn mask(corners: impl Iterator<Item = usize>) -> u8 {
    corners.map(|k| 1 << k).sum()
}

/// Returns the weights of the corners that are `present`, with those that the rule moves to them.
fn weights_by_rule(rule: MissingCorners, stencil: &Stencil, vertex: &ShadingPoint, present: u8) -> [f32; 8] {
    let mut weights: [f32; 8] = std::array::from_fn(|k| stencil.weight(k));
    let across = match rule {
        MissingCorners::Zero | MissingCorners::One => return weights,
        MissingCorners::Nearest => None,
        MissingCorners::Mirror => Some(1 << longest_axis(vertex.ng)),
    };
    let nearest = nearest(stencil, present);
    // Move the weight of each missing corner.
    for k in corners_of(!present) {
        let to = across.map(|bit| k ^ bit).filter(|&k| present >> k & 1 != 0).unwrap_or(nearest);
        weights[to] += stencil.weight(k);
    }
    weights
}

/// Returns which of x, y, z is largest; the first of equals.
fn longest_axis(n: Vec3) -> usize {
    let n = n.abs();
    if n.x >= n.y && n.x >= n.z { 0 } else { 1 + usize::from(n.z > n.y) }
}

/// Returns which of some corners, at least one, is nearest to the position that the weights are of; the first of
/// equals.
fn nearest(stencil: &Stencil, corners: u8) -> usize {
    // Trilinear weights are products, and their sums over a face are the coordinates.
    let position = Vec3::new(stencil.sum(0b1010_1010), stencil.sum(0b1100_1100), stencil.sum(0b1111_0000));
    let distance = |k: &usize| {
        let corner = Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
        corner.distance_squared(position)
    };
    corners_of(corners).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("at least one")
}

#[cfg(test)]
mod tests {
    use super::super::lattice::Lattice;
    use super::*;
    use crate::geometry::Aabb;

    /// A vertex at (0.3, 0.4, 0.2) of a cell, of normal `ng`, and its stencil.
    fn at(ng: Vec3) -> (ShadingPoint, Stencil) {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(8.0) };
        let lattice = Lattice::new("spacing", &bounds, 1.0, 1).expect("small");
        let position = lattice.point(glam::IVec3::splat(3)) + Vec3::new(0.3, 0.4, 0.2);
        let vertex = ShadingPoint { position, n: ng, ng, offset: 1e-4, bulge: Vec3::ZERO, weight: Vec3::ONE, id: 0 };
        let stencil = stencil(&lattice, &vertex, OFFSET);
        (vertex, stencil)
    }

    /// A wall that faces +z: the four lower corners are behind it, with 0.8 of the weight together.
    #[test]
    fn missing_weight_moves_by_the_rule() {
        let (vertex, stencil) = at(Vec3::Z);
        let present = before_plane(&stencil);
        assert_eq!(present, 0b1111_0000);
        let sum = |rule| corners_of(present).map(|k| weights_by_rule(rule, &stencil, &vertex, present)[k]).sum::<f32>();
        assert!(
            (sum(MissingCorners::Zero) - 0.2).abs() < 2e-3 && sum(MissingCorners::Zero) == sum(MissingCorners::One)
        );
        assert!((sum(MissingCorners::Mirror) - 1.0).abs() < 1e-6 && (sum(MissingCorners::Nearest) - 1.0).abs() < 1e-6);
        let close = |a: f32, b: f32| (a - b).abs() < 2e-3;
        // Mirrored: bilinear in the upper face. Nearest: all of it to the corner at (0, 0, 1).
        let mirrored = weights_by_rule(MissingCorners::Mirror, &stencil, &vertex, present);
        for (k, w) in [(4, 0.7 * 0.6), (5, 0.3 * 0.6), (6, 0.7 * 0.4), (7, 0.3 * 0.4)] {
            assert!(close(mirrored[k], w), "{mirrored:?}");
        }
        let nearest = weights_by_rule(MissingCorners::Nearest, &stencil, &vertex, present);
        assert!(close(nearest[4], 0.8 + 0.2 * 0.42) && close(nearest[7], 0.2 * 0.12), "{nearest:?}");
        // One of the mirrored corners is missing, too: the nearest of those that are left gets the weight of both.
        let mirrored = weights_by_rule(MissingCorners::Mirror, &stencil, &vertex, 0b1110_0000);
        assert!(close(mirrored[6], 0.28 + 0.42) && close(mirrored[5], 0.18), "{mirrored:?}");
    }

    #[test]
    fn a_wall_on_a_lattice_plane_has_the_cell_before_it() {
        for ng in [Vec3::Z, Vec3::NEG_Z] {
            let (mut vertex, _) = at(ng);
            vertex.position.z -= 0.2;
            let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(8.0) };
            let lattice = Lattice::new("spacing", &bounds, 1.0, 1).expect("small");
            let stencil = stencil(&lattice, &vertex, OFFSET);
            assert_eq!(before_plane(&stencil), if ng.z > 0.0 { 0b1111_0000 } else { 0b0000_1111 });
        }
    }

    #[test]
    fn the_longest_axis_is_the_first_of_equals() {
        let axes = [(Vec3::new(-0.9, 0.3, 0.3), 0), (Vec3::new(0.1, -0.8, 0.6), 1), (Vec3::new(0.0, 0.6, -0.8), 2)];
        for (n, axis) in axes.into_iter().chain([(Vec3::ONE, 0), (Vec3::new(0.0, 1.0, 1.0), 1)]) {
            assert_eq!(longest_axis(n), axis, "{n}");
        }
    }
}
