//! A hierarchy over light samples: clusters of lights that one light represents, with a bound on the error of that.
//!
//! After Walter et al., "Lightcuts: A Scalable Approach to Illumination" (SIGGRAPH 2005): a binary tree over the
//! lights; a *cut* through it is a set of nodes that holds every light once. What differs:
//!
//! - A cluster shines from the mean position of its lights, weighted by their strength, and not from one of them: the
//!   first order of the error vanishes and the second can be bounded, as in Barnes and Hut's method (Nature 324, 1986).
//! - Bounds are for boxes of receivers, so that all surface points of a region share a cut. They hold for the mean over
//!   all normals (`bound.rs`), so that a region needs one cut whatever surfaces are in it.
//! - A cut is refined until the sum of the bounds is below the part ε of all light that arrives (`cut.rs`). Lightcuts
//!   bounds each cluster's error alone by ε of it, and does not bound the sum.
//!
//! There is a tree for each kind of light: isotropic points, patches that shine from one side, patches that shine from
//! both, spots and ranges, directional lights. A node's strength is Σ_i (R + G + B) of its lights: errors are of all
//! channels together.

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
    /// By node: the light that represents it; a leaf's is its sample.
    representatives: Vec<SampledLight>,
    /// By node less `first_oriented`: of patches and spots.
    orientations: Vec<Orientation>,
    first_oriented: usize,
    /// Nodes from this one on are of directional lights.
    first_direction: u32,
    roots: Vec<u32>,
    /// Lanes of the samples, in the order of the leaves, and the sums of their strengths up to and with each.
    lanes: Vec<u32>,
    sums: Vec<f64>,
}

/// Lights of one emission, in the order of their trees, which is that of the blocks of [`LightSamples`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Isotropic,
    OneSided,
    TwoSided,
    Spot,
    Directional,
}

/// A cluster of lights of one kind, or one light.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// The box around their positions, metres.
    min: Vec3,
    max: Vec3,
    /// Their mean position, weighted by strength.
    mean: Vec3,
    /// Σ (R + G + B), candela; lux for directional lights.
    strength: f32,
    /// Mean squared distance from `mean`, weighted by strength, m².
    variance: f32,
    /// Σ over channels of |Σ_i I_i (x_i − mean)|, cd m: the means of the channels differ. The whole error of
    /// directional lights, lux.
    chromatic_error: f32,
    /// The first of its two children, the other follows; 0: a leaf.
    child: u32,
    /// Its lights in the order of the leaves.
    first: u32,
    count: u32,
    kind: Kind,
}

/// The directions in which the lights of a node shine, and how much they differ.
#[derive(Clone, Copy, Debug)]
struct Orientation {
    /// Unit; the mean direction in which they shine.
    axis: Vec3,
    /// The largest angle between an axis and the mean.
    cone: HalfAngle,
    /// Root of the mean squared difference from the mean axis, weighted by strength.
    deviation: f32,
    /// Σ over channels of |Σ_i I_i (a_i − a)|, candela.
    chromatic_error: f32,
    statistics: ConeStatistics,
}

/// An angle from 0 to π.
#[derive(Clone, Copy, Debug)]
struct HalfAngle {
    cos: f32,
    sin: f32,
}

/// The extremes of a number over the lights of a node.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    least: f32,
    most: f32,
}

impl Extremes {
    fn width(self) -> f32 {
        self.most - self.least
    }
}

/// What the bounds need to know of the emission of a node's lights.
#[derive(Clone, Copy, Debug)]
enum ConeStatistics {
    Patch {
        /// A / π, m².
        area_over_pi: Extremes,
    },
    Spot {
        /// Cosines of the cones' inner edges; −2 without a cone.
        inner: Extremes,
        /// The least cosine of the cones' outer edges; −2 without a cone.
        outer: f32,
        /// The largest scale.
        scale: f32,
        /// How much scales and offsets differ in all.
        difference: f32,
        /// 1 / R².
        inv_range2: Extremes,
    },
}

/// A leaf of a node, chosen by strength.
struct ChosenLeaf {
    /// Its index in the order of the leaves.
    leaf: usize,
    /// The sum of strengths before the node.
    before: f64,
    /// The same, with the node's.
    after: f64,
}

impl LightTree {
    /// Returns the memory that building the trees over some samples takes, bytes: two nodes for each light, and the
    /// lights once more.
    pub(crate) fn bytes(samples: &LightSamples) -> u64 {
        let node = size_of::<Node>() + size_of::<SampledLight>() + size_of::<Orientation>();
        (samples.len() * (2 * node + size_of::<SampledLight>() + 32)) as u64
    }

    /// How many lights there are.
    pub(crate) fn len(&self) -> usize {
        self.lanes.len()
    }

    /// Fills `lights` with the representatives of a cut's nodes, and `nodes` with the node of each lane,
    /// [`LightTree::NO_NODE`] for padding.
    pub(crate) fn pack(&self, cut: &[u32], lights: &mut LightSamples, nodes: &mut Vec<u32>) {
        lights.clear();
        nodes.clear();
        for &node in cut {
            let lane = lights.push(&self.representatives[node as usize]);
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

    /// Returns how far a node's box reaches from its representative, metres.
    pub(crate) fn radius(&self, node: u32) -> f32 {
        let (node, position) = (&self.nodes[node as usize], self.representatives[node as usize].position);
        (node.max - position).max(position - node.min).length()
    }

    /// Chooses one of a node's samples in proportion to strength, by `u` in [0, 1). Returns its lane and its
    /// probability.
    pub(crate) fn choose(&self, node: u32, u: f32) -> (usize, f32) {
        let ChosenLeaf { leaf, before, after } = self.find_leaf(node, u);
        let probability = (self.sums[leaf] - if leaf > 0 { self.sums[leaf - 1] } else { 0.0 }) / (after - before);
        (self.lanes[leaf] as usize, probability as f32)
    }

    /// Returns the lane of [`LightTree::choose`] alone.
    pub(crate) fn representative(&self, node: u32, u: f32) -> usize {
        self.lanes[self.find_leaf(node, u).leaf] as usize
    }

    /// Finds the leaf of a node at which the sum of strengths passes the part `u` of the node's.
    fn find_leaf(&self, node: u32, u: f32) -> ChosenLeaf {
        let Node { first, count, .. } = self.nodes[node as usize];
        let (first, last) = (first as usize, (first + count) as usize - 1);
        let before = if first > 0 { self.sums[first - 1] } else { 0.0 };
        let target = before + f64::from(u) * (self.sums[last] - before);
        let leaf = first + self.sums[first..last].partition_point(|&sum| sum <= target);
        ChosenLeaf { leaf, before, after: self.sums[last] }
    }
}
