//! What the mesh points around a surface agree on, light by light.

use super::light_bits::LightBits;

/// What some mesh points say of each light together. It is kept as long as the same points are read.
#[derive(Debug, Default)]
pub(crate) struct Agreement {
    /// Whose votes have been counted, and who is read now.
    points: Vec<u32>,
    read: Vec<u32>,
    /// By lane: 1 where all points receive the whole of a light, 0 where none receives any or they disagree.
    pub sure: Vec<f32>,
    /// The lanes about which they disagree, ascending.
    pub disputed: Vec<u32>,
    /// What the points of each disputed lane say: `seen` and `open`, a bit per point.
    votes: Vec<(u32, u32)>,
    /// φ4 of the points, with sum 1.
    weights: Vec<f32>,
}

impl Agreement {
    /// Most points whose votes are counted.
    const MAX_POINTS: usize = 32;

    /// Forgets which points were read.
    #[inline(always)]
    pub(super) fn begin(&mut self) {
        self.read.clear();
        self.weights.clear();
    }

    /// Adds a point that is read with weight φ4.
    #[inline(always)]
    pub(super) fn add(&mut self, point: u32, weight: f32) {
        if self.read.len() < Self::MAX_POINTS {
            self.read.push(point);
            self.weights.push(weight);
        }
    }

    /// Takes what the points say.
    #[inline(always)]
    pub(super) fn ask(&mut self, bits: &LightBits, lanes: usize) {
        let sum: f32 = self.weights.iter().sum();
        self.weights.iter_mut().for_each(|weight| *weight /= sum);
        if self.points != self.read {
            std::mem::swap(&mut self.points, &mut self.read);
            self.count(bits, lanes);
        }
    }

    /// Counts the votes of other points than before.
    fn count(&mut self, bits: &LightBits, lanes: usize) {
        self.sure.clear();
        self.sure.resize(lanes, 0.0);
        self.disputed.clear();
        self.votes.clear();
        for word in 0..lanes.div_ceil(64) {
            let (mut all, mut any) = (u64::MAX, 0);
            for &point in &self.points {
                let (seen, open) = bits.rows(point);
                all &= seen[word];
                any |= open[word];
            }
            let lane = |bit: u32| word as u32 * 64 + bit;
            for bit in ones(all) {
                self.sure[lane(bit) as usize] = 1.0;
            }
            for bit in ones(any & !all) {
                self.disputed.push(lane(bit));
                let (mut seen_by, mut open_to) = (0, 0);
                for (i, &point) in self.points.iter().enumerate() {
                    let (seen, open) = bits.rows(point);
                    seen_by |= (seen[word] >> bit & 1) as u32 * (1 << i);
                    open_to |= (open[word] >> bit & 1) as u32 * (1 << i);
                }
                self.votes.push((seen_by, open_to));
            }
        }
    }

    /// V̂ of the i-th disputed lane: the weighted mean of what the points say, a half for those that cannot tell.
    #[inline(always)]
    pub(crate) fn estimate(&self, i: usize) -> f32 {
        let (seen, open) = self.votes[i];
        let vote = |k: usize| 0.5 * ((seen >> k & 1) + (open >> k & 1)) as f32;
        self.weights.iter().enumerate().map(|(k, weight)| weight * vote(k)).sum::<f32>().clamp(0.0, 1.0)
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
    use glam::Vec3;

    use super::*;

    /// Two points: both see lane 0, neither lane 1, one lane 2, one lane 3 through glass.
    #[test]
    fn agreement_is_told_from_dispute() {
        let mut bits = LightBits::new(16);
        let pack = |v: [f32; 4]| bits.pack(&[0, 1, 2, 3], &v.map(Vec3::splat), &[!0xf]);
        let points = [pack([1.0, 0.0, 1.0, 0.0]), pack([1.0, 0.0, 0.0, 0.4])];
        points.iter().for_each(|point| bits.push(point));
        let mut agreement = Agreement::default();
        let mut ask = |weights: [f32; 2]| {
            agreement.begin();
            weights.iter().enumerate().for_each(|(point, &weight)| agreement.add(point as u32, weight));
            agreement.ask(&bits, 16);
            [0, 1].map(|i| agreement.estimate(i))
        };
        assert_eq!(ask([3.0, 1.0]), [0.75, 0.125]);
        // The same points again: other weights, the same votes.
        assert_eq!(ask([1.0, 1.0]), [0.5, 0.25]);
        assert_eq!(agreement.disputed, [2, 3]);
        assert_eq!(agreement.sure[..4], [1.0, 0.0, 0.0, 0.0]);
    }
}
