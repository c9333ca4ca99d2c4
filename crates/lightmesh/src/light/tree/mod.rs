//! A hierarchy over light samples: groups of lights that one light stands for, and how far wrong it can be.
//!
//! After Walter et al., "Lightcuts: A Scalable Approach to Illumination" (SIGGRAPH 2005): a binary tree over the lights; a *cut*
//! through it is a set of nodes that holds every light once. What differs:
//!
//! - A cluster shines from the mean place of its lights, weighted by their strength, and not from one of them: the first order
//!   of the error vanishes and the second can be bounded, as in Barnes and Hut's method (Nature 324, 1986).
//! - Bounds are for boxes of receivers, so that all surface points of a region share a cut, and hold for the mean over all
//!   normals (`bound.rs`), so that a region needs one cut whatever surfaces are in it.
//! - A cut is refined until the sum of the bounds is below the part ε of all light that arrives (`cut.rs`). Lightcuts asks for each bound
//!   alone to be below ε of it and says nothing of the sum.
//!
//! Trees of several kinds, one beside the other: even point lights, patches that shine from one side, from both, spots and ranges,
//! directions. A node's strength is Σ_i (R + G + B) of its lights: errors are of all channels together.

pub(crate) mod bound;
mod build;
pub(crate) mod cut;
mod moments;
#[cfg(test)]
mod tests;

use std::ops::Range;

use glam::Vec3;

use super::sample::SampledLight;
use super::samples::LightSamples;

/// The trees over the samples of a scene.
#[derive(Debug)]
pub(crate) struct LightTree {
    nodes: Vec<Node>,
    /// By node: the light that stands for it; a leaf's is its sample.
    luminaires: Vec<SampledLight>,
    /// By node less `first_oriented`: of patches, spots and ranges.
    orientations: Vec<Orientation>,
    first_oriented: usize,
    /// Nodes from this one on are of directions.
    first_direction: u32,
    roots: Vec<u32>,
    /// Lanes of the samples, in the order of the leaves, and the sums of their strengths up to and with each.
    lanes: Vec<u32>,
    sums: Vec<f64>,
}

/// Lights that shine alike, in the order of their trees: that of the blocks of [`LightSamples`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Even,
    OneSided,
    TwoSided,
    Shaped,
    Direction,
}

/// Some lights of one kind.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// The box around their places, metres.
    min: Vec3,
    max: Vec3,
    /// Their mean place by strength.
    place: Vec3,
    /// Σ (R + G + B), candela; lux for directions.
    strength: f32,
    /// Mean squared distance from `place` by strength, m².
    variance: f32,
    /// Σ over channels of |Σ_i I_i (x_i − place)|: how far the colours' own means are off, cd m. Of directions the whole error, lux.
    colour: f32,
    /// The first of its two children, the other follows; 0: a leaf.
    child: u32,
    /// Its lights in the order of the leaves.
    first: u32,
    count: u32,
    kind: Kind,
}

/// Which way the lights of a node shine, and how much they differ.
#[derive(Clone, Copy, Debug)]
struct Orientation {
    /// Unit; the mean of the ways they shine.
    axis: Vec3,
    /// Cosine and sine of the largest angle between an axis and the mean; a half turn is (−1, 0).
    cone: (f32, f32),
    /// Root of the mean squared difference from the mean axis, by strength.
    deviation: f32,
    /// Σ over channels of |Σ_i I_i (a_i − a)|, candela.
    colour: f32,
    shape: ConeStatistics,
}

/// Extremes over the lights of a node.
#[derive(Clone, Copy, Debug)]
enum ConeStatistics {
    /// A / π, m².
    Patch { least: f32, most: f32 },
    /// Cosines of the cones' edges (−2 and below: no cone), the largest scale, how much scale and offset differ in all; 1 / R².
    Spot { inner: (f32, f32), outer: f32, scale: f32, difference: f32, inv_range2: (f32, f32) },
}

impl LightTree {
    /// Memory of the trees over some samples while they are built, bytes: two nodes a light, and the lights once more.
    pub(crate) fn bytes(samples: &LightSamples) -> u64 {
        let node = size_of::<Node>() + size_of::<SampledLight>() + size_of::<Orientation>();
        (samples.len() * (2 * node + size_of::<SampledLight>() + 32)) as u64
    }

    /// How many lights there are.
    pub(crate) fn len(&self) -> usize {
        self.lanes.len()
    }

    /// Fills `lights` with what stands for the nodes of a cut; `nodes` gets the node of each lane, [`LightTree::NO_NODE`] for padding.
    pub(crate) fn pack(&self, cut: &[u32], lights: &mut LightSamples, nodes: &mut Vec<u32>) {
        lights.clear();
        nodes.clear();
        for &node in cut {
            let lane = lights.push(&self.luminaires[node as usize]);
            nodes.resize(lane, Self::NO_NODE);
            nodes.push(node);
        }
        nodes.resize(lights.lanes(), Self::NO_NODE);
    }

    pub(crate) const NO_NODE: u32 = u32::MAX;

    /// Whether a node is one light and not a cluster.
    pub(crate) fn is_single(&self, node: u32) -> bool {
        self.nodes[node as usize].child == 0
    }

    /// The lights of a node, in the order of the leaves. Those of a cut ascend, and do not overlap.
    pub(crate) fn leaves(&self, node: u32) -> Range<u32> {
        let Node { first, count, .. } = self.nodes[node as usize];
        first..first + count
    }

    /// How far a node's box reaches from its mean place, metres.
    pub(crate) fn radius(&self, node: u32) -> f32 {
        let (node, place) = (&self.nodes[node as usize], self.luminaires[node as usize].position);
        (node.max - place).max(place - node.min).length()
    }

    /// The lane of one of a node's samples, chosen in proportion to strength by `u` in [0, 1), and its probability.
    pub(crate) fn choose(&self, node: u32, u: f32) -> (usize, f32) {
        let (place, before, total) = self.place_of(node, u);
        let probability = (self.sums[place] - if place > 0 { self.sums[place - 1] } else { 0.0 }) / (total - before);
        (self.lanes[place] as usize, probability as f32)
    }

    /// The lane of [`LightTree::choose`].
    pub(crate) fn representative(&self, node: u32, u: f32) -> usize {
        self.lanes[self.place_of(node, u).0] as usize
    }

    /// One of a node's samples, in the order of the leaves; the sums of strengths before the node and with it.
    fn place_of(&self, node: u32, u: f32) -> (usize, f64, f64) {
        let Node { first, count, .. } = self.nodes[node as usize];
        let (first, last) = (first as usize, (first + count) as usize - 1);
        let before = if first > 0 { self.sums[first - 1] } else { 0.0 };
        let target = before + f64::from(u) * (self.sums[last] - before);
        let place = self.sums[first..last].partition_point(|&sum| sum <= target);
        (first + place, before, self.sums[last])
    }
}
