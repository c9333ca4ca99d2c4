//! The lights that shine on one mesh point, and how much of each arrives there: V_i of formula (1).

use glam::Vec3;

use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::light::{Directions, LightCut};
use crate::world::Scene;

/// Traces the lights of mesh points, one point after the other, with buffers that it keeps.
#[derive(Debug)]
pub(super) struct PointLights<'a> {
    scene: &'a Scene,
    cut: LightCut<'a>,
    falloff: Falloff,
    shadow_rays: u64,
    directions: Directions,
    lanes: Vec<u32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

/// A light as a mesh point receives it: unshadowed, a plane of normal n gets `intensity` · `f` · (n · `direction`) of
/// it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLight {
    pub intensity: Vec3,
    pub f: f32,
    /// From the point to the light, not normalised.
    pub direction: Vec3,
    /// V_i, the part that arrives, per channel.
    pub visible: Vec3,
}

impl<'a> PointLights<'a> {
    /// No point yet; `cut` has the lights of the scene.
    pub(super) fn new(scene: &'a Scene, cut: LightCut<'a>, falloff: Falloff) -> Self {
        Self {
            scene,
            cut,
            falloff,
            shadow_rays: 0,
            directions: Directions::default(),
            lanes: Vec::new(),
            rays: Vec::new(),
            visible: Vec::new(),
            shadow: VisibilityScratch::default(),
        }
    }

    /// Returns how many shadow rays have been traced so far.
    pub(super) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    /// Traces a shadow ray from the point at `x` to every light that shines on it.
    pub(super) fn trace(&mut self, x: Vec3) {
        self.cut.set_receiver(x, self.falloff);
        let lights = self.cut.lights();
        lights.directions(self.scene.simd_level(), self.falloff, x, &mut self.directions);
        self.lanes.clear();
        self.rays.clear();
        for lane in 0..lights.lanes() {
            if self.directions.f[lane] > 0.0 && lights.intensity(lane) != Vec3::ZERO {
                self.lanes.push(lane as u32);
                self.rays.push(self.cut.shadow_ray(lane, x));
            }
        }
        visibility(self.scene, &self.rays, &mut self.shadow, &mut self.visible);
        self.shadow_rays += self.rays.len() as u64;
    }

    /// Returns the lights that shine on the point traced last.
    pub(super) fn iter(&self) -> impl Iterator<Item = PointLight> {
        let Directions { dx, dy, dz, f } = &self.directions;
        self.lanes.iter().zip(&self.visible).map(move |(&lane, &visible)| {
            let lane = lane as usize;
            let direction = Vec3::new(dx[lane], dy[lane], dz[lane]);
            PointLight { intensity: self.cut.lights().intensity(lane), f: f[lane], direction, visible }
        })
    }

    /// Returns the lanes of these lights, ascending.
    pub(super) fn lanes(&self) -> &[u32] {
        &self.lanes
    }

    /// Returns V_i of these lights, per channel.
    pub(super) fn visible(&self) -> &[Vec3] {
        &self.visible
    }

    /// Returns the lights that a lane stands for, as an interval of the light tree's leaves.
    pub(super) fn leaves(&self, lane: u32) -> std::ops::Range<u32> {
        self.cut.leaves(lane as usize)
    }
}
