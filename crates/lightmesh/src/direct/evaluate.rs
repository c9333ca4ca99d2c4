//! The value of one mesh point: formula (1), per channel, along six axes or as the paper's scalar.

use glam::{Vec3, Vec4};

use super::field::DirectEncoding;
use super::visibility_bits::LightBits;
use super::visibility_runs::{LightRuns, State};
use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::light::{Directions, LightCut};
use crate::world::Scene;
use crate::{Falloff, PaperScale};

/// Evaluates points one after the other, with buffers that it keeps.
#[derive(Debug)]
pub(super) struct Evaluator<'a> {
    scene: &'a Scene,
    lights: LightCut<'a>,
    field: DirectEncoding,
    constant: f32,
    shadow_rays: u64,
    directions: Directions,
    lanes: Vec<u32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(scene: &'a Scene, lights: LightCut<'a>, field: DirectEncoding, constant: f32) -> Self {
        Self {
            scene,
            lights,
            field,
            constant,
            shadow_rays: 0,
            directions: Directions::default(),
            lanes: Vec::new(),
            rays: Vec::new(),
            visible: Vec::new(),
            shadow: VisibilityScratch::default(),
        }
    }

    /// Shadow rays so far.
    pub(super) fn shadow_rays(&self) -> u64 {
        self.shadow_rays
    }

    /// What the point that was evaluated last knows of each light; lanes of `padding` never shine.
    pub(super) fn pack(&self, bits: &LightBits, padding: &[u64]) -> Vec<u64> {
        bits.pack(&self.lanes, &self.visible, padding)
    }

    /// The same where lights are clusters: the states of the nodes that were asked about, in runs.
    pub(super) fn runs(&self) -> Vec<u32> {
        LightRuns::pack(self.lanes.iter().zip(&self.visible).map(|(&lane, &v)| {
            let state = if v == Vec3::ONE {
                State::Seen
            } else if v == Vec3::ZERO {
                State::Closed
            } else {
                State::Unknown
            };
            (self.lights.leaves(lane as usize), state)
        }))
    }

    /// The values of the point at `x`, visible and unshadowed light by turns: as many as [`DirectEncoding::stride`] counts.
    pub(super) fn evaluate(&mut self, x: Vec3) -> [Vec4; 12] {
        match self.field {
            DirectEncoding::SixAxis { falloff } => {
                self.shoot(x, falloff);
                self.six_axis()
            }
            DirectEncoding::PerLight { falloff } => {
                self.shoot(x, falloff);
                [Vec4::ZERO; 12]
            }
            DirectEncoding::Scalar { falloff, scale } => {
                self.shoot(x, falloff);
                let mut values = [Vec4::ZERO; 12];
                values[..2].copy_from_slice(&self.scalar(scale));
                values
            }
        }
    }

    /// V_i for every light that reaches `x` at all.
    pub(crate) fn shoot(&mut self, x: Vec3, falloff: Falloff) {
        self.lights.set_receiver(x, falloff);
        let lights = self.lights.lights();
        lights.directions(self.scene.simd_level(), falloff, x, &mut self.directions);
        self.lanes.clear();
        self.rays.clear();
        for lane in 0..lights.lanes() {
            if self.directions.f[lane] > 0.0 && lights.intensity(lane) != Vec3::ZERO {
                self.lanes.push(lane as u32);
                self.rays.push(self.lights.shadow_ray(lane, x));
            }
        }
        visibility(self.scene, &self.rays, &mut self.shadow, &mut self.visible);
        self.shadow_rays += self.rays.len() as u64;
    }

    /// For each of ±x ±y ±z: Σ V_i E_i cos / φ, and the same sum without V_i.
    fn six_axis(&self) -> [Vec4; 12] {
        let mut values = [Vec4::ZERO; 12];
        let d = &self.directions;
        for (&lane, &v) in self.lanes.iter().zip(&self.visible) {
            let lane = lane as usize;
            let intensity = (self.lights.lights().intensity(lane) * d.f[lane]).extend(0.0);
            for (axis, component) in [d.dx[lane], d.dy[lane], d.dz[lane]].into_iter().enumerate() {
                let side = 2 * axis + usize::from(component < 0.0);
                let e = intensity * component.abs();
                values[2 * side] += e * v.extend(0.0);
                values[2 * side + 1] += e;
            }
        }
        values
    }

    /// DirectLight(x), formula (1): Σ V_i E_i / φ1, and what it is scaled by.
    fn scalar(&self, scale: PaperScale) -> [Vec4; 2] {
        let (mut visible, mut all) = (Vec3::ZERO, Vec3::ZERO);
        let d = &self.directions;
        for (&lane, &v) in self.lanes.iter().zip(&self.visible) {
            let lane = lane as usize;
            let r = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]).length();
            let e = self.lights.lights().intensity(lane) * (d.f[lane] * r);
            all += e;
            visible += e * v;
        }
        let scaled_by = match scale {
            PaperScale::Visibility => all,
            PaperScale::Constant => Vec3::splat(self.constant),
        };
        [visible.extend(0.0), scaled_by.extend(0.0)]
    }
}
