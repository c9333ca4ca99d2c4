//! The lights of one region, nodes of its cut, and what mesh points say of them, kept while surfaces ask from the same region.

use std::collections::HashMap;
use std::ops::Range;

use glam::Vec3;

use super::region_cuts::{Region, RegionCuts};
use super::visibility_bits::LightBits;
use super::visibility_estimate::VisibilityEstimate;
use super::visibility_runs::LightRuns;
use crate::Falloff;
use crate::light::{LightSamples, LightTree, Refinement};

/// The lights around a surface and what mesh points know of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightCutVisibility<'a> {
    /// Every sample, or what stands for the nodes of a cut.
    pub lights: &'a LightSamples,
    /// Which of their lanes are clusters, if any are.
    pub clusters: Option<Clusters<'a>>,
    /// About these lanes.
    pub estimate: &'a VisibilityEstimate,
}

/// Lanes that stand for many lights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clusters<'a> {
    tree: &'a LightTree,
    /// By lane: the node of the tree.
    nodes: &'a [u32],
    /// By lane, 0 for single lights: what of a cluster's light (lux, mean over the channels) to reckon with at a surface that its mean
    /// place does not shine on, and how far its lights are from that place, metres.
    pub least: &'a [f32],
    pub radii: &'a [f32],
}

impl Clusters<'_> {
    /// The node of a lane, if that is a cluster.
    #[inline(always)]
    pub(crate) fn node(&self, lane: usize) -> Option<u32> {
        let node = self.nodes[lane];
        (!self.tree.is_single(node)).then_some(node)
    }

    /// How many lights a node has.
    pub(crate) fn count(&self, node: u32) -> u32 {
        self.tree.leaves(node).len() as u32
    }

    /// The lane among all samples of one of a node's, by `u` in [0, 1), and its probability.
    pub(crate) fn choose(&self, node: u32, u: f32) -> (usize, f32) {
        self.tree.choose(node, u)
    }
}

/// [`Clusters::least`] in units of the light that arrives at a surface that faces a cluster, times the cluster's radius over its
/// distance. A plane that cuts a cluster sees its lights at cosines up to twice that ratio; some must be reckoned with wherever light
/// may arrive, or what is chosen by light would have a bias. Empirical, not varied.
const LEAST: f32 = 0.125;

/// That ratio is at least this: lights at one place may shine in different ways.
const LEAST_RATIO: f32 = 0.02;

/// The lights of the region that was asked for last; buffers are kept from region to region.
#[derive(Debug)]
pub(super) struct RegionVisibility<'a> {
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
    /// What points say of the lanes, and where, by the point's index.
    bits: LightBits,
    rows: HashMap<u32, u32>,
}

impl<'a> RegionVisibility<'a> {
    /// `None` where there are no regions.
    pub(crate) fn new(regions: &'a RegionCuts, falloff: Falloff) -> Option<Self> {
        let tree = regions.tree()?;
        Some(Self {
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
            bits: LightBits::new(0),
            rows: HashMap::new(),
        })
    }

    /// Looks from a place; how many lanes there are, if it is in another region than the last one.
    #[inline(always)]
    pub(super) fn enter(&mut self, place: Vec3) -> Option<usize> {
        let region = self.regions.region(place);
        if self.region == Some(region) {
            return None;
        }
        self.region = Some(region);
        self.pack(region);
        Some(self.lights.lanes())
    }

    #[inline(never)]
    fn pack(&mut self, region: Region) {
        let Self { regions, tree, falloff, refinement, cut, lights, nodes, least, radii, leaves, .. } = self;
        tree.pack(regions.cut(region, *falloff, refinement, cut), lights, nodes);
        leaves.clear();
        for array in [&mut *least, &mut *radii] {
            array.clear();
            array.resize(nodes.len(), 0.0);
        }
        let centre = regions.centre(region);
        for (lane, &node) in nodes.iter().enumerate().filter(|(_, node)| **node != LightTree::NO_NODE) {
            leaves.push((lane as u32, tree.leaves(node)));
            if !tree.is_single(node) {
                let (radius, (r, arriving)) = (tree.radius(node), tree.facing(node, *falloff, centre));
                least[lane] = LEAST / 3.0 * arriving * (radius / r).clamp(LEAST_RATIO, 1.0);
                radii[lane] = radius;
            }
        }
        self.bits.restart(lights.lanes());
        self.rows.clear();
    }

    /// Where [`RegionVisibility::bits`] has what a point says.
    pub(super) fn row(&mut self, runs: &LightRuns, point: u32) -> u32 {
        let next = self.rows.len() as u32;
        let row = *self.rows.entry(point).or_insert(next);
        if row == next {
            let lanes = self.leaves.iter().map(|(lane, _)| *lane as usize);
            let states = runs.ask(point, self.leaves.iter().map(|(_, leaves)| leaves.clone()));
            self.bits.push_states(lanes.zip(states));
        }
        row
    }

    /// What points say of the lanes of the region.
    pub(crate) fn bits(&self) -> &LightBits {
        &self.bits
    }

    /// The region's lights, with what is known of them.
    pub(super) fn visibility<'b>(&'b self, agreement: &'b VisibilityEstimate) -> LightCutVisibility<'b> {
        let Self { tree, lights, nodes, least, radii, .. } = self;
        LightCutVisibility { lights, clusters: Some(Clusters { tree, nodes, least, radii }), estimate: agreement }
    }
}
