//! The visibility estimate V̂ of each light at a surface, from the states that the mesh points around it have.
//!
//! A light is *certain* where all points agree: all of it arrives at each of them, or none of it. It is *partial* where
//! they differ or one of them cannot tell; V̂ then is the weighted mean over the points. Sets of points are bit masks,
//! in which point i of a list, or corner i of a cell, has bit i.

use glam::{Vec3, Vec4};

use super::encoding::{BitRows, LightBits};
use crate::light::LANES;
use crate::mesh::{ByCorner, ONES, corners_of};
use crate::sampling::set_bits;

/// The most points that make an estimate.
const MAX_POINTS: usize = 32;

/// The visibility of each light by some mesh points. The masks are kept as long as the same points are read.
#[derive(Debug)]
pub(crate) struct VisibilityEstimate {
    /// The points that the masks are of.
    sources: Sources,
    points: Vec<u32>,
    /// φ4 of each point, four by four, in all 1; only as many of them as there are points are used.
    weights: [Vec4; MAX_POINTS / 4],
    /// Fours of weights that are used.
    fours: usize,
    /// By lane: 1 where all points receive the whole of a light, 0 where none receives any or they differ.
    pub certain: Vec<f32>,
    /// By block: the lanes that are partial, a bit each.
    partial: Vec<u32>,
    /// The states of each partial lane, ascending.
    masks: Vec<PointMasks>,
    /// Lights on this side of the surface may be hidden by what hides points there; zero: no point is hidden.
    pub occluder_direction: Vec3,
    /// Whether something stands near the surface, so that all points may miss its shadow.
    pub near_occluder: bool,
}

/// The points that the masks of an estimate are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sources {
    None,
    Corners(CellCorners),
    /// Those in [`VisibilityEstimate::points`].
    Listed,
}

/// Some corners of the cell that a reader is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellCorners {
    /// The reader's visit of the cell: a number for as long as the reader stays there.
    pub visit: u64,
    /// A bit per corner.
    pub mask: u8,
}

/// The states of one light at some points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct PointMasks {
    /// The points at which all of it arrives.
    visible: u32,
    /// The points at which some of it may arrive.
    possible: u32,
}

impl VisibilityEstimate {
    /// An estimate for `lanes` lanes from no points.
    pub(crate) fn new(lanes: usize) -> Self {
        Self {
            sources: Sources::None,
            points: Vec::new(),
            weights: [Vec4::ZERO; MAX_POINTS / 4],
            fours: 0,
            certain: vec![0.0; lanes],
            partial: vec![0; lanes / LANES],
            masks: Vec::new(),
            occluder_direction: Vec3::ZERO,
            near_occluder: false,
        }
    }

    /// Starts anew with `lanes` other lanes.
    pub(super) fn restart(&mut self, lanes: usize) {
        self.sources = Sources::None;
        self.certain.clear();
        self.certain.resize(lanes, 0.0);
        self.partial.clear();
        self.partial.resize(lanes / LANES, 0);
    }

    /// Makes it an estimate from no points: every light is certain to be hidden.
    pub(super) fn clear(&mut self) {
        self.restart(self.certain.len());
        (self.occluder_direction, self.near_occluder) = (Vec3::ZERO, true);
    }

    /// Returns whether the masks are those of these corners.
    #[inline(always)]
    pub(super) fn is_from(&self, corners: CellCorners) -> bool {
        self.sources == Sources::Corners(corners)
    }

    /// Estimates from corners of a cell; `index` gives the points that they are, `weights` are 0 for other corners.
    #[inline(always)]
    pub(super) fn set_corners(
        &mut self,
        bits: &LightBits,
        corners: CellCorners,
        weights: &ByCorner,
        index: impl Fn(usize) -> u32,
    ) {
        // Compare the points if they are others, and scale the weights to a sum of 1.
        if !self.is_from(corners) {
            self.points.clear();
            self.points.extend(corners_of(corners.mask).map(index));
            self.compare(bits, corners_of(corners.mask));
            self.sources = Sources::Corners(corners);
        }
        let scale = 1.0 / (weights[0].element_sum() + weights[1].element_sum());
        self.fours = 2;
        self.weights[0] = weights[0] * scale;
        self.weights[1] = weights[1] * scale;
    }

    /// Estimates from some points, each with its weight φ4; of too many the first ones.
    pub(super) fn set_points(&mut self, bits: &LightBits, points: &[(u32, f32)]) {
        // Compare the points if they are others, and scale the weights to a sum of 1.
        let points = &points[..points.len().min(MAX_POINTS)];
        if self.sources != Sources::Listed || !self.points.iter().eq(points.iter().map(|(point, _)| point)) {
            self.points.clear();
            self.points.extend(points.iter().map(|&(point, _)| point));
            self.compare(bits, 0..points.len());
            self.sources = Sources::Listed;
        }
        let scale = 1.0 / points.iter().map(|(_, weight)| weight).sum::<f32>();
        self.fours = points.len().div_ceil(4);
        self.weights = [Vec4::ZERO; MAX_POINTS / 4];
        for (i, (_, weight)) in points.iter().enumerate() {
            self.weights[i / 4][i % 4] = weight * scale;
        }
    }

    /// Finds the lanes that are certain and the masks of the others. `mask_bits` has the bit of each point.
    fn compare(&mut self, bits: &LightBits, mask_bits: impl Iterator<Item = usize>) {
        self.masks.clear();
        let mut points = [(0, 0); MAX_POINTS];
        let points = &mut points[..self.points.len()];
        for ((point, &index), mask_bit) in points.iter_mut().zip(&self.points).zip(mask_bits) {
            *point = (index, mask_bit);
        }
        let mut words = [(0, 0, 0); MAX_POINTS];
        for (word, certain) in self.certain.chunks_mut(64).enumerate() {
            // Compare 64 lanes of all points at once.
            let (mut all, mut any) = (u64::MAX, 0);
            let words = &mut words[..points.len()];
            for (words, &(index, mask_bit)) in words.iter_mut().zip(&*points) {
                let BitRows { visible, possible } = bits.rows(index);
                *words = (visible[word], possible[word], mask_bit);
                all &= visible[word];
                any |= possible[word];
            }
            for (bit, certain) in certain.iter_mut().enumerate() {
                *certain = (all >> bit & 1) as f32;
            }
            let partial = any & !all;
            for (i, block) in self.partial[word * 64 / LANES..].iter_mut().take(64 / LANES).enumerate() {
                *block = (partial >> (i * LANES)) as u32 & ((1 << LANES) - 1);
            }

            // Transpose the partial lanes: the points' bits of one lane become a mask.
            self.masks.extend(set_bits::<64>(partial).map(|bit| {
                words.iter().fold(PointMasks::default(), |masks, &(visible, possible, mask_bit)| PointMasks {
                    visible: masks.visible | ((visible >> bit & 1) as u32) << mask_bit,
                    possible: masks.possible | ((possible >> bit & 1) as u32) << mask_bit,
                })
            }));
        }
    }

    /// Returns the partial lanes of each block, a bit each. In the order of blocks and lanes they are numbered from 0.
    #[inline(always)]
    pub(crate) fn partial(&self) -> &[u32] {
        &self.partial
    }

    /// Returns V̂ of the light of a partial lane, by its number: the weighted mean over the points, a half for those
    /// that cannot tell.
    #[inline(always)]
    pub(crate) fn estimate(&self, number: usize) -> f32 {
        let PointMasks { visible, possible } = self.masks[number];
        let sum = |points: u32| -> f32 {
            let four = |i: usize| self.weights[i] * ONES[(points >> (4 * i) & 15) as usize];
            (0..self.fours).map(four).sum::<Vec4>().element_sum()
        };
        // Most points either see a light or not.
        if visible == possible { sum(visible) } else { 0.5 * (sum(visible) + sum(possible)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points: both see lane 0, neither lane 1, one lane 2, one lane 3 through glass.
    fn two_points() -> LightBits {
        let mut bits = LightBits::with_padding(16, vec![!0xf]);
        let pack = |v: [f32; 4]| bits.pack(&[0, 1, 2, 3], &v.map(Vec3::splat));
        let points = [pack([1.0, 0.0, 1.0, 0.0]), pack([1.0, 0.0, 0.0, 0.4])];
        points.iter().for_each(|point| bits.push(point));
        bits
    }

    #[test]
    fn lanes_on_which_points_differ_are_partial() {
        let bits = two_points();
        let mut estimate = VisibilityEstimate::new(16);
        let mut estimates = |weights: [f32; 2]| {
            estimate.set_points(&bits, &[(0, weights[0]), (1, weights[1])]);
            [0, 1].map(|i| estimate.estimate(i))
        };
        assert_eq!(estimates([3.0, 1.0]), [0.75, 0.125]);
        // The same points again: other weights, the same masks.
        assert_eq!(estimates([1.0, 1.0]), [0.5, 0.25]);
        assert_eq!(estimate.partial(), [0b1100]);
        assert_eq!(estimate.certain[..4], [1.0, 0.0, 0.0, 0.0]);
    }

    /// The same two points as corners 1 and 6 of a cell; then corner 6 alone: it sees lane 0 and cannot tell about lane
    /// 3.
    #[test]
    fn corners_give_the_same_estimate_as_points() {
        let bits = two_points();
        let mut estimate = VisibilityEstimate::new(16);
        let index = |k: usize| u32::from(k == 6);
        let weights = [Vec4::new(0.0, 0.3, 0.0, 0.0), Vec4::new(0.0, 0.0, 0.1, 0.0)];
        estimate.set_corners(&bits, CellCorners { visit: 1, mask: 1 << 1 | 1 << 6 }, &weights, index);
        assert!((estimate.estimate(0) - 0.75).abs() < 1e-6 && (estimate.estimate(1) - 0.125).abs() < 1e-6);
        estimate.set_corners(&bits, CellCorners { visit: 1, mask: 1 << 6 }, &[Vec4::ZERO, weights[1]], index);
        assert_eq!(estimate.partial(), [0b1000]);
        assert!((estimate.estimate(0) - 0.5).abs() < 1e-6);
        assert_eq!(estimate.certain[..4], [1.0, 0.0, 0.0, 0.0]);
    }
}
