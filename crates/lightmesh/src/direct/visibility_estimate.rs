//! What the mesh points around a surface agree on, light by light.

use glam::{Vec3, Vec4};

use super::visibility_bits::LightBits;
use crate::light::LANES;
use crate::mesh::{ByCorner, ONES, set_bits as corners_of};
use crate::sampling::set_bits;

/// Most points that are heard.
const MAX_POINTS: usize = 32;

/// What some mesh points say of each light together. Votes are kept as long as the same points are read.
#[derive(Debug)]
pub(crate) struct VisibilityEstimate {
    /// Who reads: whose votes have been counted.
    counted: Sources,
    points: Vec<u32>,
    /// φ4 of each voter, four by four, in all 1; only as many of them as there are voters are used.
    weights: [Vec4; MAX_POINTS / 4],
    /// Fours of weights that are used.
    fours: usize,
    /// By lane: 1 where all points receive the whole of a light, 0 where none receives any or they disagree.
    pub certain: Vec<f32>,
    /// By block: the lanes about which they disagree, a bit each.
    partial: Vec<u32>,
    /// What the points say of each disputed lane, ascending: `seen` and `open`, a bit per voter.
    rows: Vec<(u32, u32)>,
    /// Lights on this side of the surface may be hidden by what hides points there; zero: no point is hidden.
    pub occluder_direction: Vec3,
    /// Whether something stands near the surface, so that the points may all miss its shadow.
    pub near_occluder: bool,
}

/// Some points that vote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sources {
    Nobody,
    /// Corners of the cell that a reader is in, as long as it stays there: its visit, and a bit per corner.
    Corners(u64, u8),
    /// Those that are listed.
    Listed,
}

impl VisibilityEstimate {
    /// Of no points, about so many lanes.
    pub(crate) fn new(lanes: usize) -> Self {
        Self {
            counted: Sources::Nobody,
            points: Vec::new(),
            weights: [Vec4::ZERO; MAX_POINTS / 4],
            fours: 0,
            certain: vec![0.0; lanes],
            partial: vec![0; lanes / LANES],
            rows: Vec::new(),
            occluder_direction: Vec3::ZERO,
            near_occluder: false,
        }
    }

    /// Forgets what was said: now it is about so many other lanes.
    pub(super) fn restart(&mut self, lanes: usize) {
        self.counted = Sources::Nobody;
        self.certain.clear();
        self.certain.resize(lanes, 0.0);
        self.partial.clear();
        self.partial.resize(lanes / LANES, 0);
    }

    /// Takes that nobody says anything: no light is expected, and none is disputed.
    pub(super) fn clear(&mut self) {
        self.restart(self.certain.len());
        (self.occluder_direction, self.near_occluder) = (Vec3::ZERO, true);
    }

    /// Whether the votes of these corners have been counted.
    #[inline(always)]
    pub(super) fn knows(&self, (visit, mask): (u64, u8)) -> bool {
        self.counted == Sources::Corners(visit, mask)
    }

    /// Takes what corners of a cell say; `index` tells which points they are, `weights` are 0 for other corners.
    #[inline(always)]
    pub(super) fn set_corners(
        &mut self,
        bits: &LightBits,
        (visit, mask): (u64, u8),
        weights: &ByCorner,
        index: impl Fn(usize) -> u32,
    ) {
        if !self.knows((visit, mask)) {
            self.points.clear();
            self.points.extend(corners_of(mask).map(index));
            self.count(bits, corners_of(mask));
            self.counted = Sources::Corners(visit, mask);
        }
        let scale = 1.0 / (weights[0].element_sum() + weights[1].element_sum());
        self.fours = 2;
        self.weights[0] = weights[0] * scale;
        self.weights[1] = weights[1] * scale;
    }

    /// Takes what some points say, each with its weight φ4; of too many the first ones.
    pub(super) fn set_points(&mut self, bits: &LightBits, points: &[(u32, f32)]) {
        let points = &points[..points.len().min(MAX_POINTS)];
        if self.counted != Sources::Listed || !self.points.iter().eq(points.iter().map(|(point, _)| point)) {
            self.points.clear();
            self.points.extend(points.iter().map(|&(point, _)| point));
            self.count(bits, 0..points.len());
            self.counted = Sources::Listed;
        }
        let scale = 1.0 / points.iter().map(|(_, weight)| weight).sum::<f32>();
        self.fours = points.len().div_ceil(4);
        self.weights = [Vec4::ZERO; MAX_POINTS / 4];
        for (i, (_, weight)) in points.iter().enumerate() {
            self.weights[i / 4][i % 4] = weight * scale;
        }
    }

    /// Counts the votes of the points, each of which votes with its own bit.
    pub(crate) fn count(&mut self, bits: &LightBits, places: impl Iterator<Item = usize>) {
        self.rows.clear();
        let mut voters = [(0, 0); MAX_POINTS];
        let voters = &mut voters[..self.points.len()];
        for ((voter, &point), place) in voters.iter_mut().zip(&self.points).zip(places) {
            *voter = (point, place);
        }
        let mut rows = [(0, 0, 0); MAX_POINTS];
        for (word, sure) in self.certain.chunks_mut(64).enumerate() {
            let (mut all, mut any) = (u64::MAX, 0);
            let rows = &mut rows[..voters.len()];
            for (row, &(point, place)) in rows.iter_mut().zip(&*voters) {
                let (seen, open) = bits.rows(point);
                *row = (seen[word], open[word], place);
                all &= seen[word];
                any |= open[word];
            }
            for (bit, sure) in sure.iter_mut().enumerate() {
                *sure = (all >> bit & 1) as f32;
            }
            let disputed = any & !all;
            for (i, block) in self.partial[word * 64 / LANES..].iter_mut().take(64 / LANES).enumerate() {
                *block = (disputed >> (i * LANES)) as u32 & ((1 << LANES) - 1);
            }
            self.rows.extend(set_bits::<64>(disputed).map(|bit| {
                rows.iter().fold((0, 0), |(seen_by, open_to), &(seen, open, place)| {
                    (seen_by | ((seen >> bit & 1) as u32) << place, open_to | ((open >> bit & 1) as u32) << place)
                })
            }));
        }
    }

    /// The lanes of each block about which the points disagree, a bit each. The disputes of the blocks, in this order, are numbered
    /// from 0.
    #[inline(always)]
    pub(crate) fn partial(&self) -> &[u32] {
        &self.partial
    }

    /// V̂ of the light of a dispute: the weighted mean of what the points say, a half for those that cannot tell.
    #[inline(always)]
    pub(crate) fn estimate(&self, dispute: usize) -> f32 {
        let (seen, open) = self.rows[dispute];
        let sum = |voters: u32| -> f32 {
            let four = |i: usize| self.weights[i] * ONES[(voters >> (4 * i) & 15) as usize];
            (0..self.fours).map(four).sum::<Vec4>().element_sum()
        };
        // Most points either see a light or not.
        if seen == open { sum(seen) } else { 0.5 * (sum(seen) + sum(open)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points: both see lane 0, neither lane 1, one lane 2, one lane 3 through glass.
    fn two_points() -> LightBits {
        let mut bits = LightBits::new(16);
        let pack = |v: [f32; 4]| bits.pack(&[0, 1, 2, 3], &v.map(Vec3::splat), &[!0xf]);
        let points = [pack([1.0, 0.0, 1.0, 0.0]), pack([1.0, 0.0, 0.0, 0.4])];
        points.iter().for_each(|point| bits.push(point));
        bits
    }

    #[test]
    fn agreement_is_told_from_dispute() {
        let bits = two_points();
        let mut agreement = VisibilityEstimate::new(16);
        let mut ask = |weights: [f32; 2]| {
            agreement.set_points(&bits, &[(0, weights[0]), (1, weights[1])]);
            [0, 1].map(|i| agreement.estimate(i))
        };
        assert_eq!(ask([3.0, 1.0]), [0.75, 0.125]);
        // The same points again: other weights, the same votes.
        assert_eq!(ask([1.0, 1.0]), [0.5, 0.25]);
        assert_eq!(agreement.partial(), [0b1100]);
        assert_eq!(agreement.certain[..4], [1.0, 0.0, 0.0, 0.0]);
    }

    /// The same two points as corners 1 and 6 of a cell; then corner 6 alone: it sees lane 0 and cannot tell about lane 3.
    #[test]
    fn corners_vote_as_points_do() {
        let bits = two_points();
        let mut agreement = VisibilityEstimate::new(16);
        let index = |k: usize| u32::from(k == 6);
        let weights = [Vec4::new(0.0, 0.3, 0.0, 0.0), Vec4::new(0.0, 0.0, 0.1, 0.0)];
        agreement.set_corners(&bits, (1, 1 << 1 | 1 << 6), &weights, index);
        assert!((agreement.estimate(0) - 0.75).abs() < 1e-6 && (agreement.estimate(1) - 0.125).abs() < 1e-6);
        agreement.set_corners(&bits, (1, 1 << 6), &[Vec4::ZERO, weights[1]], index);
        assert_eq!(agreement.partial(), [0b1000]);
        assert!((agreement.estimate(0) - 0.5).abs() < 1e-6);
        assert_eq!(agreement.certain[..4], [1.0, 0.0, 0.0, 0.0]);
    }
}
