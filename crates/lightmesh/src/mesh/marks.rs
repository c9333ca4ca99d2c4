//! Marks: the points that have been requested and are still empty, as bits that many threads set and one reads in
//! order.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::bricks::Bricks;
use crate::sampling::set_bits;

/// Marks on all levels of a mesh.
#[derive(Debug)]
pub(crate) struct Marks(Vec<LevelMarks>);

impl Marks {
    /// No marks, for lattices with these numbers of bricks.
    pub(crate) fn new(bricks: impl Iterator<Item = usize>) -> Self {
        Self(bricks.map(LevelMarks::new).collect())
    }

    /// Marks point `local` of a brick of a level. The result does not depend on the order of calls.
    pub(super) fn set(&self, level: u32, brick: usize, local: usize) {
        self.0[level as usize].set(brick, local);
    }

    /// Returns the marks by level.
    pub(super) fn levels(&mut self) -> impl Iterator<Item = &mut LevelMarks> {
        self.0.iter_mut()
    }
}

/// The marks of a level: a bit per point of the bricks that have any.
#[derive(Debug)]
pub(super) struct LevelMarks {
    /// Eight words per brick index, made when the brick is first marked.
    words: Vec<OnceLock<Box<[AtomicU64; 8]>>>,
    /// The brick indices that have words, in the order of their first mark.
    touched: Mutex<Vec<usize>>,
}

impl LevelMarks {
    /// No marks, for a lattice of `bricks` bricks.
    pub(crate) fn new(bricks: usize) -> Self {
        Self { words: (0..bricks).map(|_| OnceLock::new()).collect(), touched: Mutex::default() }
    }

    /// Marks point `local` of a brick.
    fn set(&self, brick: usize, local: usize) {
        let words = self.words[brick].get_or_init(|| {
            self.touched.lock().unwrap_or_else(PoisonError::into_inner).push(brick);
            Box::default()
        });
        // Read first: most marks are there already, and a read does not take the cache line from other threads.
        let (word, bit) = (&words[local / 64], 1 << (local % 64));
        if word.load(Ordering::Relaxed) & bit == 0 {
            word.fetch_or(bit, Ordering::Relaxed);
        }
    }

    /// Returns the bricks that have marks, in order, with their marks, a bit per point; clears them.
    pub(super) fn take_masks(&mut self) -> Vec<(usize, [u64; 8])> {
        let touched = self.touched.get_mut().unwrap_or_else(PoisonError::into_inner);
        touched.sort_unstable();
        let words = touched.drain(..).filter_map(|brick| Some((brick, self.words[brick].take()?)));
        words.map(|(brick, words)| (brick, words.each_ref().map(|word| word.load(Ordering::Relaxed)))).collect()
    }

    /// Returns the marked points in order; clears the marks.
    pub(super) fn take(&mut self, bricks: &Bricks) -> MarkedPoints {
        let mut marked = MarkedPoints::default();
        for (brick, words) in self.take_masks() {
            marked.new_bricks += u64::from(!bricks.exists(brick));
            for (i, word) in words.into_iter().enumerate() {
                marked.points.extend(set_bits::<64>(word).map(|bit| (brick, i * 64 + bit)));
            }
        }
        marked
    }
}

/// The marked points of a level.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct MarkedPoints {
    /// Brick index, and index in the brick.
    pub points: Vec<(usize, usize)>,
    /// How many of their bricks have no slots yet.
    pub new_bricks: u64,
}

#[cfg(test)]
mod tests {
    use glam::UVec3;

    use super::*;

    #[test]
    fn marks_come_back_once_and_in_order() {
        let bricks = Bricks::new(UVec3::new(4, 1, 1));
        let mut marks = LevelMarks::new(4);
        for (brick, local) in [(3, 511), (0, 64), (3, 0), (0, 64), (0, 5)] {
            marks.set(brick, local);
        }
        let points = vec![(0, 5), (0, 64), (3, 0), (3, 511)];
        assert_eq!(marks.take(&bricks), MarkedPoints { points, new_bricks: 2 });
        assert_eq!(marks.take(&bricks), MarkedPoints::default());
    }
}
