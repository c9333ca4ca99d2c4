//! The value of one mesh point: formula (1), per channel, as six-axis ratios or as the paper's scalar.

use glam::{Vec3, Vec4};

use super::{Field, FillStats};
use crate::geometry::Ray;
use crate::integrator::{VisibilityScratch, is_back_face, visibility};
use crate::scene::{Directions, Scene};
use crate::{Falloff, PaperScale};

/// Evaluates points one after the other, with buffers that it keeps.
#[derive(Debug)]
pub(super) struct Evaluator<'a> {
    scene: &'a Scene,
    field: Field,
    stats: FillStats,
    directions: Directions,
    lanes: Vec<u32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

/// Where a point looks to find out whether it is inside a solid: six directions of a cube turned off the axes, along which
/// architecture has its edges.
const PROBES: [Vec3; 6] = [
    Vec3::new(0.8, 0.36, 0.48),
    Vec3::new(-0.8, -0.36, -0.48),
    Vec3::new(-0.6, 0.48, 0.64),
    Vec3::new(0.6, -0.48, -0.64),
    Vec3::new(0.0, 0.8, -0.6),
    Vec3::new(0.0, -0.8, 0.6),
];

impl<'a> Evaluator<'a> {
    pub(super) fn new(scene: &'a Scene, field: Field) -> Self {
        Self {
            scene,
            field,
            stats: FillStats::default(),
            directions: Directions::default(),
            lanes: Vec::new(),
            rays: Vec::new(),
            visible: Vec::new(),
            shadow: VisibilityScratch::default(),
        }
    }

    /// The work so far.
    pub(super) fn stats(&self) -> FillStats {
        self.stats
    }

    /// The values of the point at `x` (as many as [`Field::stride`] count), or `None` if it is inside a solid.
    pub(super) fn evaluate(&mut self, x: Vec3) -> Option<[Vec4; 6]> {
        match self.field {
            Field::SixAxis { falloff } => {
                if self.is_inside(x) {
                    return None;
                }
                self.shoot(x, falloff);
                Some(self.six_axis())
            }
            // The paper's mesh knows no geometry: every point counts.
            Field::Scalar { falloff, scale } => {
                self.shoot(x, falloff);
                let value = self.scalar(scale);
                Some([value, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO])
            }
        }
    }

    /// Whether most of what the point sees are back faces of one-sided surfaces.
    fn is_inside(&mut self, x: Vec3) -> bool {
        let (mut back, mut front) = (0, 0);
        for direction in PROBES {
            let ray = Ray::new(x, direction);
            if let Some(hit) = self.scene.bvh().closest(&ray) {
                if is_back_face(self.scene, &ray, &hit) { back += 1 } else { front += 1 }
            }
        }
        self.stats.probe_rays += PROBES.len() as u64;
        back > front && back >= PROBES.len() / 2
    }

    /// V_i for every light that reaches `x` at all.
    fn shoot(&mut self, x: Vec3, falloff: Falloff) {
        let lights = self.scene.lights();
        lights.directions(self.scene.level(), falloff, x, &mut self.directions);
        self.lanes.clear();
        self.rays.clear();
        for lane in 0..lights.lanes() {
            if self.directions.f[lane] > 0.0 && lights.intensity(lane) != Vec3::ZERO {
                self.lanes.push(lane as u32);
                self.rays.push(lights.shadow_ray(lane, x));
            }
        }
        visibility(self.scene, &self.rays, &mut self.shadow, &mut self.visible);
        self.stats.shadow_rays += self.rays.len() as u64;
    }

    /// For each of ±x ±y ±z: Σ V_i E_i cos / φ over the same sum without V_i.
    fn six_axis(&self) -> [Vec4; 6] {
        let (mut visible, mut all) = ([Vec3::ZERO; 6], [Vec3::ZERO; 6]);
        let (mut visible_sum, mut all_sum) = (Vec3::ZERO, Vec3::ZERO);
        let d = &self.directions;
        for (&lane, &v) in self.lanes.iter().zip(&self.visible) {
            let lane = lane as usize;
            let intensity = self.scene.lights().intensity(lane) * d.f[lane];
            for (axis, component) in [d.dx[lane], d.dy[lane], d.dz[lane]].into_iter().enumerate() {
                let side = 2 * axis + usize::from(component < 0.0);
                let e = intensity * component.abs();
                all[side] += e;
                visible[side] += e * v;
                all_sum += e;
                visible_sum += e * v;
            }
        }
        // A side that no light faces takes the mean of the others: its normal sees those lights at a slant.
        let mean = ratio(visible_sum, all_sum, Vec3::ONE);
        std::array::from_fn(|side| ratio(visible[side], all[side], mean).extend(0.0))
    }

    /// DirectLight(x), formula (1): Σ V_i E_i / φ1.
    fn scalar(&self, scale: PaperScale) -> Vec4 {
        let (mut visible, mut all) = (Vec3::ZERO, Vec3::ZERO);
        let d = &self.directions;
        for (&lane, &v) in self.lanes.iter().zip(&self.visible) {
            let lane = lane as usize;
            let r = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]).length();
            let e = self.scene.lights().intensity(lane) * (d.f[lane] * r);
            all += e;
            visible += e * v;
        }
        match scale {
            PaperScale::Visibility => ratio(visible, all, Vec3::ONE).extend(0.0),
            PaperScale::Constant => visible.extend(0.0),
        }
    }
}

/// The normalising constant of [`PaperScale::Constant`]; 1 without lights.
pub(super) fn papers_constant(scene: &Scene, falloff: Falloff) -> f32 {
    const SIDE: u32 = 8;
    let (bounds, lights) = (scene.bounds(), scene.lights());
    let (mut d, mut sum) = (Directions::default(), 0.0_f64);
    for i in 0..SIDE.pow(3) {
        let place = Vec3::new((i % SIDE) as f32, (i / SIDE % SIDE) as f32, (i / SIDE / SIDE) as f32) + 0.5;
        lights.directions(scene.level(), falloff, bounds.min + bounds.size() * (place / SIDE as f32), &mut d);
        for lane in 0..lights.lanes() {
            let r = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]).length();
            sum += f64::from(lights.intensity(lane).element_sum() / 3.0 * d.f[lane] * r);
        }
    }
    if sum > 0.0 { (f64::from(SIDE.pow(3)) / sum) as f32 } else { 1.0 }
}

/// Componentwise a / b, and `otherwise` where b is 0.
fn ratio(a: Vec3, b: Vec3, otherwise: Vec3) -> Vec3 {
    Vec3::select(b.cmpgt(Vec3::ZERO), a / b.max(Vec3::splat(f32::MIN_POSITIVE)), otherwise)
}
