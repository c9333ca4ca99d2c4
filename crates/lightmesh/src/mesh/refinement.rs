//! One level of a mesh: a lattice, the state of its points, and where the next level takes over.
//!
//! Level l has half the spacing of level l − 1. A point that is *refined* gives up its part of the interpolation: with
//! trilinear weights w_k over the corners k of a cell,
//!
//! > E(y) = Σ_{k not refined} w_k E_k + (Σ_{k refined} w_k) E'(y),
//!
//! where E' is the next level's value at y, by the same rule. Weights are continuous and go to 0 where a corner leaves
//! the cell, so there is no seam where levels meet, nothing hangs, and no point of either level must be constrained: a
//! cell whose corners are all refined is the finer level's alone, and a ring of cells around it blends. A refined point
//! needs no value.
//!
//! Points are refined one by one, where a picture's light needs it, and in a sphere about the eye, where the mesh is to
//! be denser.

use glam::Vec3;

use super::bricks::{Bricks, ByBrick, Slot};
use super::corners::corner;
use super::lattice::{self, BrickKey, Coordinate, Lattice};

/// A lattice and the state of its points.
#[derive(Debug)]
pub(crate) struct RefinementLevel {
    pub(crate) lattice: Lattice,
    pub(crate) bricks: Bricks,
    /// By brick, a bit per refined point.
    refined: ByBrick<BrickKey, [u64; 8]>,
    /// All points in this sphere are refined, too.
    near_eye: Option<EyeSphere>,
}

/// Where a mesh is dense because the eye is near.
#[derive(Clone, Copy, Debug)]
struct EyeSphere {
    eye: Vec3,
    /// Metres.
    radius: f32,
}

impl RefinementLevel {
    /// Empty points, none of them refined.
    pub(crate) fn new(lattice: Lattice) -> Self {
        Self { lattice, bricks: Bricks::default(), refined: ByBrick::default(), near_eye: None }
    }

    /// Returns the slot of a point.
    #[inline(always)]
    pub(crate) fn slot(&self, coordinate: Coordinate) -> Slot {
        let (brick, local) = lattice::split(coordinate);
        self.bricks.slot(brick, local)
    }

    /// Returns the slots of a cell's eight corners.
    #[inline(always)]
    pub(super) fn slots(&self, cell: Coordinate) -> [Slot; 8] {
        let (brick, local) = lattice::split(cell);
        if (cell & 7).max_element() < 7 {
            // All in one brick.
            let slots = self.bricks.brick(brick);
            return std::array::from_fn(|k| slots.slot(local + (k & 1) + (k >> 1 & 1) * 8 + (k >> 2) * 64));
        }
        std::array::from_fn(|k| self.slot(corner(cell, k)))
    }

    /// Sets the slot of a point.
    pub(super) fn set(&mut self, coordinate: Coordinate, slot: Slot) {
        let (brick, local) = lattice::split(coordinate);
        self.bricks.set(brick, local, slot);
    }

    /// Refines all corners of a cell.
    pub(super) fn refine(&mut self, cell: Coordinate) {
        for k in 0..8 {
            let (brick, local) = lattice::split(corner(cell, k));
            self.refined.entry(brick).or_default()[local / 64] |= 1 << (local % 64);
        }
    }

    /// Refines all points nearer to `eye` than `radius`, metres.
    pub(super) fn refine_near(&mut self, eye: Vec3, radius: f32) {
        self.near_eye = Some(EyeSphere { eye, radius });
    }

    /// Takes all refinement back.
    pub(super) fn reset_refinement(&mut self) {
        self.refined.clear();
        self.near_eye = None;
    }

    /// Returns which corners of a cell are refined, a bit each.
    #[inline(always)]
    pub(super) fn refined(&self, cell: Coordinate) -> u8 {
        if self.refined.is_empty() && self.near_eye.is_none() {
            return 0;
        }
        // A corner is refined near the eye, or by itself.
        let is_refined = |k: usize| {
            let coordinate = corner(cell, k);
            let (brick, local) = lattice::split(coordinate);
            let is_near =
                |EyeSphere { eye, radius }| self.lattice.point(coordinate).distance_squared(eye) < radius * radius;
            self.near_eye.is_some_and(is_near)
                || self.refined.get(&brick).is_some_and(|bits| bits[local / 64] >> (local % 64) & 1 != 0)
        };
        (0..8).map(|k| u8::from(is_refined(k)) << k).sum()
    }
}
