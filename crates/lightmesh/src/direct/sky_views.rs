//! Which parts of the sky can be seen around a mesh point: found once for a block of space, so that each point knows
//! where to look for a window.
//!
//! A block is a cube of eight mesh points along each edge, at multiples of its size. It has eight places from which rays
//! go to every part of the sky; a point takes the places that it sees itself, as walls may divide the block. What is
//! found decides only how many rays go where: the light at a point has its own rays. Blocks are kept: mesh points come in the
//! order in which surfaces read them, and many have the same block.

use std::collections::{BTreeSet, HashMap};

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::light::{Stratum, shadow_ray_to};
use crate::sampling::{hash, seed_of_position};
use crate::world::Scene;

/// Mesh points along the edge of a block.
const BLOCK: f32 = 8.0;

/// Rays from each of the eight places to each part of the sky, and from a point that sees none of the places.
const RAYS: u32 = 4;
const OWN_RAYS: u32 = 12;

/// Most memory of the blocks that are kept, bytes, and the part of the limit that it may be; they are forgotten beyond it.
const MOST_BYTES: u64 = 64 << 20;
const MOST_PART: u64 = 16;

/// A block: its coordinates, and the bits of the mesh's spacing.
type Block = ([i32; 3], u32);

/// What can be seen of the sky from blocks of space.
#[derive(Clone, Debug, Default)]
pub(super) struct SkyViews {
    /// The lanes of the parts of the sky, ascending; empty where there is none.
    lanes: Vec<u32>,
    /// By part: the parts beside it.
    beside: Vec<Vec<u32>>,
    /// By block, place and part: what is visible of it.
    seen: HashMap<Block, Box<[f32]>>,
    most_bytes: u64,
}

/// Parts whose middles are no farther apart than so many times the sum of their radii are beside each other. A judgement.
const BESIDE: f32 = 1.2;

/// What is taken for visible, or hidden, of a part of which nothing else has been seen but which is beside others: the
/// rim of a window. A judgement.
const RIM: f32 = 0.02;

impl SkyViews {
    /// No block yet; `max_memory` is what is left of the limit, bytes.
    pub(super) fn new(scene: &Scene, max_memory: u64) -> Self {
        let lights = scene.lights();
        let is_sky = |&lane: &u32| lights.has_strata() && matches!(lights.stratum(lane as usize), Stratum::Sky(_));
        let lanes: Vec<u32> = (0..lights.lanes() as u32).filter(is_sky).collect();
        let middle = |lane: u32| lights.sample(lane as usize).map_or(Vec3::ZERO, |light| light.position);
        let radius = |lane: u32| lights.radius(lane as usize);
        let beside = |&lane: &u32| {
            let is_beside = |&(_, &other): &(u32, &u32)| {
                other != lane && middle(lane).distance(middle(other)) < BESIDE * (radius(lane) + radius(other))
            };
            (0..).zip(&lanes).filter(is_beside).map(|(part, _)| part).collect()
        };
        let beside = lanes.iter().map(beside).collect();
        Self { lanes, beside, seen: HashMap::new(), most_bytes: MOST_BYTES.min(max_memory / MOST_PART) }
    }

    /// Returns the memory, bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.seen.len() as u64 * self.block_bytes()
    }

    fn block_bytes(&self) -> u64 {
        (self.lanes.len() * 8 * size_of::<f32>() + 64) as u64
    }

    /// Looks at the sky from the blocks of some mesh points, given by position and spacing, that are not known. Returns how
    /// many rays that took.
    pub(super) fn look_from(&mut self, scene: &Scene, points: impl Iterator<Item = (Vec3, f32)>) -> u64 {
        if self.lanes.is_empty() {
            return 0;
        }
        if self.bytes() > self.most_bytes {
            self.seen.clear();
        }
        let blocks: BTreeSet<Block> = points.map(|(x, spacing)| block_of(x, spacing)).collect();
        let blocks: Vec<Block> = blocks.into_iter().filter(|block| !self.seen.contains_key(block)).collect();
        let lanes = &self.lanes;
        let look = |scratch: &mut Scratch, &block: &Block| {
            let mut seen = Vec::new();
            look(scene, lanes, places(block), RAYS, scratch, &mut seen);
            (block, seen.into_boxed_slice())
        };
        let found: Vec<_> = blocks.par_iter().map_init(Scratch::default, look).collect();
        self.seen.extend(found);
        blocks.len() as u64 * 8 * self.lanes.len() as u64 * u64::from(RAYS)
    }

    /// Returns a reader for one thread; `None` where there is no sky.
    pub(super) fn reader<'a>(&'a self, scene: &'a Scene) -> Option<SkyReader<'a>> {
        let reader =
            || SkyReader { views: self, scene, around: Vec::new(), scratch: Scratch::default(), rays_traced: 0 };
        (!self.lanes.is_empty()).then(reader)
    }
}

/// Reads what mesh points see of the sky; buffers are kept from point to point.
#[derive(Debug)]
pub(super) struct SkyReader<'a> {
    views: &'a SkyViews,
    scene: &'a Scene,
    /// By part: the mean over the places that a point sees.
    around: Vec<f32>,
    scratch: Scratch,
    rays_traced: u64,
}

impl SkyReader<'_> {
    /// Returns how many rays have been traced so far.
    pub(super) fn rays(&self) -> u64 {
        self.rays_traced
    }

    /// Returns what is visible of the sky around a point of a mesh of this spacing. Its block must have been looked from.
    pub(super) fn around(&mut self, x: Vec3, spacing: f32) -> SkyAround<'_> {
        // Find the places that the point sees.
        let (block, count) = (block_of(x, spacing), self.views.lanes.len());
        let Scratch { rays, visible, shadow, .. } = &mut self.scratch;
        rays.clear();
        rays.extend(places(block).map(|place| Ray::segment(x, place)));
        visibility(self.scene, rays, shadow, visible);
        self.rays_traced += rays.len() as u64;

        // Take the mean over them.
        self.around.clear();
        self.around.resize(count, 0.0);
        let mut places_seen = 0.0;
        let seen = self.views.seen.get(&block).map_or(&[][..], |seen| seen);
        for (seen, &v) in seen.chunks_exact(count).zip(&*visible) {
            if v != Vec3::ZERO {
                places_seen += 1.0;
                self.around.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += seen);
            }
        }
        if places_seen > 0.0 {
            self.around.iter_mut().for_each(|sum| *sum /= places_seen);
        } else {
            // In a thin layer before a wall, look from the point itself.
            let lanes = &self.views.lanes;
            look(self.scene, lanes, std::iter::once(x), OWN_RAYS, &mut self.scratch, &mut self.around);
            self.rays_traced += self.scratch.rays.len() as u64;
        }
        SkyAround { views: self.views, seen: &self.around }
    }
}

/// What is visible of the sky around a mesh point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkyAround<'a> {
    views: &'a SkyViews,
    /// By part.
    seen: &'a [f32],
}

impl SkyAround<'_> {
    /// Returns the part in [0, 1] that is visible of a lane's part of the sky.
    pub(super) fn of(&self, lane: u32) -> f32 {
        self.part(lane).map_or(0.5, |part| self.seen[part])
    }

    /// Returns how much of it may be visible for all that is known: a little, or nearly all, where nothing or all was
    /// seen of it and something else of a part beside it.
    pub(super) fn guess(&self, lane: u32) -> f32 {
        let Some(part) = self.part(lane) else { return 0.5 };
        let q = self.seen[part];
        let is_at_rim = || self.views.beside[part].iter().any(|&other| self.seen[other as usize] != q);
        if (q == 0.0 || q == 1.0) && is_at_rim() { q.clamp(RIM, 1.0 - RIM) } else { q }
    }

    fn part(&self, lane: u32) -> Option<usize> {
        self.views.lanes.binary_search(&lane).ok()
    }
}

#[derive(Debug, Default)]
struct Scratch {
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
    /// By ray: the number in what is seen that it counts for.
    owners: Vec<usize>,
}

/// Returns the block of a mesh point.
fn block_of(x: Vec3, spacing: f32) -> Block {
    ((x / (BLOCK * spacing)).floor().as_ivec3().to_array(), spacing.to_bits())
}

/// Returns the places of a block: not where mesh points are.
fn places((block, spacing): Block) -> impl Iterator<Item = Vec3> {
    let edge = BLOCK * f32::from_bits(spacing);
    let octant = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let corner = IVec3::from(block).as_vec3() * edge;
    (0..8).map(move |i| corner + (octant(i) * 0.5 + 0.263) * edge)
}

/// Looks at the parts of the sky from some places by so many rays each; `seen` becomes what is visible, by place and part.
fn look(
    scene: &Scene,
    lanes: &[u32],
    places: impl Iterator<Item = Vec3>,
    count: u32,
    scratch: &mut Scratch,
    seen: &mut Vec<f32>,
) {
    let Scratch { rays, visible, shadow, owners } = scratch;
    rays.clear();
    owners.clear();
    seen.clear();
    for place in places {
        let seed = hash(!seed_of_position(place));
        for &lane in lanes {
            for k in 0..count {
                let light = scene.emitters().sky_direction(scene.lights(), lane as usize, k, count, seed);
                if let Some(light) = light {
                    rays.push(shadow_ray_to(&light, place));
                    owners.push(seen.len());
                }
            }
            seen.push(0.0);
        }
    }
    visibility(scene, rays, shadow, visible);
    // A pane before all of it divides nothing.
    for (&owner, &v) in owners.iter().zip(&*visible) {
        seen[owner] += if v == Vec3::ZERO { 0.0 } else { 1.0 / count as f32 };
    }
}
