//! The states of single lights: two bits per light.
//!
//! A point has two rows of 64-bit words. Lane i is bit i mod 64 of word i / 64 of its row; point p has the words
//! `2 w p .. 2 w (p + 1)` with w = ⌈lanes / 64⌉, the row `visible` before the row `possible`. Example with 70 lanes,
//! w = 2: lane 65 of point 3 is bit 1 of words 13 and 15.
//!
//! | visible | possible | |
//! |---|---|---|
//! | 1 | 1 | all of the light arrives |
//! | 0 | 0 | nothing arrives |
//! | 0 | 1 | some arrives (through glass), or the light does not shine on the point, which therefore cannot tell |

use glam::Vec3;

use super::super::DirectValues;
use super::super::plain_arrays::{check_length, refuse};
use super::LightState;
use crate::light::LightSamples;

/// The bits of the points of a mesh.
#[derive(Debug, Default)]
pub(crate) struct LightBits {
    /// Words of a row.
    words: usize,
    bits: Vec<u64>,
    /// The lanes that only fill up blocks of lights, a bit each: they never shine.
    padding: Vec<u64>,
}

/// The two rows of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BitRows<'a> {
    pub visible: &'a [u64],
    pub possible: &'a [u64],
}

impl LightBits {
    /// For the lights of a scene.
    pub(super) fn of_scene(samples: &LightSamples) -> Self {
        let lanes = samples.lanes();
        let mut padding = vec![0; lanes.div_ceil(64)];
        for lane in (0..64 * padding.len()).filter(|&i| i >= lanes || samples.intensity(i) == Vec3::ZERO) {
            padding[lane / 64] |= 1 << (lane % 64);
        }
        Self::with_padding(lanes, padding)
    }

    /// For `lanes` lanes, of which those in `padding` never shine.
    pub(crate) fn with_padding(lanes: usize, padding: Vec<u64>) -> Self {
        Self { words: lanes.div_ceil(64), bits: Vec::new(), padding }
    }

    /// Returns the memory of a point, bytes.
    pub(super) fn bytes_per_point(&self) -> u64 {
        (2 * self.words * size_of::<u64>()) as u64
    }

    /// Returns the memory of all points, bytes.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(self.bits.as_slice()) as u64
    }

    /// Returns the bits of a point at which the part `visible` of the lights of `lanes` arrives; it cannot tell about
    /// others.
    pub(crate) fn pack(&self, lanes: &[u32], visible: &[Vec3]) -> Vec<u64> {
        // Start with lights that the point cannot tell about.
        let mut bits = vec![0; 2 * self.words];
        let (visible_row, possible_row) = bits.split_at_mut(self.words);
        for (possible, padding) in possible_row.iter_mut().zip(&self.padding) {
            *possible = !padding;
        }

        // Set the bits of those that all arrive or are occluded.
        for (&lane, &v) in lanes.iter().zip(visible) {
            let (word, bit) = (lane as usize / 64, 1 << (lane % 64));
            match LightState::of_visibility(v) {
                LightState::Visible => visible_row[word] |= bit,
                LightState::Occluded => possible_row[word] &= !bit,
                LightState::Unknown => {}
            }
        }
        bits
    }

    /// Removes all points and starts with other lanes; the memory is kept.
    pub(crate) fn restart(&mut self, lanes: usize) {
        self.words = lanes.div_ceil(64);
        self.bits.clear();
    }

    /// Adds a point with these states of its lanes.
    pub(crate) fn push_states(&mut self, states: impl Iterator<Item = (usize, LightState)>) {
        let begin = self.bits.len();
        self.bits.resize(begin + 2 * self.words, 0);
        let (visible, possible) = self.bits[begin..].split_at_mut(self.words);
        for (lane, state) in states {
            let (word, bit) = (lane / 64, lane % 64);
            visible[word] |= u64::from(state == LightState::Visible) << bit;
            possible[word] |= u64::from(state != LightState::Occluded) << bit;
        }
    }

    /// Adds a point's bits.
    pub(crate) fn push(&mut self, bits: &[u64]) {
        self.bits.extend_from_slice(bits);
    }

    /// Returns the rows of a point.
    #[inline(always)]
    pub(crate) fn rows(&self, point: u32) -> BitRows<'_> {
        let (visible, possible) = self.of(point).split_at(self.words);
        BitRows { visible, possible }
    }

    /// Returns the words of a point.
    #[inline(always)]
    fn of(&self, point: u32) -> &[u64] {
        &self.bits[2 * self.words * point as usize..][..2 * self.words]
    }

    /// Copies some points: shape (N, 2, words).
    pub(super) fn snapshot(&self, indices: impl Iterator<Item = u32>) -> DirectValues {
        let bits = indices.flat_map(|i| self.of(i).iter().copied()).collect();
        DirectValues::Lights { words: self.words as u32, bits }
    }

    /// Refuses what cannot be the bits of this number of points of this scene.
    pub(super) fn check(&self, words: usize, bits: &[u64], points: usize) -> Result<(), crate::Error> {
        if words != self.words {
            let what = format!("have {words} words of bits for the lights; this scene has {}", self.words);
            return refuse("direct values", what);
        }
        check_length("direct values", bits.len(), &[points, 2, words])?;
        // Refuse rows by which all of a light arrives and nothing does, or by which padding shines. Without lights
        // there are no words.
        for (point, rows) in bits.chunks_exact(2 * words.max(1)).enumerate() {
            let (visible, possible) = rows.split_at(words);
            let is_unsound = |i: usize| visible[i] & !possible[i] != 0 || possible[i] & self.padding[i] != 0;
            if (0..words).any(is_unsound) {
                return refuse(format!("direct values, point {point}"), "its bits contradict each other");
            }
        }
        Ok(())
    }

    /// Adds point i of a snapshot.
    pub(super) fn push_snapshot(&mut self, bits: &[u64], i: usize) {
        self.bits.extend_from_slice(&bits[i * 2 * self.words..][..2 * self.words]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_states_of_a_light_are_told_apart() {
        // Lanes 68 and 69 are padding; 2 was not traced.
        let mut bits = LightBits::with_padding(70, vec![0, 0b11 << 4]);
        let tinted = Vec3::new(1.0, 0.5, 1.0);
        let packed = bits.pack(&[0, 1, 65, 66], &[Vec3::ONE, Vec3::ZERO, Vec3::ONE, tinted]);
        bits.push(&[0; 4]);
        bits.push(&packed);
        let BitRows { visible, possible } = bits.rows(1);
        let state = |lane: usize| (visible[lane / 64] >> (lane % 64) & 1, possible[lane / 64] >> (lane % 64) & 1);
        assert_eq!([0, 1, 2, 65, 66, 68].map(state), [(1, 1), (0, 0), (0, 1), (1, 1), (0, 1), (0, 0)]);
        assert_eq!(bits.bytes_per_point(), 32);
    }
}
