//! Requests for mesh points as plain numbers: marks that go from process to process.

use super::bricks::Slot;
use super::lattice::{self, BrickKey};
use super::marks::Marks;
use super::points::Points;
use crate::Error;

/// A set of points in one brick of a mesh. Point (i, j, k) of the lattice is in brick (i / 8, j / 8, k / 8), at index
/// (i mod 8) + 8 (j mod 8) + 64 (k mod 8); divisions round down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BrickMask {
    /// The level of the mesh, as in [`PointSnapshot::lattices`](crate::PointSnapshot::lattices); 0 is the coarsest.
    pub level: u32,
    /// The coordinates of the brick, packed: x + 2²⁰ in bits 0 to 20, y + 2²⁰ in bits 21 to 41, z + 2²⁰ above.
    pub brick: u64,
    /// One bit per point: index p is bit p mod 64 of word p / 64.
    pub mask: [u64; 8],
}

impl BrickMask {
    /// Returns the number of points in the set.
    pub fn len(&self) -> u32 {
        self.mask.iter().map(|word| word.count_ones()).sum()
    }

    /// Returns whether the set has no points.
    pub fn is_empty(&self) -> bool {
        self.mask == [0; 8]
    }
}

/// The mesh points that a picture needs, for the meshes of direct and of indirect light. Each list has each brick once,
/// ordered by level and brick.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PointRequests {
    /// Points of the mesh of direct light.
    pub direct: Vec<BrickMask>,
    /// Points of the mesh of indirect light.
    pub indirect: Vec<BrickMask>,
}

impl PointRequests {
    /// Returns whether no points are requested.
    pub fn is_empty(&self) -> bool {
        self.direct.is_empty() && self.indirect.is_empty()
    }

    /// Returns the number of points, of both meshes together.
    pub fn len(&self) -> u64 {
        self.direct.iter().chain(&self.indirect).map(|brick| u64::from(brick.len())).sum()
    }

    /// Adds the points of other requests.
    pub fn merge(&mut self, other: &Self) {
        merge(&mut self.direct, &other.direct);
        merge(&mut self.indirect, &other.indirect);
    }

    /// Removes the points of other requests.
    pub fn remove(&mut self, other: &Self) {
        remove(&mut self.direct, &other.direct);
        remove(&mut self.indirect, &other.indirect);
    }
}

/// Removes points from bricks.
fn remove(bricks: &mut Vec<BrickMask>, others: &[BrickMask]) {
    bricks.retain_mut(|brick| {
        let other = others.binary_search_by_key(&(brick.level, brick.brick), |other| (other.level, other.brick));
        if let Ok(i) = other {
            brick.mask.iter_mut().zip(others[i].mask).for_each(|(points, other)| *points &= !other);
        }
        !brick.is_empty()
    });
}

/// Adds points to bricks, and puts each brick once, in order.
fn merge(bricks: &mut Vec<BrickMask>, others: &[BrickMask]) {
    bricks.extend_from_slice(others);
    bricks.sort_unstable_by_key(|brick| (brick.level, brick.brick));
    bricks.dedup_by(|next, first| {
        let same = (next.level, next.brick) == (first.level, first.brick);
        if same {
            first.mask.iter_mut().zip(next.mask).for_each(|(points, more)| *points |= more);
        }
        same
    });
}

/// Returns the marked points and clears the marks.
pub(crate) fn take(marks: &mut Marks) -> Vec<BrickMask> {
    marks.take_masks().into_iter().map(|((level, brick), mask)| BrickMask { level, brick, mask }).collect()
}

/// Marks those of some points that have no values yet.
///
/// # Errors
/// [`Error::InvalidBricks`] for bricks that the mesh does not have.
pub(crate) fn mark(points: &Points, bricks: &[BrickMask], marks: &Marks) -> Result<(), Error> {
    for_each_point(points, bricks, |level, brick, local, slot| {
        if !slot.is_complete() {
            marks.set(level, brick, local);
        }
    })
}

/// Visits level, brick and index in the brick of each point, and its slot.
///
/// # Errors
/// As [`mark`].
pub(crate) fn for_each_point(
    points: &Points,
    bricks: &[BrickMask],
    mut visit: impl FnMut(u32, BrickKey, usize, Slot),
) -> Result<(), Error> {
    for &BrickMask { level, brick, mask } in bricks {
        // Refuse bricks outside the lattice.
        let own = (level < points.level_count()).then(|| points.level(level));
        let Some(level_points) = own.filter(|own| own.lattice.contains_brick(brick)) else {
            let [x, y, z] = lattice::coordinate(brick, 0).to_array().map(|c| c / 8);
            let what = format!("the mesh has no brick ({x}, {y}, {z}) on level {level}: it is of another mesh");
            return Err(Error::InvalidBricks { what });
        };

        // Visit the points that are set.
        let slots = level_points.bricks.brick(brick);
        let set = (0..512).filter(|local| mask[local / 64] >> (local % 64) & 1 != 0);
        set.for_each(|local| visit(level, brick, local, slots.slot(local)));
    }
    Ok(())
}
