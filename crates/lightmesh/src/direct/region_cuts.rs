//! Unshadowed light from many lights: regions of space, each with a cut through the light tree that all surface points
//! in it share.
//!
//! A region is a cell of a regular grid over the mesh's focus, or over the scene's box; away from the focus cells grow as
//! the mesh's do. Its cut depends on region, scene and settings alone; it
//! is made when a surface first needs it, and kept as node numbers, 4 B each: lights are packed into blocks when they
//! are used, once for all vertices of a wave that lie in the region.

use std::collections::HashMap;

use glam::Vec3;
use rayon::prelude::*;

use super::encoding::MOST_LEAVES;
use crate::light::{LightCut, LightSamples, LightTree, Receivers, Refinement, Tolerance};
use crate::mesh::Focus;
use crate::{Error, Falloff, RenderOptions, Scene};

/// Up to this number of samples, light is summed one by one: that takes less time than a cut through more would.
const FEW: usize = 512;

/// Regions along the longest edge of the box.
const REGIONS: f32 = 40.0;

/// Surface points summed at a time where there are no regions.
const CHUNK: usize = 512;

/// Of the memory that a render may take, the part that cuts may keep; further ones are made anew each time.
const KEPT_PART: u64 = 8;

/// The lights of a scene for a mesh: all of them, or a tree and cuts through it.
#[derive(Debug)]
pub(crate) struct RegionCuts {
    tree: Option<LightTree>,
    /// [`TransportOptions::light_error`](crate::TransportOptions::light_error).
    error: f32,
    /// A corner of a region near the focus, and its edge, metres.
    origin: Vec3,
    edge: f32,
    focus: Option<Focus>,
    cuts: HashMap<Region, Box<[u32]>>,
    /// φ3 of the cuts.
    falloff: Falloff,
    kept_bytes: u64,
    most_bytes: u64,
}

/// Cell coordinates plus 2¹⁸, 19 bits each, and how often the edge has been doubled.
pub(super) type Region = u64;

const REGION_BITS: u32 = 19;
const REGION_BIAS: f32 = (1 << 18) as f32;

impl RegionCuts {
    /// # Errors
    /// [`Error::OutOfMemory`] if the tree, and for each thread a cut of all lights, would not fit into
    /// `max_memory` bytes, what is left of the limit.
    pub(crate) fn new(
        scene: &Scene,
        focus: Option<Focus>,
        options: &RenderOptions,
        max_memory: u64,
    ) -> Result<Self, Error> {
        // Build a tree if there are many lights and it fits into memory.
        let samples = scene.lights();
        let many = FEW + 1..MOST_LEAVES;
        let tree =
            match options.method.has_mesh() && options.transport.light_error > 0.0 && many.contains(&samples.len()) {
                false => None,
                true => {
                    // Blocks of the packed lights, the front and its successor; their terms, and their states at some
                    // two hundred points.
                    let bytes_per_light = if options.method.knows_lights() { 256 } else { 128 };
                    let threads = rayon::current_num_threads() as u64;
                    let needed_bytes = LightTree::bytes(samples) + threads * bytes_per_light * samples.len() as u64;
                    if needed_bytes > max_memory {
                        let held = options.limits.max_memory.saturating_sub(max_memory);
                        return Err(Error::OutOfMemory {
                            what: "the scene, the picture and the hierarchy of lights",
                            needed_bytes: held + needed_bytes,
                            limit_bytes: options.limits.max_memory,
                            advice: "choose fewer --light-samples or --light-error 0",
                        });
                    }
                    Some(LightTree::new(samples))
                }
            };

        // Divide the box into regions.
        let bounds = scene.bounds();
        let longest = focus.map_or(bounds.size().max_element(), |focus| focus.longest_edge());
        Ok(Self {
            tree,
            error: options.transport.light_error,
            origin: focus.map_or(bounds.min, |focus| focus.min.into()),
            edge: longest.max(1e-20) / REGIONS,
            focus,
            cuts: HashMap::new(),
            falloff: options.transport.falloff,
            kept_bytes: 0,
            most_bytes: max_memory / KEPT_PART,
        })
    }

    /// Returns whether nodes of a tree stand for the lights, as there are many.
    pub(crate) fn has_clusters(&self) -> bool {
        self.tree.is_some()
    }

    /// Returns the memory of the cuts, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.kept_bytes
    }

    /// Returns the lights as single points receive them.
    pub(crate) fn at<'a>(&'a self, scene: &'a Scene) -> LightCut<'a> {
        match &self.tree {
            Some(tree) => LightCut::cut(scene.lights(), tree, self.error),
            None => LightCut::all(scene.lights()),
        }
    }

    /// Returns the unshadowed irradiance per channel, lux, on surface points `(position, unit normal)`: Σ of formula
    /// (2). Cuts that are made for it are kept.
    pub(crate) fn irradiance(&mut self, scene: &Scene, falloff: Falloff, points: &[(Vec3, Vec3)]) -> Vec<Vec3> {
        let order = self.order(points);
        self.keep_cuts(falloff, &order);
        self.sum(scene, falloff, points, &order)
    }

    /// Makes the cuts of the regions of some surface points, before readers share them.
    pub(crate) fn prepare(&mut self, falloff: Falloff, points: &[(Vec3, Vec3)]) {
        let order = self.order(points);
        self.keep_cuts(falloff, &order);
    }

    /// [`RegionCuts::irradiance`] without keeping cuts.
    pub(crate) fn read_irradiance(&self, scene: &Scene, falloff: Falloff, points: &[(Vec3, Vec3)]) -> Vec<Vec3> {
        self.sum(scene, falloff, points, &self.order(points))
    }

    /// Returns the tolerance of sums without shadows. Where lights are kept one by one, noise counted as at mesh points
    /// (0.3) would bring 1.46 instead of 1.65% error (a room of 10,000 lights, `hybrid`, 1/80) with 2.5 times the
    /// memory, and take twice as long.
    fn tolerance(&self) -> Tolerance {
        Tolerance { error: self.error, shadows: 0.0 }
    }

    /// Returns how many leaves the tree has; 0 where there is none.
    pub(crate) fn leaf_count(&self) -> u32 {
        self.tree.as_ref().map_or(0, |tree| tree.len() as u32)
    }

    /// Returns the tree over the lights, if there is one.
    pub(super) fn tree(&self) -> Option<&LightTree> {
        self.tree.as_ref()
    }

    /// Returns the cut of a region: the one that is kept, or one that is made in the buffers. There must be a tree.
    pub(super) fn cut<'a>(
        &'a self,
        region: Region,
        falloff: Falloff,
        refinement: &mut Refinement,
        cut: &'a mut Vec<u32>,
    ) -> &'a [u32] {
        if let Some(kept) = self.cuts.get(&region).filter(|_| self.falloff == falloff) {
            return kept;
        }
        cut.clear();
        if let Some(tree) = &self.tree {
            tree.cut(&self.receivers(region), falloff, self.tolerance(), refinement, cut);
        }
        cut
    }

    /// Returns the region of a position.
    pub(crate) fn region(&self, p: Vec3) -> Region {
        let doublings = self.focus.map_or(0, |focus| focus.doublings(focus.distance(p)));
        let cell = ((p - self.origin) / self.edge_after(doublings)).floor() + REGION_BIAS;
        let cell = cell.clamp(Vec3::ZERO, Vec3::splat(2.0 * REGION_BIAS - 1.0)).as_u64vec3();
        cell.x | cell.y << REGION_BITS | cell.z << (2 * REGION_BITS) | u64::from(doublings) << (3 * REGION_BITS)
    }

    /// Returns the middle of a region, metres.
    pub(super) fn centre(&self, region: Region) -> Vec3 {
        self.corner(region) + 0.5 * self.edge_of(region)
    }

    /// Returns the lower corner of a region, metres.
    fn corner(&self, region: Region) -> Vec3 {
        let part = |n: u32| (region >> (n * REGION_BITS) & ((1 << REGION_BITS) - 1)) as f32 - REGION_BIAS;
        self.origin + Vec3::new(part(0), part(1), part(2)) * self.edge_of(region)
    }

    /// Returns the edge of a region, metres.
    fn edge_of(&self, region: Region) -> f32 {
        self.edge_after((region >> (3 * REGION_BITS)) as u32)
    }

    fn edge_after(&self, doublings: u32) -> f32 {
        self.edge * (1_u64 << doublings) as f32
    }

    /// Returns the surfaces that a region may have.
    fn receivers(&self, region: Region) -> Receivers {
        let (min, edge) = (self.corner(region), self.edge_of(region));
        // Positions are rounded.
        let slack = Vec3::splat(edge * 1e-3);
        Receivers::within(min - slack, min + edge + slack)
    }

    /// Returns the points with their regions, region by region; nothing where there are no regions.
    fn order(&self, points: &[(Vec3, Vec3)]) -> Vec<(Region, u32)> {
        if self.tree.is_none() {
            return Vec::new();
        }
        let mut order: Vec<_> = points.par_iter().map(|&(p, _)| self.region(p)).zip(0..points.len() as u32).collect();
        order.par_sort_unstable();
        order
    }

    /// Makes the cuts that are missing, as many as may be kept.
    fn keep_cuts(&mut self, falloff: Falloff, order: &[(Region, u32)]) {
        // Drop the cuts of another falloff.
        if self.falloff != falloff {
            self.cuts.clear();
            (self.falloff, self.kept_bytes) = (falloff, 0);
        }
        let Some(tree) = &self.tree else { return };
        let regions = order.chunk_by(|a, b| a.0 == b.0).map(|group| group[0].0);
        let missing: Vec<Region> = regions.filter(|region| !self.cuts.contains_key(region)).collect();
        // Make as many as may be kept: a cut is never more than all leaves.
        let longest = tree.len() as u64 * size_of::<u32>() as u64;
        let mut missing = missing.as_slice();
        while !missing.is_empty() {
            let free = self.most_bytes.saturating_sub(self.kept_bytes) / longest;
            let (now, later) = missing.split_at(missing.len().min(free.min(1024) as usize));
            if now.is_empty() {
                return;
            }
            let this = &*self;
            let cuts: Vec<Box<[u32]>> = now
                .par_iter()
                .map_init(Default::default, |(refinement, cut): &mut (Refinement, Vec<u32>), &region| {
                    tree.cut(&this.receivers(region), this.falloff, this.tolerance(), refinement, cut);
                    cut.as_slice().into()
                })
                .collect();
            self.kept_bytes += cuts.iter().map(|cut| size_of_val(&**cut) as u64 + 64).sum::<u64>();
            self.cuts.extend(now.iter().copied().zip(cuts));
            missing = later;
        }
    }

    /// Returns the unshadowed irradiance of points in some order of their regions.
    fn sum(&self, scene: &Scene, falloff: Falloff, points: &[(Vec3, Vec3)], order: &[(Region, u32)]) -> Vec<Vec3> {
        // Without a tree, sum over all lights.
        let level = scene.simd_level();
        let Some(tree) = &self.tree else {
            let mut sums = vec![Vec3::ZERO; points.len()];
            sums.par_chunks_mut(CHUNK).zip(points.par_chunks(CHUNK)).for_each_init(Vec::new, |out, (sums, points)| {
                scene.lights().irradiance(level, falloff, points.iter().copied(), out);
                sums.copy_from_slice(out);
            });
            return sums;
        };

        // Pack the lights of each region once, and sum over them at its points.
        let groups: Vec<_> = order.chunk_by(|a, b| a.0 == b.0).collect();
        let by_group: Vec<Vec<Vec3>> = groups
            .par_iter()
            .map_init(Scratch::default, |scratch, group| {
                let Scratch { refinement, cut, lights, nodes } = scratch;
                tree.pack(self.cut(group[0].0, falloff, refinement, cut), lights, nodes);
                let mut sums = Vec::new();
                let vertices = group.iter().map(|&(_, i)| points[i as usize]);
                lights.irradiance(level, falloff, vertices, &mut sums);
                sums
            })
            .collect();
        let mut sums = vec![Vec3::ZERO; points.len()];
        for (group, group_sums) in groups.into_iter().zip(by_group) {
            for (&(_, i), sum) in group.iter().zip(group_sums) {
                sums[i as usize] = sum;
            }
        }
        sums
    }
}

/// Buffers of a worker.
#[derive(Debug, Default)]
struct Scratch {
    refinement: Refinement,
    cut: Vec<u32>,
    lights: LightSamples,
    nodes: Vec<u32>,
}

#[cfg(test)]
mod tests;
