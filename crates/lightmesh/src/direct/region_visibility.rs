//! The lights of one region, nodes of its cut, and their states at mesh points, kept while surfaces are in the same
//! region.

use std::collections::HashMap;
use std::ops::Range;

use glam::Vec3;

use super::encoding::{LightBits, LightRuns};
use super::region_cuts::{Region, RegionCuts};
use super::visibility_estimate::VisibilityEstimate;
use crate::Falloff;
use crate::light::{LightSamples, LightTree, Refinement};

/// The lights at a surface and their visibility estimate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightCutVisibility<'a> {
    /// Every sample, or one for each node of a cut.
    pub lights: &'a LightSamples,
    /// Which of their lanes are clusters, if any are.
    pub clusters: Option<Clusters<'a>>,
    /// Has the same lanes.
    pub estimate: &'a VisibilityEstimate,
}

/// Lanes that stand for many lights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clusters<'a> {
    tree: &'a LightTree,
    /// By lane: the node of the tree.
    nodes: &'a [u32],
    /// By lane, 0 for single points: the least light to expect of a cluster (lux, mean over the channels) at a surface
    /// that its mean position does not shine on.
    pub least: &'a [f32],
    /// By lane, 0 for single points: how far a cluster's lights are from its mean position, metres.
    pub radii: &'a [f32],
}

/// One of the scene's light samples, chosen from a cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClusterLight {
    /// Its lane among all samples.
    pub lane: usize,
    /// The probability of the choice.
    pub p: f32,
}

impl Clusters<'_> {
    /// Returns the node of a lane, if that is a cluster.
    #[inline(always)]
    pub(super) fn node(&self, lane: usize) -> Option<u32> {
        let node = self.nodes[lane];
        (!self.tree.is_single(node)).then_some(node)
    }

    /// Returns the lane among all samples of a lane that is no cluster.
    #[inline(always)]
    pub(super) fn sample(&self, lane: usize) -> usize {
        self.tree.representative(self.nodes[lane], 0.0)
    }

    /// Returns how many lights a node has.
    pub(super) fn count(&self, node: u32) -> u32 {
        self.tree.leaves(node).len() as u32
    }

    /// Chooses one of a node's lights by `u` in [0, 1).
    pub(super) fn choose(&self, node: u32, u: f32) -> ClusterLight {
        let (lane, p) = self.tree.choose(node, u);
        ClusterLight { lane, p }
    }
}

/// [`Clusters::least`] in units of the light that arrives at a surface that faces a cluster, times the cluster's radius
/// over its distance. A plane that cuts a cluster receives its lights at cosines up to twice that ratio; some must be
/// expected wherever light may arrive, or sampling in proportion to the light would have a bias. Empirical, not varied.
const LEAST: f32 = 0.125;

/// That ratio is at least this: lights at one position may shine in different ways.
const LEAST_RATIO: f32 = 0.02;

/// The lights of the last region; buffers are kept from region to region.
#[derive(Debug)]
pub(super) struct RegionVisibility<'a> {
    samples: &'a LightSamples,
    regions: &'a RegionCuts,
    tree: &'a LightTree,
    falloff: Falloff,
    region: Option<Region>,
    refinement: Refinement,
    cut: Vec<u32>,
    lights: LightSamples,
    nodes: Vec<u32>,
    least: Vec<f32>,
    radii: Vec<f32>,
    /// By node of the cut: its lane, and its lights in the order of the leaves.
    leaves: Vec<(u32, Range<u32>)>,
    /// The states of the lanes at mesh points, and the row of each point, by its index.
    bits: LightBits,
    rows: HashMap<u32, u32>,
}

impl<'a> RegionVisibility<'a> {
    /// No region yet; `None` where lights are not clusters.
    pub(crate) fn new(samples: &'a LightSamples, regions: &'a RegionCuts, falloff: Falloff) -> Option<Self> {
        let tree = regions.tree()?;
        Some(Self {
            samples,
            regions,
            tree,
            falloff,
            region: None,
            refinement: Refinement::default(),
            cut: Vec::new(),
            lights: LightSamples::default(),
            nodes: Vec::new(),
            least: Vec::new(),
            radii: Vec::new(),
            leaves: Vec::new(),
            bits: LightBits::default(),
            rows: HashMap::new(),
        })
    }

    /// Enters the region of a position; returns the number of its lanes, if it is another one than the last.
    #[inline(always)]
    pub(super) fn enter(&mut self, position: Vec3) -> Option<usize> {
        let region = self.regions.region(position);
        if self.region == Some(region) {
            return None;
        }
        self.region = Some(region);
        self.pack(region);
        Some(self.lights.lanes())
    }

    /// Packs the lights of a region, and forgets the states of the last one.
    #[inline(never)]
    fn pack(&mut self, region: Region) {
        let Self { samples, regions, tree, falloff, refinement, cut, lights, nodes, least, radii, leaves, .. } = self;
        // Pack the nodes of the cut, and list their leaves.
        tree.pack(regions.cut(region, *falloff, refinement, cut), lights, nodes);
        leaves.clear();
        for array in [&mut *least, &mut *radii] {
            array.clear();
            array.resize(nodes.len(), 0.0);
        }
        let centre = regions.centre(region);
        for (lane, &node) in nodes.iter().enumerate().filter(|(_, node)| **node != LightTree::NO_NODE) {
            leaves.push((lane as u32, tree.leaves(node)));
            // Expect some light of a cluster wherever it may arrive.
            if !tree.is_single(node) {
                let (radius, (r, arriving)) =
                    (tree.radius(node), tree.distance_and_illuminance(node, *falloff, centre));
                least[lane] = LEAST / 3.0 * arriving * (radius / r).clamp(LEAST_RATIO, 1.0);
                radii[lane] = radius;
            } else if samples.has_strata() {
                let radius = samples.radius(tree.representative(node, 0.0));
                let (r, arriving) = tree.distance_and_illuminance(node, *falloff, centre);
                least[lane] =
                    if radius > 0.0 { LEAST / 3.0 * arriving * (radius / r).clamp(LEAST_RATIO, 1.0) } else { 0.0 };
                radii[lane] = radius;
            }
        }
        self.bits.restart(lights.lanes());
        self.rows.clear();
    }

    /// Returns the row of [`RegionVisibility::bits`] that has the states at a point.
    pub(super) fn row(&mut self, runs: &LightRuns, point: u32) -> u32 {
        let next = self.rows.len() as u32;
        let row = *self.rows.entry(point).or_insert(next);
        if row == next {
            let lanes = self.leaves.iter().map(|(lane, _)| *lane as usize);
            let states = runs.states(point, self.leaves.iter().map(|(_, leaves)| leaves.clone()));
            self.bits.push_states(lanes.zip(states));
        }
        row
    }

    /// Returns the states of the region's lanes at mesh points.
    pub(crate) fn bits(&self) -> &LightBits {
        &self.bits
    }

    /// Returns the region's lights with an estimate of their visibility.
    pub(super) fn visibility<'b>(&'b self, estimate: &'b VisibilityEstimate) -> LightCutVisibility<'b> {
        let Self { tree, lights, nodes, least, radii, .. } = self;
        LightCutVisibility { lights, clusters: Some(Clusters { tree, nodes, least, radii }), estimate }
    }
}
