//! Which parts of the sky can be seen around a mesh point: found once for a block of space, so that each point knows
//! where to look for a window.
//!
//! A block is a cube of eight mesh points along each edge, at multiples of its size. It has eight places from which rays
//! go to every part of the sky; a point takes the places that it sees itself, as walls may divide the block. What is
//! found decides only how many rays go where: the light at a point has its own rays.

use glam::{IVec3, Vec3};

use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::light::{Stratum, shadow_ray_to};
use crate::sampling::{hash, seed_of_position};
use crate::world::Scene;

/// Mesh points along the edge of a block.
const BLOCK: f32 = 8.0;

/// Rays from each of the eight places to each part of the sky.
const RAYS: u32 = 4;

/// What can be seen of the sky around points of one block; buffers are kept from block to block.
#[derive(Debug)]
pub(super) struct SkyViews<'a> {
    scene: &'a Scene,
    /// The lanes of the parts of the sky, ascending.
    lanes: Vec<u32>,
    block: Option<(IVec3, f32)>,
    places: Vec<Vec3>,
    /// By place and part: what is visible of it.
    seen: Vec<f32>,
    /// By part: the mean over the places that a point sees.
    around: Vec<f32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
    rays_traced: u64,
}

impl<'a> SkyViews<'a> {
    /// No block yet; `None` where there is no sky.
    pub(super) fn new(scene: &'a Scene) -> Option<Self> {
        let lights = scene.lights();
        if !lights.has_strata() {
            return None;
        }
        let is_sky = |&lane: &u32| matches!(lights.stratum(lane as usize), Stratum::Sky(_));
        let lanes: Vec<u32> = (0..lights.lanes() as u32).filter(is_sky).collect();
        (!lanes.is_empty()).then(|| Self {
            scene,
            lanes,
            block: None,
            places: Vec::new(),
            seen: Vec::new(),
            around: Vec::new(),
            rays: Vec::new(),
            visible: Vec::new(),
            shadow: VisibilityScratch::default(),
            rays_traced: 0,
        })
    }

    /// Returns how many rays have been traced so far.
    pub(super) fn rays(&self) -> u64 {
        self.rays_traced
    }

    /// Returns the part in [0, 1] that is visible of each part of the sky, by lane ascending, around a point of a mesh of
    /// this spacing; a half where that is unknown.
    pub(super) fn around(&mut self, x: Vec3, spacing: f32) -> &[f32] {
        let edge = BLOCK * spacing;
        let block = (x / edge).floor().as_ivec3();
        if self.block != Some((block, spacing)) {
            self.block = Some((block, spacing));
            self.look(block.as_vec3() * edge, edge);
        }
        // Find the places that the point sees.
        self.rays.clear();
        self.rays.extend(self.places.iter().map(|&place| Ray::segment(x, place)));
        self.trace();
        self.around.clear();
        self.around.resize(self.lanes.len(), 0.0);
        let mut count = 0.0;
        for (seen, &v) in self.seen.chunks_exact(self.lanes.len()).zip(&self.visible) {
            if v != Vec3::ZERO {
                count += 1.0;
                self.around.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += seen);
            }
        }
        let (scale, otherwise) = if count > 0.0 { (1.0 / count, 0.0) } else { (0.0, 0.5) };
        self.around.iter_mut().for_each(|sum| *sum = *sum * scale + otherwise);
        &self.around
    }

    /// Looks at the sky from the places of a block.
    fn look(&mut self, corner: Vec3, edge: f32) {
        let octant = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
        self.places.clear();
        // Not where mesh points are.
        self.places.extend((0..8).map(|i| corner + (octant(i) * 0.5 + 0.263) * edge));
        self.rays.clear();
        for &place in &self.places {
            let seed = hash(!seed_of_position(place));
            for &lane in &self.lanes {
                for k in 0..RAYS {
                    let emitters = self.scene.emitters();
                    let light = emitters.sky_direction(self.scene.lights(), lane as usize, k, RAYS, seed);
                    self.rays.extend(light.map(|light| shadow_ray_to(&light, place)));
                }
            }
        }
        self.trace();
        self.seen.clear();
        let mean = |rays: &[Vec3]| rays.iter().sum::<Vec3>().element_sum() / (3 * RAYS) as f32;
        self.seen.extend(self.visible.chunks_exact(RAYS as usize).map(mean));
    }

    fn trace(&mut self) {
        visibility(self.scene, &self.rays, &mut self.shadow, &mut self.visible);
        self.rays_traced += self.rays.len() as u64;
    }
}
