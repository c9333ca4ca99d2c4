//! Direct light from what the mesh knows of each single light: shadow rays are shot where it does not know enough.
//!
//! Both ways begin with Σ_i V̂_i c_i, where c_i is what light i would give unshadowed (a term of formula (2)) and V̂_i in [0, 1] what
//! the mesh points around the surface say of its visibility. They differ in what they shoot:
//!
//! - *hybrid*: a ray to every light about which the points disagree, whose V̂_i is then V_i; of those that give but little of the light
//!   only some, chosen by what there is to gain (below), so that the others are counted without bias. Where points agree they
//!   are believed, unless the light is below the surface, beyond points that are hidden from it, or gives much of the light: what is
//!   thinner than the mesh can be missed;
//! - *unbiased*: K rays whatever the mesh says, to lights j chosen with probability p_j, and the mean of (V_j − V̂_j) c_j / p_j is added: the
//!   mesh is a control variate of light sampling, and the expectation is the exact sum whatever it says.
//!
//! With p_j ∝ c_j (√(V̂_j (1 − V̂_j)) + [`DOUBT`]): the standard deviation of a visibility that is 1 with probability V̂_j, and some for lights
//! that all points agree about. Clarberg and Akenine-Möller, "Exploiting Visibility Correlation in Direct Illumination" (EGSR 2008),
//! estimate visibility from that known at points nearby, as a control variate too. Here these are points of the mesh in space, which
//! know lights one by one and serve every camera, and V̂ steers sampling by *doubt*: a light that is surely seen needs no ray.

use glam::Vec3;

use super::Vertex;
use super::sampling::hash;
use super::visibility::{VisibilityScratch, visibility};
use crate::Falloff;
use crate::geometry::Ray;
use crate::light_mesh::Agreement;
use crate::scene::{BlockSum, LANES, Receiver, Scene, Term};

/// The doubt that is left where all points agree, in units of the standard deviation of a visibility. Measured with 4 rays at 1/80, error in
/// the room of 100 lights and in Sponza: 0.05 2.9 / 7.3%, 0.08 2.9 / 6.7%, 0.12 3.0 / 6.5%.
const DOUBT: f32 = 0.08;

/// The standard deviation that the visibility of a doubtful light is taken to have at least. Without it 3.2 / 6.7%.
const DOUBTFUL: f32 = 0.3;

/// How much of the light at a surface the mesh is believed about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Care {
    /// Of disputed lights, each that gives this part of all light (unshadowed), or more, gets a ray, and the others together one
    /// for each such part.
    pub quantum: f32,
    /// A light that gives this part or more gets a ray whatever the points agree on.
    pub much: f32,
    /// What of the other lights that the points agree about.
    pub trust: Trust,
}

/// Whom the mesh is believed about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trust {
    /// Lights that all points agree about and that do not give much.
    Agreed,
    /// Nobody: one ray for every [`Care::much`] of the light that is agreed about. The expectation is exact.
    Nobody,
}

impl Care {
    /// That of the hybrid method: docs/accuracy.md has what each rule costs and brings.
    pub(crate) const HYBRID: Self = Self { quantum: 0.003, much: 0.18, trust: Trust::Agreed };
}

/// Buffers, one set per worker, kept between calls.
#[derive(Debug, Default)]
pub(super) struct ByLight {
    terms: Vec<Term>,
    /// What is chosen among, and how likely: first the terms, then the blocks of lights that are agreed about.
    masses: Vec<f32>,
    sums: Vec<BlockSum>,
    estimates: Vec<f32>,
    /// What each ray's visibility is multiplied with, and the visibility that is expected of it.
    weights: Vec<Vec3>,
    expected: Vec<f32>,
    rays: Vec<Ray>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
}

impl ByLight {
    /// Direct irradiance, lux per channel, with rays to the lights that are disputed or give much; and how many rays these were.
    pub(super) fn with_care(
        &mut self,
        scene: &Scene,
        falloff: Falloff,
        vertex: &Vertex,
        agreement: &Agreement,
        (care, seed): (Care, u32),
    ) -> (Vec3, u64) {
        let (lights, receiver) = (scene.lights(), receiver(vertex, falloff, agreement));
        let (sure, disputed) = (&agreement.sure, &agreement.disputed);
        let (terms, sums) = (&mut self.terms, &mut self.sums);
        let mut sum = lights.weighted_irradiance(scene.level(), &receiver, sure, disputed, terms, sums);
        self.clear_rays();
        let total = self.sums.iter().map(|block| block.mass).sum::<f32>()
            + self.terms.iter().map(|term| term.mass).sum::<f32>();

        // What is disputed: a ray to each light that matters; of the others one for every quantum of doubt.
        let quantum = care.quantum * total;
        let mut next = quantum * random(seed, 0);
        for term in &self.terms {
            let v = agreement.estimate(term);
            let lane = term.lane as usize;
            let c = lights.intensity(lane) * term.factor;
            let doubt = term.mass * if term.index.is_some() { 2.0 * (v * (1.0 - v)).sqrt() } else { 1.0 };
            let (weight, expected) = if doubt >= quantum {
                (c, 0.0)
            } else {
                sum += c * v;
                next -= doubt;
                if next >= 0.0 {
                    continue;
                }
                next += quantum;
                (c * (quantum / doubt), v)
            };
            self.rays.push(lights.shadow_ray(lane, vertex.origin_towards(term.direction)));
            self.weights.push(weight);
            self.expected.push(expected);
        }

        // What is agreed about: a ray to each light that gives much; of the others, where nobody is believed, one for each such
        // part of the light.
        let much = care.much * total;
        let mut next = if care.trust == Trust::Agreed { f32::INFINITY } else { much * random(seed, 1) };
        for block in 0..self.sums.len() {
            let BlockSum { mass, terms } = self.sums[block];
            if mass < much && mass <= next {
                next -= mass;
                continue;
            }
            let factors = lights.block_terms(scene.level(), &receiver, block);
            for (i, (direction, factor)) in factors.into_iter().enumerate() {
                let lane = block * LANES + i;
                let c = lights.intensity(lane) * factor;
                let mass = c.element_sum() / 3.0;
                if mass <= 0.0 || terms >> i & 1 != 0 {
                    continue;
                }
                let weight = if mass >= much {
                    c
                } else {
                    next -= mass;
                    if next >= 0.0 {
                        continue;
                    }
                    next += much;
                    c * (much / mass)
                };
                self.rays.push(lights.shadow_ray(lane, vertex.origin_towards(direction)));
                self.weights.push(weight);
                self.expected.push(sure[lane]);
            }
        }
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        for ((&c, &v), &expected) in self.weights.iter().zip(&self.visible).zip(&self.expected) {
            sum += c * (v - expected);
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
        let (lights, receiver) = (scene.lights(), receiver(vertex, falloff, agreement));
        let Self { terms, masses, sums, estimates, .. } = self;
        let (sure, disputed) = (&agreement.sure, &agreement.disputed);
        let mut sum = lights.weighted_irradiance(scene.level(), &receiver, sure, disputed, terms, sums);
        masses.clear();
        masses.extend(sums.iter().map(|block| block.mass * DOUBT));

        // Disputed lights: their mean, and how much there is to gain from a ray.
        estimates.clear();
        for term in terms.iter() {
            let c = lights.intensity(term.lane as usize) * term.factor;
            let v = agreement.estimate(term);
            sum += c * v;
            estimates.push(v);
            let least = if term.index.is_some() { 0.0 } else { DOUBTFUL };
            masses.push(term.mass * ((v * (1.0 - v)).sqrt().max(least) + DOUBT));
        }
        let total: f32 = self.masses.iter().sum();
        if total <= 0.0 {
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
            if mass <= 0.0 {
                continue;
            }
            let p = mass / total;
            let (lane, direction, weight, expected) = if entry < blocks {
                let Some((lane, direction, factor, share)) = self.choose_in_block(scene, &receiver, entry, v) else {
                    continue;
                };
                (lane, direction, factor / (p * share), sure[lane])
            } else {
                let term = self.terms[entry - blocks];
                (term.lane as usize, term.direction, term.factor / p, self.estimates[entry - blocks])
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
        block: usize,
        u: f32,
    ) -> Option<(usize, Vec3, f32, f32)> {
        let lights = scene.lights();
        let terms = lights.block_terms(scene.level(), receiver, block);
        let mass = |i: usize| {
            let lane = block * LANES + i;
            if self.sums[block].terms >> i & 1 != 0 {
                0.0
            } else {
                lights.intensity(lane).element_sum() / 3.0 * terms[i].1
            }
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

fn receiver(vertex: &Vertex, falloff: Falloff, agreement: &Agreement) -> Receiver {
    Receiver { position: vertex.position, n: vertex.n, ng: vertex.ng, doubt: agreement.doubt, falloff }
}

/// The i-th number in [0, 1) of a seed.
fn random(seed: u32, i: u32) -> f32 {
    (hash(seed ^ hash(i.wrapping_mul(0x9e37_79b9).wrapping_add(1))) >> 8) as f32 * (1.0 / (1 << 24) as f32)
}
