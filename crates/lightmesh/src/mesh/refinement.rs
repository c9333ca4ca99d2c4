//! One level of a mesh: a lattice, which of its points are known, and where the next level takes over.
//!
//! Level l has half the spacing of level l − 1. A point that is *refined* gives up its part of the interpolation: with trilinear
//! weights w_k over the corners k of a cell,
//!
//! > E(y) = Σ_{k not refined} w_k E_k + (Σ_{k refined} w_k) E'(y),
//!
//! where E' is what the next level says at y, by the same rule. Weights are continuous and go to 0 where a corner leaves the cell, so
//! there is no seam where levels meet, nothing hangs, and no point of either level must be constrained: a cell whose
//! corners are all refined is the finer level's alone, and a ring of cells around it blends. A refined point needs no value.
//!
//! Points are refined one by one, where a picture's light needs it, and in a ball about the eye, where its density is to be higher.

use std::collections::HashMap;

use glam::Vec3;

use super::bricks::{Bricks, Slot};
use super::corners::corner;
use super::lattice::{self, Coordinate, Lattice};

/// A lattice and what is known of its points.
#[derive(Debug)]
pub(crate) struct RefinementLevel {
    pub(crate) lattice: Lattice,
    pub(crate) bricks: Bricks,
    /// By brick, a bit per refined point.
    refined: HashMap<usize, [u64; 8]>,
    /// All points in this ball are refined, too.
    ball: Option<Ball>,
}

/// Where a mesh is dense because the eye is near.
#[derive(Clone, Copy, Debug)]
struct Ball {
    eye: Vec3,
    /// Metres.
    radius: f32,
}

impl RefinementLevel {
    pub(crate) fn new(lattice: Lattice) -> Self {
        let bricks = Bricks::new(lattice.bricks());
        Self { lattice, bricks, refined: HashMap::new(), ball: None }
    }

    #[inline(always)]
    pub(crate) fn slot(&self, coordinate: Coordinate) -> Slot {
        let (brick, local) = lattice::split(coordinate);
        self.bricks.slot(self.lattice.brick_index(brick), local)
    }

    /// The slots of a cell's eight corners.
    #[inline(always)]
    pub(super) fn slots(&self, cell: Coordinate) -> [Slot; 8] {
        let (brick, local) = lattice::split(cell);
        if (cell & 7).max_element() < 7 {
            // All in one brick.
            let slots = self.bricks.brick(self.lattice.brick_index(brick));
            return std::array::from_fn(|k| slots.at(local + (k & 1) + (k >> 1 & 1) * 8 + (k >> 2) * 64));
        }
        std::array::from_fn(|k| self.slot(corner(cell, k)))
    }

    pub(super) fn set(&mut self, coordinate: Coordinate, slot: Slot) {
        let (brick, local) = lattice::split(coordinate);
        self.bricks.set(self.lattice.brick_index(brick), local, slot);
    }

    /// Refines all corners of a cell.
    pub(super) fn refine(&mut self, cell: Coordinate) {
        for k in 0..8 {
            let (brick, local) = lattice::split(corner(cell, k));
            self.refined.entry(self.lattice.brick_index(brick)).or_default()[local / 64] |= 1 << (local % 64);
        }
    }

    /// Refines all points nearer to `eye` than `radius`, metres.
    pub(super) fn refine_near(&mut self, eye: Vec3, radius: f32) {
        self.ball = Some(Ball { eye, radius });
    }

    /// Refines nothing any more.
    pub(super) fn reset_refinement(&mut self) {
        self.refined.clear();
        self.ball = None;
    }

    /// Which corners of a cell are refined, a bit each.
    #[inline(always)]
    pub(super) fn refined(&self, cell: Coordinate) -> u8 {
        if self.refined.is_empty() && self.ball.is_none() {
            return 0;
        }
        let is_refined = |k: usize| {
            let coordinate = corner(cell, k);
            let (brick, local) = lattice::split(coordinate);
            let is_near =
                |ball: Ball| self.lattice.point(coordinate).distance_squared(ball.eye) < ball.radius * ball.radius;
            self.ball.is_some_and(is_near)
                || self
                    .refined
                    .get(&self.lattice.brick_index(brick))
                    .is_some_and(|bits| bits[local / 64] >> (local % 64) & 1 != 0)
        };
        (0..8).map(|k| u8::from(is_refined(k)) << k).sum()
    }
}
