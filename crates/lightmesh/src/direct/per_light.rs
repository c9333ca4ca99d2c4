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
//! Of many lights, light i may be a cluster (`light_mesh/region_lights.rs`). A ray to it goes to one of its lights, whose own c_k over the
//! probability that it was chosen takes the place of c_i. *Unbiased* puts it where c_i is multiplied by V, and not where it is subtracted: the
//! expectation is still the exact sum over all lights, whatever stands for the cluster. *Hybrid* puts it in both places: less noise (1.37
//! instead of 1.50% in paper5000_10000, and `--error` needs no exact light there), and the error of the unshadowed sum stays.

mod control_variate;

use control_variate::Single;
use fearless_simd::Simd;
use glam::Vec3;

use super::region_visibility::LightCutVisibility;
use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{ShadingPoint, VisibilityScratch, visibility};
use crate::light::{BlockTerms, LANES, LightTerms, Receiver};
use crate::sampling::{hash, set_bits, unit_f32};
use crate::world::Scene;

/// How much of the light at a surface the mesh is believed about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SamplingPolicy {
    /// Of disputed lights, each that gives this part of all light (unshadowed), or more, gets a ray, and the others together one
    /// for each such part.
    pub step: f32,
    /// A light that gives this part or more gets a ray whatever the points agree on: in the open, and where something stands near.
    pub always_above: [f32; 2],
    /// What of the other lights that the points agree about.
    pub agreement: TrustAgreement,
}

/// Whom the mesh is believed about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TrustAgreement {
    /// Lights that all points agree about and that do not give much.
    Yes,
    /// Nobody: one ray for every [`SamplingPolicy::always_above`] of the light that is agreed about. The expectation is exact, but for what
    /// clusters are off.
    Unbiased,
}

impl SamplingPolicy {
    /// That of the hybrid method: docs/accuracy.md has what each rule costs and brings.
    pub(crate) const HYBRID: Self = Self { step: 0.0035, always_above: [0.3, 0.12], agreement: TrustAgreement::Yes };
}

/// Rays that wait to be shot, at most, but for those of one surface.
const RAYS: usize = 4096;

/// Rays to the lights of a cluster that gives much or is in much doubt, at most. Empirical, not varied.
const RAYS_PER_CLUSTER: f32 = 16.0;

/// Buffers, one set per worker, kept between calls. Rays of many surfaces are shot together.
#[derive(Debug, Default)]
pub(super) struct PerLightShader {
    terms: LightTerms,
    rays: Vec<Ray>,
    queue: Vec<QueuedRay>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
    /// What is chosen among, and how likely: first the blocks' lights that are agreed about, then the others.
    contributions: Vec<f32>,
    singles: Vec<Single>,
}

/// What is done with a ray's visibility V: weight · (V − expected) is added to the light of a surface.
#[derive(Clone, Copy, Debug)]
struct QueuedRay {
    weight: Vec3,
    expected: f32,
    surface: u32,
}

/// What is lit.
#[derive(Clone, Copy)]
pub(super) struct Shaded<'a> {
    pub scene: &'a Scene,
    pub falloff: Falloff,
    pub vertex: &'a ShadingPoint,
    /// Its number among those that are lit together.
    pub surface: u32,
    /// The lights, and what the points around it know of them.
    pub lights: LightCutVisibility<'a>,
    pub seed: u32,
    /// Where its rays start: [`ShadingPoint::origins`].
    pub origins: [Vec3; 2],
}

impl Shaded<'_> {
    fn receiver(&self) -> Receiver {
        let ShadingPoint { position, n, ng, .. } = *self.vertex;
        Receiver { position, n, ng, occluder_direction: self.lights.estimate.occluder_direction, falloff: self.falloff }
    }

    /// Where a ray towards `direction` starts.
    #[inline(always)]
    fn origin_towards(&self, direction: Vec3) -> Vec3 {
        self.origins[usize::from(self.vertex.ng.dot(direction) < 0.0)]
    }

    /// The i-th random number, in [0, 1).
    fn random(&self, i: u32) -> f32 {
        unit_f32(hash(self.seed ^ hash(i.wrapping_mul(0x9e37_79b9).wrapping_add(1))))
    }

    /// The i-th random number for a node of the light tree, in [0, 1).
    fn random_in(&self, node: u32, i: u32) -> f32 {
        unit_f32(hash(hash(self.seed ^ hash(node)).wrapping_add(i)))
    }
}

impl PerLightShader {
    /// Direct irradiance, lux per channel, as far as it is known; rays to the lights that are disputed or give much wait for
    /// [`PerLightShader::shoot`].
    #[inline(always)]
    pub(super) fn sample_by_policy<S: Simd>(&mut self, simd: S, lit: &Shaded<'_>, care: SamplingPolicy) -> Vec3 {
        let LightCutVisibility { lights, estimate: agreement, .. } = lit.lights;
        let mut terms = std::mem::take(&mut self.terms);
        let (mut sum, total) = terms.evaluate(simd, lights, &lit.receiver(), &agreement.certain);

        let (quantum, much) = (care.step * total, care.always_above[usize::from(agreement.near_occluder)] * total);
        // How much doubt, and how much of what is agreed about, goes by until the next ray.
        let mut next_doubt = None;
        let mut next = if care.agreement == TrustAgreement::Yes { f32::INFINITY } else { much * lit.random(1) };
        let mut dispute = 0;
        for (at, (block, &disputed)) in terms.blocks().iter().zip(agreement.partial()).enumerate() {
            let first = at * LANES;
            let mut agreed = block.contribution;

            // What is disputed: a ray to each light that matters; of the others one for every quantum of doubt.
            let singles = disputed | block.towards_occluder;
            for i in set_bits::<LANES>(singles) {
                let is_disputed = disputed >> i & 1 != 0;
                let number = dispute;
                dispute += usize::from(is_disputed);
                let mass = block.contributions[i];
                if mass <= 0.0 {
                    continue;
                }
                agreed -= mass;
                let c = lights.intensity(first + i) * block.factors[i];
                let (v, doubt) = if is_disputed {
                    let v = agreement.estimate(number);
                    sum += c * v;
                    (v, 2.0 * mass * (v * (1.0 - v)).sqrt())
                } else {
                    (agreement.certain[first + i], mass)
                };
                let mut scale = 1.0;
                if doubt < quantum {
                    let next = next_doubt.get_or_insert_with(|| quantum * lit.random(0));
                    *next -= doubt;
                    if *next >= 0.0 {
                        continue;
                    }
                    *next += quantum;
                    scale = quantum / doubt;
                }
                sum -= self.queue_shadow_ray(lit, block, (first, i), (c * scale, scale), (v, 0, Some(doubt / quantum)));
            }

            // What is agreed about: a ray to each light that gives much; of the others, where nobody is believed, one for each
            // such part of the light.
            let giving = block.giving(simd, much) & !singles;
            if giving == 0 && agreed <= next {
                next -= agreed;
                continue;
            }
            let looked_at = if care.agreement == TrustAgreement::Yes { giving } else { !singles & ((1 << LANES) - 1) };
            for i in set_bits::<LANES>(looked_at) {
                let mass = block.contributions[i];
                if mass <= 0.0 {
                    continue;
                }
                let mut scale = 1.0;
                if mass < much {
                    next -= mass;
                    if next >= 0.0 {
                        continue;
                    }
                    next += much;
                    scale = much / mass;
                }
                let c = lights.intensity(first + i) * block.factors[i];
                sum -= self.queue_shadow_ray(
                    lit,
                    block,
                    (first, i),
                    (c * scale, scale),
                    (agreement.certain[first + i], 0, Some(mass / much)),
                );
            }
        }
        self.terms = terms;
        sum
    }

    /// Lets a ray to a light of a block wait. `weight` is what the light gives, times `scale`; it has been `expected` to this part. What
    /// the ray is for is weight · (V − expected) in the mean: of a cluster one light j is asked, chosen with probability p_j by the k-th
    /// random number for it, and c_j scale V_j / p_j takes the place of weight · V, without bias. If it is said how many rays it is `worth`,
    /// some lights are asked, and (V_j − expected) c_j scale / p_j is taken: where V is as expected there is no noise, and what is off is what the
    /// cluster's unshadowed light is off. What must be subtracted at once is returned.
    #[inline(always)]
    fn queue_shadow_ray(
        &mut self,
        lit: &Shaded<'_>,
        block: &BlockTerms,
        (first, i): (usize, usize),
        (weight, scale): (Vec3, f32),
        (expected, k, worth): (f32, u32, Option<f32>),
    ) -> Vec3 {
        let LightCutVisibility { lights, clusters, .. } = lit.lights;
        if let Some(clusters) = clusters
            && let Some(node) = clusters.node(first + i)
        {
            let rays = worth.unwrap_or(1.0).clamp(1.0, RAYS_PER_CLUSTER.min(clusters.count(node) as f32)).round();
            let u = lit.random_in(node, k);
            for ray in 0..rays as u32 {
                let chosen = clusters.choose(node, (ray as f32 + u) / rays);
                match worth {
                    Some(_) => self.queue_cluster_ray(lit, chosen, scale / rays, expected),
                    None => self.queue_cluster_ray(lit, chosen, scale, 0.0),
                }
            }
            return if worth.is_some() { Vec3::ZERO } else { weight * expected };
        }
        self.rays.push(lights.shadow_ray(first + i, lit.origin_towards(block.direction(i))));
        self.queue.push(QueuedRay { weight, expected, surface: lit.surface });
        Vec3::ZERO
    }

    /// Lets a ray wait to one of the scene's samples, chosen with a probability, of a cluster.
    fn queue_cluster_ray(&mut self, lit: &Shaded<'_>, (lane, p): (usize, f32), scale: f32, expected: f32) {
        let ShadingPoint { position, n, .. } = *lit.vertex;
        let samples = lit.scene.lights();
        let Some(luminaire) = samples.sample(lane) else { return };
        let (direction, f) = luminaire.arriving(lit.falloff, position);
        let c = luminaire.intensity * (f * n.dot(direction).max(0.0));
        if c == Vec3::ZERO || p <= 0.0 {
            return;
        }
        self.rays.push(samples.shadow_ray(lane, lit.origin_towards(direction)));
        self.queue.push(QueuedRay { weight: c * (scale / p), expected, surface: lit.surface });
    }

    /// Whether so many rays wait that they should be shot.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.rays.len() >= RAYS
    }

    /// Shoots the rays that wait and adds what they find to the irradiance of their surfaces, lux; how many they were.
    pub(crate) fn shoot(&mut self, scene: &Scene, irradiance: &mut [Vec3]) -> u64 {
        visibility(scene, &self.rays, &mut self.shadow, &mut self.visible);
        for (&QueuedRay { weight, expected, surface }, &v) in self.queue.iter().zip(&self.visible) {
            irradiance[surface as usize] += weight * (v - expected);
        }
        let count = self.rays.len() as u64;
        self.rays.clear();
        self.queue.clear();
        count
    }
}
