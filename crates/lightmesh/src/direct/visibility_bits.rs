//! What mesh points know of each single light: whether all of it arrives, none of it, or neither is known.
//!
//! Two bits per light lane, in two rows of 64-bit words per point. Lane i is bit i mod 64 of word i / 64 of its row; point p has
//! the words `2 w p .. 2 w (p + 1)` with w = ⌈lanes / 64⌉, the row `seen` before the row `open`.
//!
//! | seen | open | |
//! |---|---|---|
//! | 1 | 1 | all of the light arrives |
//! | 0 | 0 | nothing arrives |
//! | 0 | 1 | some arrives (through glass), or the light does not shine on the point, which therefore cannot tell |

use glam::Vec3;

use super::visibility_runs::State;

/// The bits of the points of a mesh.
#[derive(Debug, Default)]
pub(crate) struct LightBits {
    words: usize,
    bits: Vec<u64>,
}

impl LightBits {
    /// For so many lanes.
    pub(crate) fn new(lanes: usize) -> Self {
        Self { words: lanes.div_ceil(64), bits: Vec::new() }
    }

    /// Words of a row.
    pub(crate) fn words(&self) -> usize {
        self.words
    }

    /// The words of a point.
    pub(crate) fn of(&self, point: u32) -> &[u64] {
        &self.bits[2 * self.words * point as usize..][..2 * self.words]
    }

    /// Memory per point, bytes.
    pub(super) fn bytes_per_point(&self) -> u64 {
        (2 * self.words * size_of::<u64>()) as u64
    }

    /// Memory of all points, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.bits.as_slice())
    }

    /// The bits of a point towards whose lights `lanes` so much gets through; those in `dark` never shine, and of the rest it knows
    /// nothing.
    pub(super) fn pack(&self, lanes: &[u32], visible: &[Vec3], dark: &[u64]) -> Vec<u64> {
        let mut bits = vec![0; 2 * self.words];
        let (seen, open) = bits.split_at_mut(self.words);
        for (open, dark) in open.iter_mut().zip(dark) {
            *open = !dark;
        }
        for (&lane, &v) in lanes.iter().zip(visible) {
            let (word, bit) = (lane as usize / 64, 1 << (lane % 64));
            if v == Vec3::ONE {
                seen[word] |= bit;
            } else if v == Vec3::ZERO {
                open[word] &= !bit;
            }
        }
        bits
    }

    /// No points, for so many lanes; what was allocated is kept.
    pub(super) fn restart(&mut self, lanes: usize) {
        self.words = lanes.div_ceil(64);
        self.bits.clear();
    }

    /// Adds a point that says this of its lanes.
    pub(super) fn push_states(&mut self, states: impl Iterator<Item = (usize, State)>) {
        let begin = self.bits.len();
        self.bits.resize(begin + 2 * self.words, 0);
        let (seen, open) = self.bits[begin..].split_at_mut(self.words);
        for (lane, state) in states {
            let (word, bit) = (lane / 64, lane % 64);
            seen[word] |= u64::from(state == State::Seen) << bit;
            open[word] |= u64::from(state != State::Closed) << bit;
        }
    }

    /// Adds a point's bits.
    pub(crate) fn push(&mut self, bits: &[u64]) {
        self.bits.extend_from_slice(bits);
    }

    /// The rows `seen` and `open` of a point.
    #[inline(always)]
    pub(super) fn rows(&self, point: u32) -> (&[u64], &[u64]) {
        self.bits[2 * self.words * point as usize..][..2 * self.words].split_at(self.words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_states_of_a_light_are_told_apart() {
        let mut bits = LightBits::new(70);
        let tinted = Vec3::new(1.0, 0.5, 1.0);
        // Lanes 68 and 69 are padding; 2 was not asked about.
        let packed = bits.pack(&[0, 1, 65, 66], &[Vec3::ONE, Vec3::ZERO, Vec3::ONE, tinted], &[0, 0b11 << 4]);
        bits.push(&[0; 4]);
        bits.push(&packed);
        let (seen, open) = bits.rows(1);
        let state = |lane: usize| (seen[lane / 64] >> (lane % 64) & 1, open[lane / 64] >> (lane % 64) & 1);
        assert_eq!([0, 1, 2, 65, 66, 68].map(state), [(1, 1), (0, 0), (0, 1), (1, 1), (0, 1), (0, 0)]);
        assert_eq!(bits.bytes_per_point(), 32);
    }
}
