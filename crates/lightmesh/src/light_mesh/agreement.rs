//! What the mesh points around a surface agree on, light by light.

use glam::Vec3;

use super::light_bits::LightBits;
use crate::scene::Term;

/// What some mesh points say of each light together. The count is kept as long as the same points are read.
#[derive(Debug)]
pub(crate) struct Agreement {
    /// Whose votes have been counted, and who is read now, with φ4.
    counted: Vec<u32>,
    points: Vec<u32>,
    weights: Vec<f32>,
    /// By lane: 1 where all points receive the whole of a light, 0 where none receives any or they disagree.
    pub sure: Vec<f32>,
    /// The lanes about which they disagree, ascending.
    pub disputed: Vec<u32>,
    /// What the points of each disputed lane say: `seen` and `open`, a bit per point.
    votes: Vec<(u32, u32)>,
    /// Of at most eight points: the weight of every subset of the first four and of the last four, their sum 1.
    subsets: [[f32; 16]; 2],
    /// Lights on this side of the surface may be hidden by what hides points there; zero: no point is hidden.
    pub doubt: Vec3,
}

impl Agreement {
    /// Most points that are heard.
    const MAX_POINTS: usize = 32;

    /// Of no points, about so many lanes.
    pub(super) fn new(lanes: usize) -> Self {
        Self {
            counted: Vec::new(),
            points: Vec::new(),
            weights: Vec::new(),
            sure: vec![0.0; lanes],
            disputed: Vec::new(),
            votes: Vec::new(),
            subsets: [[0.0; 16]; 2],
            doubt: Vec3::ZERO,
        }
    }

    /// Forgets which points were read; `doubt` is about the next ones.
    #[inline(always)]
    pub(super) fn begin(&mut self, doubt: Vec3) {
        self.points.clear();
        self.weights.clear();
        self.doubt = doubt;
    }

    /// Adds a point that is read with weight φ4.
    #[inline(always)]
    pub(super) fn add(&mut self, point: u32, weight: f32) {
        if self.points.len() < Self::MAX_POINTS {
            self.points.push(point);
            self.weights.push(weight);
        }
    }

    /// Takes what the points say.
    #[inline(always)]
    pub(super) fn ask(&mut self, bits: &LightBits) -> &Self {
        if self.counted != self.points {
            self.counted.clone_from(&self.points);
            self.count(bits);
        }
        let total = 1.0 / self.weights.iter().sum::<f32>();
        self.weights.iter_mut().for_each(|weight| *weight *= total);
        if self.weights.len() <= 8 {
            for (half, subsets) in self.subsets.iter_mut().enumerate() {
                let weights = self.weights.get(4 * half..).unwrap_or_default();
                for (subset, sum) in subsets.iter_mut().enumerate() {
                    let of = |k: usize| if subset >> k & 1 != 0 { weights.get(k).copied().unwrap_or(0.0) } else { 0.0 };
                    *sum = (of(0) + of(1)) + (of(2) + of(3));
                }
            }
        }
        self
    }

    /// Counts the votes.
    fn count(&mut self, bits: &LightBits) {
        self.disputed.clear();
        self.votes.clear();
        for (word, sure) in self.sure.chunks_mut(64).enumerate() {
            let (mut all, mut any) = (u64::MAX, 0);
            for &point in &self.points {
                let (seen, open) = bits.rows(point);
                all &= seen[word];
                any |= open[word];
            }
            for (bit, sure) in sure.iter_mut().enumerate() {
                *sure = (all >> bit & 1) as f32;
            }
            for bit in ones(any & !all) {
                let (mut seen_by, mut open_to) = (0, 0);
                for (i, &point) in self.points.iter().enumerate() {
                    let (seen, open) = bits.rows(point);
                    seen_by |= ((seen[word] >> bit & 1) as u32) << i;
                    open_to |= ((open[word] >> bit & 1) as u32) << i;
                }
                self.disputed.push(word as u32 * 64 + bit);
                self.votes.push((seen_by, open_to));
            }
        }
    }

    /// V̂ of a light: the weighted mean of what the points say, a half for those that cannot tell.
    #[inline(always)]
    pub(crate) fn estimate(&self, term: &Term) -> f32 {
        let Some(i) = term.index else { return self.sure[term.lane as usize] };
        let (seen, open) = self.votes[i as usize];
        let weight = |voters: u32| -> f32 {
            if self.weights.len() <= 8 {
                return self.subsets[0][voters as usize & 15] + self.subsets[1][voters as usize >> 4 & 15];
            }
            self.weights.iter().enumerate().map(|(k, weight)| (voters >> k & 1) as f32 * weight).sum()
        };
        0.5 * (weight(seen) + weight(open))
    }
}

/// The places of the set bits, ascending.
fn ones(mut word: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points: both see lane 0, neither lane 1, one lane 2, one lane 3 through glass.
    #[test]
    fn agreement_is_told_from_dispute() {
        let mut bits = LightBits::new(16);
        let pack = |v: [f32; 4]| bits.pack(&[0, 1, 2, 3], &v.map(Vec3::splat), &[!0xf]);
        let points = [pack([1.0, 0.0, 1.0, 0.0]), pack([1.0, 0.0, 0.0, 0.4])];
        points.iter().for_each(|point| bits.push(point));
        let mut agreement = Agreement::new(16);
        let mut ask = |weights: [f32; 2]| {
            agreement.begin(Vec3::ZERO);
            weights.iter().enumerate().for_each(|(point, &weight)| agreement.add(point as u32, weight));
            let agreement = agreement.ask(&bits);
            let term = |i| Term { lane: 2 + i, index: Some(i), direction: Vec3::Y, factor: 1.0, mass: 1.0 };
            [0, 1].map(|i| agreement.estimate(&term(i)))
        };
        assert_eq!(ask([3.0, 1.0]), [0.75, 0.125]);
        // The same points again: other weights, the same votes.
        assert_eq!(ask([1.0, 1.0]), [0.5, 0.25]);
        assert_eq!(agreement.disputed, [2, 3]);
        assert_eq!(agreement.sure[..4], [1.0, 0.0, 0.0, 0.0]);
    }
}
