//! The lights of one receiver: every sample, or a cut through the tree over many of them with a shadow ray for each of
//! its nodes.

use std::ops::Range;

use glam::Vec3;

use super::samples::LightSamples;
use super::tree::LightTree;
use super::tree::bound::Receivers;
use super::tree::cut::{Refinement, Tolerance};
use crate::Falloff;
use crate::geometry::Ray;
use crate::sampling::{hash, seed_of_position, unit_f32};

/// [`Tolerance::shadows`] of clusters: ½ if every cluster were half hidden. Empirical: docs/many-lights.md has the noise
/// and the time of 0 to 0.4.
const SHADOWS: f32 = 0.3;

/// The lights of a receiver and the shadow rays to them; buffers are kept from receiver to receiver.
#[derive(Debug)]
pub(crate) struct LightCut<'a> {
    samples: &'a LightSamples,
    tree: Option<(&'a LightTree, Tolerance)>,
    refinement: Refinement,
    cut: Vec<u32>,
    clusters: LightSamples,
    /// By lane of `clusters`: the node of the tree.
    nodes: Vec<u32>,
    seed: u32,
}

impl<'a> LightCut<'a> {
    /// All samples for every receiver.
    pub(crate) fn all(samples: &'a LightSamples) -> Self {
        Self {
            samples,
            tree: None,
            refinement: Refinement::default(),
            cut: Vec::new(),
            clusters: LightSamples::default(),
            nodes: Vec::new(),
            seed: 0,
        }
    }

    /// Cuts through the tree over `samples`, with an error of at most the part `error` of the light.
    pub(crate) fn cut(samples: &'a LightSamples, tree: &'a LightTree, error: f32) -> Self {
        Self { tree: Some((tree, Tolerance { error, shadows: SHADOWS })), ..Self::all(samples) }
    }

    /// Chooses the cut of a receiver.
    pub(crate) fn set_receiver(&mut self, x: Vec3, falloff: Falloff) {
        let Some((tree, tolerance)) = self.tree else { return };
        tree.cut(&Receivers::at(x), falloff, tolerance, &mut self.refinement, &mut self.cut);
        tree.pack(&self.cut, &mut self.clusters, &mut self.nodes);
        self.seed = seed_of_position(x);
    }

    /// The lights of the receiver.
    pub(crate) fn lights(&self) -> &LightSamples {
        if self.tree.is_some() { &self.clusters } else { self.samples }
    }

    /// Returns the lights of the tree that a lane represents, in the order of its leaves; all of them where there is no
    /// tree.
    pub(crate) fn leaves(&self, lane: usize) -> Range<u32> {
        self.tree.map_or(0..self.samples.len() as u32, |(tree, _)| tree.leaves(self.nodes[lane]))
    }

    /// Returns the shadow ray from a point at or near the receiver to a lane's light. Of a cluster it goes to one of
    /// its samples, chosen in proportion to their strength. Neighbouring receivers choose independently, so that the
    /// mean over them samples the whole cluster. (Eighths of each cluster for the eight points around a cell had as
    /// much noise.)
    pub(crate) fn shadow_ray(&self, lane: usize, from: Vec3) -> Ray {
        let Some((tree, _)) = self.tree else { return self.samples.shadow_ray(lane, from) };
        let node = self.nodes[lane];
        let u = unit_f32(hash(self.seed ^ hash(node)));
        self.samples.shadow_ray(tree.representative(node, u), from)
    }
}
