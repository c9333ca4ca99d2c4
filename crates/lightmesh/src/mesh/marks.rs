//! Marks: the points that have been requested and are still empty, as bits that many threads set and one reads in
//! order.

use std::hash::BuildHasher;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::bricks::{Bricks, ByBrick};
use super::lattice::BrickKey;
use crate::sampling::set_bits;

/// A brick of a level.
pub(super) type LevelBrick = (u32, BrickKey);

/// Parts of the table, each with a lock of its own: threads seldom wait for each other.
const PARTS: usize = 64;

/// Marks on all levels of a mesh: a bit per point of the bricks that have any.
#[derive(Debug)]
pub(crate) struct Marks {
    parts: Box<[Part]>,
    hasher: std::hash::BuildHasherDefault<super::bricks::KeyHasher>,
}

/// Eight words per marked brick.
type Part = Mutex<ByBrick<LevelBrick, [u64; 8]>>;

impl Default for Marks {
    fn default() -> Self {
        Self { parts: (0..PARTS).map(|_| Part::default()).collect(), hasher: Default::default() }
    }
}

impl Marks {
    /// Marks point `local` of a brick of a level. The result does not depend on the order of calls.
    pub(super) fn set(&self, level: u32, brick: BrickKey, local: usize) {
        let key = (level, brick);
        // Not the bits that the table itself uses.
        let part = (self.hasher.hash_one(key) >> 40) as usize % PARTS;
        lock(&self.parts[part]).entry(key).or_default()[local / 64] |= 1 << (local % 64);
    }

    /// Returns the bricks that have marks, in order, with their marks, a bit per point; clears them.
    pub(super) fn take_masks(&mut self) -> Vec<(LevelBrick, [u64; 8])> {
        let mut masks: Vec<_> = self.parts.iter().flat_map(|part| std::mem::take(&mut *lock(part))).collect();
        masks.sort_unstable_by_key(|&(key, _)| key);
        masks
    }

    /// Returns the marked points in order; clears the marks. `bricks` gives those of a level.
    pub(super) fn take<'a>(&mut self, bricks: impl Fn(u32) -> &'a Bricks) -> MarkedPoints {
        let mut marked = MarkedPoints::default();
        for ((level, brick), words) in self.take_masks() {
            marked.new_bricks += u64::from(!bricks(level).exists(brick));
            for (i, word) in words.into_iter().enumerate() {
                marked.points.extend(set_bits::<64>(word).map(|bit| (level, brick, i * 64 + bit)));
            }
        }
        marked
    }
}

fn lock(part: &Part) -> MutexGuard<'_, ByBrick<LevelBrick, [u64; 8]>> {
    part.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The marked points of a mesh.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct MarkedPoints {
    /// Level, brick, and index in the brick.
    pub points: Vec<(u32, BrickKey, usize)>,
    /// How many of their bricks have no slots yet.
    pub new_bricks: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_come_back_once_and_in_order() {
        let bricks = Bricks::default();
        let mut marks = Marks::default();
        for (level, brick, local) in [(0, 3, 511), (1, 0, 7), (0, 0, 64), (0, 3, 0), (0, 0, 64), (0, 0, 5)] {
            marks.set(level, brick, local);
        }
        let points = vec![(0, 0, 5), (0, 0, 64), (0, 3, 0), (0, 3, 511), (1, 0, 7)];
        assert_eq!(marks.take(|_| &bricks), MarkedPoints { points, new_bricks: 3 });
        assert_eq!(marks.take(|_| &bricks), MarkedPoints::default());
    }
}
