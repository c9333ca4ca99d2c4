//! The points of one mesh: where they are, which are known, and what each sees of its neighbours. Values are kept by the
//! fields, under the same index.

use glam::Vec3;

use super::Coordinate;
use super::bricks::{Bricks, Slot};
use super::clearance::Clearance;
use super::lattice::{self, Lattice};
use super::marks::Marks;
use super::neighbourhood::{Neighbourhood, corner};
use super::reader::{Reader, Sight};
use crate::{Error, MeshStats, Scene};

/// Points of a lattice, filled as they are asked for.
#[derive(Debug)]
pub(crate) struct Points {
    pub(super) lattice: Lattice,
    pub(super) neighbourhood: Neighbourhood,
    bricks: Bricks,
    /// By index of the filled point.
    coordinates: Vec<Coordinate>,
    clearances: Vec<Clearance>,
    /// Coordinates of the points inside solids.
    invalid: Vec<Coordinate>,
}

/// A point that was wanted: where, and what was found there; `None`: it is inside a solid.
pub(super) type Probed = (Coordinate, Option<Clearance>);

impl Points {
    pub(super) fn new(lattice: Lattice, neighbourhood: Neighbourhood) -> Self {
        let bricks = Bricks::new(lattice.bricks());
        Self { lattice, neighbourhood, bricks, coordinates: Vec::new(), clearances: Vec::new(), invalid: Vec::new() }
    }

    /// Filled points, whose indices go from 0 up.
    pub(super) fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// Where a filled point is, metres.
    pub(super) fn position(&self, index: usize) -> Vec3 {
        self.lattice.point(self.coordinates[index])
    }

    /// Where the filled points are, metres, in the order in which they were filled.
    pub(crate) fn valid_positions(&self) -> impl Iterator<Item = Vec3> {
        self.coordinates.iter().map(|&coordinate| self.lattice.point(coordinate))
    }

    /// Where the points are that were found inside solids, metres.
    pub(crate) fn invalid_positions(&self) -> impl Iterator<Item = Vec3> {
        self.invalid.iter().map(|&coordinate| self.lattice.point(coordinate))
    }

    /// Distance between neighbours, metres.
    pub(crate) fn spacing(&self) -> f32 {
        self.lattice.spacing()
    }

    pub(super) fn coordinate(&self, index: usize) -> Coordinate {
        self.coordinates[index]
    }

    pub(super) fn clearance(&self, index: u32) -> Clearance {
        self.clearances[index as usize]
    }

    #[inline(always)]
    pub(super) fn slot(&self, coordinate: Coordinate) -> Slot {
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

    pub(super) fn mark(&self, coordinate: Coordinate, marks: &Marks) {
        let (brick, local) = lattice::split(coordinate);
        marks.set(self.lattice.brick_index(brick), local);
    }

    /// No marks yet.
    pub(super) fn marks(&self) -> Marks {
        Marks::new(self.lattice.brick_count())
    }

    /// A reader for one thread.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, sight: Sight) -> Reader<'a> {
        Reader::new(scene, self, sight)
    }

    /// The marked points in brick order; clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if they, at `bytes_per_point` for what the field keeps of each, would not fit into `limit`
    /// bytes; nothing has been allocated.
    pub(super) fn take(&self, marks: &mut Marks, bytes_per_point: u64, limit: u64) -> Result<Vec<Coordinate>, Error> {
        let (wanted, new_bricks) = marks.take(&self.bricks);
        let points = (self.len() + wanted.len()) as u64;
        // A growing vector may hold twice its contents for a moment.
        let bytes = 2 * (bytes_per_point + Self::BYTES_PER_POINT);
        let needed = self.bricks.bytes() + new_bricks * Bricks::BYTES_PER_BRICK + points.saturating_mul(bytes);
        if needed > limit || points >= u64::from(Slot::MAX_INDEX) {
            return Err(Error::OutOfMemory {
                what: "the light mesh",
                needed_bytes: needed,
                limit_bytes: limit,
                advice: "choose a larger --spacing or --indirect-spacing",
            });
        }
        Ok(wanted.into_iter().map(|(brick, local)| self.lattice.coordinate(brick, local)).collect())
    }

    const BYTES_PER_POINT: u64 = (size_of::<Coordinate>() + size_of::<Clearance>()) as u64;

    /// Stores a point; a valid one gets the next index.
    pub(super) fn insert(&mut self, (coordinate, clearance): Probed) {
        let slot = match clearance {
            Some(clearance) => {
                self.coordinates.push(coordinate);
                self.clearances.push(clearance);
                Slot::Filled(self.coordinates.len() as u32 - 1)
            }
            None => {
                self.invalid.push(coordinate);
                Slot::Invalid
            }
        };
        let (brick, local) = lattice::split(coordinate);
        self.bricks.set(self.lattice.brick_index(brick), local, slot);
    }

    /// Points so far, and the memory of them and of `value_bytes` of values.
    pub(super) fn stats(&self, value_bytes: u64) -> MeshStats {
        MeshStats {
            spacing_m: f64::from(self.lattice.spacing()),
            points_used: (self.len() + self.invalid.len()) as u64,
            points_total: self.lattice.point_count(),
            points_invalid: self.invalid.len() as u64,
            bytes: self.bricks.bytes() + self.len() as u64 * Self::BYTES_PER_POINT + value_bytes,
        }
    }
}
