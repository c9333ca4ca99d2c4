//! Which points are wanted and still empty: bits that many threads set and one reads in order.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::bricks::Bricks;
use crate::sampling::set_bits;

/// Marks on all levels of a mesh.
#[derive(Debug)]
pub(crate) struct Marks(Vec<LevelMarks>);

impl Marks {
    /// No marks, for lattices of so many bricks.
    pub(crate) fn new(bricks: impl Iterator<Item = usize>) -> Self {
        Self(bricks.map(LevelMarks::new).collect())
    }

    /// Marks place `local` of a brick of a level. The result does not depend on the order of calls.
    pub(super) fn set(&self, level: u32, brick: usize, local: usize) {
        self.0[level as usize].set(brick, local);
    }

    /// The marks by level.
    pub(super) fn levels(&mut self) -> impl Iterator<Item = &mut LevelMarks> {
        self.0.iter_mut()
    }
}

/// A bit per point of the bricks that somebody marked.
#[derive(Debug)]
pub(super) struct LevelMarks {
    /// Eight words per brick index, made when the brick is first marked.
    words: Vec<OnceLock<Box<[AtomicU64; 8]>>>,
    /// The brick indices that have words, in the order of their first mark.
    touched: Mutex<Vec<usize>>,
}

impl LevelMarks {
    /// No marks, for a lattice of so many bricks.
    pub(crate) fn new(bricks: usize) -> Self {
        Self { words: (0..bricks).map(|_| OnceLock::new()).collect(), touched: Mutex::default() }
    }

    fn set(&self, brick: usize, local: usize) {
        let words = self.words[brick].get_or_init(|| {
            self.touched.lock().unwrap_or_else(PoisonError::into_inner).push(brick);
            Box::default()
        });
        // Look first: most marks are there already, and a look does not take the cache line from other threads.
        let (word, bit) = (&words[local / 64], 1 << (local % 64));
        if word.load(Ordering::Relaxed) & bit == 0 {
            word.fetch_or(bit, Ordering::Relaxed);
        }
    }

    /// The bricks that have marks, in order, with their marks, a bit per place; clears them.
    pub(super) fn take_words(&mut self) -> Vec<(usize, [u64; 8])> {
        let touched = self.touched.get_mut().unwrap_or_else(PoisonError::into_inner);
        touched.sort_unstable();
        let words = touched.drain(..).filter_map(|brick| Some((brick, self.words[brick].take()?)));
        words.map(|(brick, words)| (brick, words.each_ref().map(|word| word.load(Ordering::Relaxed)))).collect()
    }

    /// The marked points as (brick, place), in that order, and how many of their bricks are new to `bricks`; clears the
    /// marks.
    pub(super) fn take(&mut self, bricks: &Bricks) -> (Vec<(usize, usize)>, u64) {
        let (mut wanted, mut new_bricks) = (Vec::new(), 0);
        for (brick, words) in self.take_words() {
            new_bricks += u64::from(!bricks.exists(brick));
            for (i, word) in words.into_iter().enumerate() {
                wanted.extend(set_bits::<64>(word).map(|bit| (brick, i * 64 + bit)));
            }
        }
        (wanted, new_bricks)
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec3;

    use super::*;

    #[test]
    fn marks_come_back_once_in_order_whoever_set_them_first() {
        let bricks = Bricks::new(UVec3::new(4, 1, 1));
        let mut marks = LevelMarks::new(4);
        for (brick, local) in [(3, 511), (0, 64), (3, 0), (0, 64), (0, 5)] {
            marks.set(brick, local);
        }
        assert_eq!(marks.take(&bricks), (vec![(0, 5), (0, 64), (3, 0), (3, 511)], 2));
        assert_eq!(marks.take(&bricks), (vec![], 0));
    }
}
