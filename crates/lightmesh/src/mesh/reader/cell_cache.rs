//! What a reader keeps of the cell that it read last: neighbouring surface points mostly share it.

use glam::{IVec3, Vec3, Vec4};

use super::super::bricks::Slot;
use super::super::clearance::{self, Clearance, FreeEdges, blocked, boxed_in, component, distances, free_edges};
use super::super::corners::ByCorner;
use super::super::lattice::{Coordinate, Lattice};
use super::super::points::Points;
use super::super::refinement::RefinementLevel;
use super::super::stencil::{Stencil, heights_above};
use crate::interaction::ShadingPoint;
use crate::sampling::set_bits;

/// The corners of a cell, and what follows from their clearances. Sets of corners have a bit per corner.
#[derive(Debug)]
pub(super) struct CellCache {
    /// The cell's lower corner.
    pub coordinate: Coordinate,
    slots: [Slot; 8],
    /// Which corners the next level takes over.
    pub refined: u8,
    pub filled: u8,
    pub empty: u8,
    /// Which of the empty ones have been marked.
    pub marked: u8,
    clearances: [Clearance; 8],
    /// The free edges and the boxed-in corners; unused where visibility is deferred.
    pub free_edges: FreeEdges,
    pub boxed_in: u8,
    /// The sides on which any corner has a surface near.
    blocked: u8,
    /// The clearances by side, and a bit for each side that has been computed.
    distances: [ByCorner; 6],
    computed: u8,
    /// The set of corners that [`Self::is_connected`] got last, and its answer.
    connected: (u8, bool),
    /// What [`Self::is_clear`] got last: normal, height and corners; and its answer.
    plane: (Vec3, f32, u8),
    clear: bool,
}

impl CellCache {
    /// No cell.
    pub(super) fn new() -> Self {
        Self {
            coordinate: IVec3::MAX,
            slots: [Slot::Empty; 8],
            refined: 0,
            filled: 0,
            empty: 0,
            marked: 0,
            clearances: [Clearance::default(); 8],
            free_edges: [0; 3],
            boxed_in: 0,
            blocked: 0,
            distances: [[Vec4::ZERO; 2]; 6],
            computed: 0,
            connected: (0, true),
            plane: (Vec3::ZERO, 0.0, 0),
            clear: false,
        }
    }

    /// Looks up the corners of another cell.
    pub(super) fn enter(&mut self, points: &Points, level: &RefinementLevel, coordinate: Coordinate) {
        // Look up the slots, and sort them.
        self.coordinate = coordinate;
        self.slots = level.slots(coordinate);
        let mask = |is: fn(Slot) -> bool| (0..8).map(|k| u8::from(is(self.slots[k])) << k).sum();
        self.filled = mask(|slot| matches!(slot, Slot::Filled(_)));
        self.empty = mask(|slot| slot == Slot::Empty);

        // Forget what was computed for the last cell.
        self.marked = 0;
        self.computed = 0;
        self.plane.0 = Vec3::ZERO;

        // Look up the clearances.
        self.clearances = self.slots.map(|slot| match slot {
            Slot::Filled(index) => points.clearance(index),
            Slot::Empty | Slot::Invalid => Clearance::default(),
        });
        self.blocked = blocked(&self.clearances, self.filled);
    }

    /// Finds the free edges and the boxed-in corners of the cell.
    pub(super) fn find_free_edges(&mut self) {
        self.free_edges = free_edges(&self.clearances);
        self.boxed_in = boxed_in(&self.clearances);
        self.connected = (0, true);
    }

    /// Returns the index of corner k, which is filled.
    #[inline(always)]
    pub(super) fn index(&self, k: usize) -> u32 {
        match self.slots[k] {
            Slot::Filled(index) => index,
            Slot::Empty | Slot::Invalid => unreachable!("corners that are read are filled"),
        }
    }

    /// Returns whether free edges connect all of some corners.
    #[inline(always)]
    pub(super) fn is_connected(&mut self, corners: u8) -> bool {
        if self.connected.0 != corners {
            self.connected = (corners, component(&self.free_edges, corners) == corners);
        }
        self.connected.1
    }

    /// Returns whether nothing stands between the vertex' plane and some corners of the cell, as far as they see along
    /// the axes. If that holds for all eight, nothing can hide any vertex on that plane from a corner:
    /// [`Self::occluded`] then is what [`Self::boxed_in`] is. Planes are told apart by their normal and their height in
    /// 1/256 of the spacing, and judged by the upper end of that step.
    #[inline(always)]
    pub(super) fn is_clear(&mut self, vertex: &ShadingPoint, stencil: &Stencil, corners: u8) -> bool {
        // The offset keeps walls on and half-way between lattice planes, the most of them, off the edges of steps.
        let step = (stencil.heights[0].x * 256.0 + 0.382).ceil();
        if self.plane != (vertex.ng, step, corners) {
            // Of the step, not of the vertex: the answer must not depend on which of them comes first.
            let heights = heights_above(vertex.ng, step * (1.0 / 256.0));
            self.plane = (vertex.ng, step, corners);
            self.clear = set_bits::<8>(self.blocked).all(|side| {
                clearance::before_plane(side, vertex.ng, &heights, &self.distances_to(side)) & corners == 0
            });
        }
        self.clear
    }

    /// Returns the corners that may have something between them and the vertex.
    #[inline(never)]
    pub(super) fn occluded(&mut self, lattice: &Lattice, vertex: &ShadingPoint, stencil: &Stencil) -> u8 {
        let position = (vertex.position - lattice.point(self.coordinate)) * lattice.inv_spacing();
        let mut occluded = self.boxed_in;

        // Compare the clearances along each axis with the way to the vertex, from both ends.
        for axis in 0..3 {
            for upper in [false, true] {
                let d = position[axis] - f32::from(u8::from(upper));
                if self.blocked >> (2 * axis + usize::from(d < 0.0)) & 1 != 0 {
                    let clearance = |side| self.distances_to(side);
                    occluded |= clearance::occluded(axis, upper, d, vertex.ng[axis], &stencil.heights, clearance);
                }
            }
        }
        occluded
    }

    /// Returns the corners' clearances towards a side.
    #[inline(always)]
    fn distances_to(&mut self, side: usize) -> ByCorner {
        if self.computed >> side & 1 == 0 {
            self.computed |= 1 << side;
            self.distances[side] = distances(&self.clearances, side);
        }
        self.distances[side]
    }
}
