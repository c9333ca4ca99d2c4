//! Direct light from what the mesh knows of each single light: shadow rays are shot where it does not know enough.
//!
//! Both ways begin with Σ_i V̂_i c_i, where c_i is what light i would give unshadowed (a term of formula (2)) and V̂_i in [0, 1] what
//! the mesh points around the surface say of its visibility. They differ in what they shoot:
//!
//! - *hybrid*: a ray to every light about which the points disagree, whose V̂_i is then V_i. Where they agree they are believed, so
//!   that what is thinner than the mesh is missed;
//! - *unbiased*: K rays whatever the mesh says, to lights j chosen with probability p_j, and the mean of (V_j − V̂_j) c_j / p_j is added: the
//!   mesh is a control variate of light sampling, and the expectation is the exact sum whatever it says.
//!
//! With p_j ∝ c_j (√(V̂_j (1 − V̂_j)) + [`DOUBT`]): the standard deviation of a visibility that is 1 with probability V̂_j, and some for lights
//! that all points agree about. Clarberg and Akenine-Möller, "Exploiting Visibility Correlation in Direct Illumination" (EGSR 2008),
//! estimate the visibility of an environment from that at points nearby, as a control variate too. There the points are earlier
//! hits in the picture, which must be gathered around each pixel, and V̂ also steers importance sampling by visibility; here they are
//! points of the mesh, known by light, at no cost per pixel, and V̂ steers sampling by *doubt*: a light that is surely seen needs no
//! ray.

use glam::Vec3;

use super::Vertex;
use super::sampling::hash;
use super::visibility::{VisibilityScratch, visibility};
use crate::Falloff;
use crate::geometry::Ray;
use crate::light_mesh::Agreement;
use crate::scene::{LANES, Receiver, Scene, Term};

/// The doubt that is left where all points agree, in units of the standard deviation of a visibility.
const DOUBT: f32 = 0.08;

/// Buffers, one set per worker, kept between calls.
#[derive(Debug, Default)]
pub(super) struct ByLight {
    terms: Vec<Term>,
    /// What is chosen among, and how likely: first the terms, then the blocks of lights that are agreed about.
    masses: Vec<f32>,
    estimates: Vec<f32>,
    /// What each ray's visibility is multiplied with, and the visibility that is expected of it.
    weights: Vec<Vec3>,
    expected: Vec<f32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl ByLight {
    /// Direct irradiance, lux per channel, with a ray to every disputed light that shines on the surface; and how many these were.
    pub(super) fn hybrid(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        vertex: &Vertex,
        agreement: &Agreement,
    ) -> (Vec3, u64) {
        let (lights, receiver) = (scene.lights(), receiver(vertex, falloff));
        let (sure, disputed) = (&agreement.sure, &agreement.disputed);
        let mut sum = lights.weighted_irradiance(scene.level(), &receiver, sure, disputed, &mut self.terms);
        self.clear_rays();
        for term in &self.terms {
            let lane = disputed[term.index] as usize;
            self.rays.push(lights.shadow_ray(lane, vertex.origin_towards(term.direction)));
            self.weights.push(lights.intensity(lane) * term.factor);
        }
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        for (&c, &v) in self.weights.iter().zip(&self.visible) {
            sum += c * v;
        }
        (sum, self.rays.len() as u64)
    }

    /// An unbiased estimate of the direct irradiance, lux per channel, with `count` rays; and how many were shot.
    pub(super) fn unbiased(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        vertex: &Vertex,
        agreement: &Agreement,
        (count, seed): (u32, u32),
    ) -> (Vec3, u64) {
        let (lights, receiver) = (scene.lights(), receiver(vertex, falloff));
        let Self { terms, masses, estimates, .. } = self;
        let (sure, disputed) = (&agreement.sure, &agreement.disputed);
        let mut sum =
            lights.weighted_irradiance_and_masses(scene.level(), &receiver, sure, disputed, terms, masses);
        masses.iter_mut().for_each(|mass| *mass *= DOUBT);

        // Disputed lights: their mean, and how much there is to gain from a ray.
        estimates.clear();
        for term in terms.iter() {
            let c = lights.intensity(disputed[term.index] as usize) * term.factor;
            let v = agreement.estimate(term.index);
            sum += c * v;
            estimates.push(v);
            masses.push(c.element_sum() / 3.0 * ((v * (1.0 - v)).sqrt() + DOUBT));
        }
        let total: f32 = self.masses.iter().sum();
        if !(total > 0.0) {
            return (sum, 0);
        }

        // Choose lights, stratified over the list.
        self.clear_rays();
        let blocks = lights.lanes() / LANES;
        let (mut entry, mut below) = (0, 0.0);
        for k in 0..count {
            let (u, v) = (random(seed, 2 * k), random(seed, 2 * k + 1));
            let at = (k as f32 + u) / count as f32 * total;
            while entry + 1 < self.masses.len() && below + self.masses[entry] <= at {
                below += self.masses[entry];
                entry += 1;
            }
            let mass = self.masses[entry];
            if !(mass > 0.0) {
                continue;
            }
            let p = mass / total;
            let (lane, direction, weight, expected) = if entry < blocks {
                let Some((lane, direction, factor, share)) =
                    self.choose_in_block(scene, &receiver, agreement, entry, v)
                else {
                    continue;
                };
                (lane, direction, factor / (p * share), sure[lane])
            } else {
                let term = self.terms[entry - blocks];
                (disputed[term.index] as usize, term.direction, term.factor / p, self.estimates[entry - blocks])
            };
            self.rays.push(lights.shadow_ray(lane, vertex.origin_towards(direction)));
            self.weights.push(lights.intensity(lane) * (weight / count as f32));
            self.expected.push(expected);
        }

        // The mesh is wrong by what the rays find.
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        for ((&weight, &v), &expected) in self.weights.iter().zip(&self.visible).zip(&self.expected) {
            sum += weight * (v - expected);
        }
        (sum, self.rays.len() as u64)
    }

    /// One of the block's lights that are agreed about, in proportion to c_i: its lane, direction, factor and probability.
    fn choose_in_block(
        &self,
        scene: &Scene,
        receiver: &Receiver,
        agreement: &Agreement,
        block: usize,
        u: f32,
    ) -> Option<(usize, Vec3, f32, f32)> {
        let lights = scene.lights();
        let terms = lights.block_terms(scene.level(), receiver, block);
        let mass = |i: usize| {
            let lane = block * LANES + i;
            let asked = agreement.disputed.binary_search(&(lane as u32)).is_ok();
            if asked { 0.0 } else { lights.intensity(lane).element_sum() / 3.0 * terms[i].1 }
        };
        let masses: [f32; LANES] = std::array::from_fn(mass);
        let total: f32 = masses.iter().sum();
        let mut rest = u * total;
        let mut chosen = None;
        for (i, &mass) in masses.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
            chosen = Some(i);
            rest -= mass;
            if rest < 0.0 {
                break;
            }
        }
        let i = chosen?;
        Some((block * LANES + i, terms[i].0, terms[i].1, masses[i] / total))
    }

    fn clear_rays(&mut self) {
        self.rays.clear();
        self.weights.clear();
        self.expected.clear();
    }
}

fn receiver(vertex: &Vertex, falloff: Falloff) -> Receiver {
    Receiver { position: vertex.position, n: vertex.n, falloff }
}

/// The i-th number in [0, 1) of a seed.
fn random(seed: u32, i: u32) -> f32 {
    (hash(seed ^ hash(i.wrapping_mul(0x9e37_79b9).wrapping_add(1))) >> 8) as f32 * (1.0 / (1 << 24) as f32)
}
