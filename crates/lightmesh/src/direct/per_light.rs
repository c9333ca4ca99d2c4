//! Direct light from the mesh's visibility of each single light, with shadow rays where that is not enough.
//!
//! Both methods begin with Σ_i V̂_i c_i, where c_i is the unshadowed light of light i (a term of formula (2)) and V̂_i
//! in [0, 1] its visibility estimate from the mesh points around the surface. They differ in the rays that they trace:
//!
//! - *hybrid*: a ray to every partial light, whose V̂_i is then replaced by V_i; of those that give little light only
//!   some, chosen by how much a ray is expected to change (below), so that the others count without bias. The estimate
//!   of a certain light is kept, unless the light is below the surface, beyond points that are hidden from it, or gives
//!   much of the light: what is thinner than the mesh can be missed;
//! - *unbiased*: K rays whatever the estimate is, to lights j chosen with probability p_j, and the mean of (V_j − V̂_j)
//!   c_j / p_j is added: the mesh is a control variate of light sampling, and the expectation is the exact sum whatever
//!   V̂ is.
//!
//! Of many lights, light i may be a cluster (`region_visibility.rs`). A ray to it goes to one of its lights k, and c_k
//! over the probability that k was chosen takes the place of c_i. *Unbiased* puts it where c_i is multiplied by V, and
//! not where it is subtracted: the expectation is still the exact sum over all lights, whatever stands for the cluster.
//! A light that stands for a part of an emitter ([`Stratum`]) is treated as *unbiased* treats clusters: the ray goes to a
//! random point of the part, whose own light replaces c_i where that is multiplied by V. Of clusters,
//! *hybrid* puts it in both places: less noise (1.37 instead of 1.50% in the room of 10,000 lights, and `--error` needs
//! no exact light there), and the error of the unshadowed sum stays.

mod control_variate;

use control_variate::SingleLight;
use fearless_simd::Simd;
use glam::Vec3;

use super::region_visibility::{ClusterLight, LightCutVisibility};
use super::visibility_estimate::VisibilityEstimate;
use crate::Falloff;
use crate::geometry::Ray;
use crate::interaction::{ShadingPoint, VisibilityScratch, visibility};
use crate::light::{BlockTerms, LANES, LightTerms, Receiver, SampledLight, Stratum, shadow_ray_to};
use crate::sampling::{hash, set_bits, unit_f32};
use crate::world::Scene;

/// Which lights get a shadow ray although the mesh has an estimate of their visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SamplingPolicy {
    /// A partial light whose ray is expected to change this part of all light (unshadowed, but at most
    /// [`MOST_BLOCKED`] times what arrives), or more, gets a ray, and the others together one for each such part.
    pub step: f32,
    /// A certain light that gives this part of all light or more gets a ray: in the open, and where something stands
    /// near.
    pub always_above: [f32; 2],
    /// What happens to the other certain lights.
    pub agreement: TrustAgreement,
}

/// Whether the estimate is final where all points agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TrustAgreement {
    /// It is, for certain lights that do not give much.
    Yes,
    /// It is not: one ray for every [`SamplingPolicy::always_above`] of the light of certain lights. The expectation is
    /// exact, but for the error of clusters.
    Unbiased,
}

impl SamplingPolicy {
    /// That of the hybrid method: docs/accuracy.md has what each rule costs and brings.
    pub(crate) const HYBRID: Self = Self { step: 0.0035, always_above: [0.3, 0.12], agreement: TrustAgreement::Yes };
}

/// The rays in the queue, at most, but for those of one surface.
const RAYS: usize = 4096;

/// How many times the light that arrives the unshadowed light may be, that noise is measured against. Empirical, not
/// varied: scenes whose lamps are mostly seen are not to take more rays than before.
const MOST_BLOCKED: f32 = 8.0;

/// Rays to the lights of a cluster that gives much or is very uncertain, at most. Empirical, not varied.
const RAYS_PER_CLUSTER: f32 = 16.0;

/// Buffers, one set per worker, kept between calls. Rays of many surfaces are traced together.
#[derive(Debug, Default)]
pub(super) struct PerLightShader {
    terms: LightTerms,
    rays: Vec<Ray>,
    queue: Vec<QueuedRay>,
    visible: Vec<Vec3>,
    shadow: VisibilityScratch,
    /// The choices of *unbiased*, each with a number in proportion to its probability: first the certain lights of each
    /// block together, then `singles`.
    contributions: Vec<f32>,
    singles: Vec<SingleLight>,
}

/// What is done with a ray's visibility V: weight · (V − expected) is added to the light of a surface.
#[derive(Clone, Copy, Debug)]
struct QueuedRay {
    weight: Vec3,
    expected: f32,
    surface: u32,
}

/// A shadow ray to a light of a block, before it is queued.
#[derive(Clone, Copy, Debug)]
struct ShadowRequest<'a> {
    block: &'a BlockTerms,
    /// The lane of the block's first light.
    first_lane: usize,
    /// Which of the block's lights.
    i: usize,
    /// The light's unshadowed irradiance, times `scale`.
    weight: Vec3,
    /// One over the probability of the ray.
    scale: f32,
    /// The light's V̂, which the sum has already.
    expected: f32,
    in_cluster: ClusterSampling,
}

/// How the lights of a cluster are chosen, if the light of a request is one.
#[derive(Clone, Copy, Debug)]
enum ClusterSampling {
    /// One light, by the k-th random number for its node. Its own light takes the place of the cluster's where that is
    /// multiplied by V, without bias.
    One { k: u32 },
    /// About this many lights. Their own light takes the place of the cluster's for V and for V̂: no noise where V is
    /// as expected, and the error of the cluster's unshadowed light stays.
    Some { rays: f32 },
}

/// A surface point to be shaded.
#[derive(Clone, Copy)]
pub(super) struct Shaded<'a> {
    pub scene: &'a Scene,
    pub falloff: Falloff,
    pub vertex: &'a ShadingPoint,
    /// Its index in the batch.
    pub surface: u32,
    /// The lights with their visibility estimate.
    pub lights: LightCutVisibility<'a>,
    pub seed: u32,
}

impl Shaded<'_> {
    /// Returns the point as lights receive it.
    fn receiver(&self) -> Receiver {
        let ShadingPoint { position, n, ng, .. } = *self.vertex;
        Receiver { position, n, ng, occluder_direction: self.lights.estimate.occluder_direction, falloff: self.falloff }
    }

    /// Returns where a ray towards `direction` starts.
    #[inline(always)]
    fn origin_towards(&self, direction: Vec3) -> Vec3 {
        self.vertex.light_origin(direction)
    }

    /// Returns the i-th random number, in [0, 1).
    fn random(&self, i: u32) -> f32 {
        unit_f32(hash(self.seed ^ hash(i.wrapping_mul(0x9e37_79b9).wrapping_add(1))))
    }

    /// Returns the i-th random number for a node of the light tree, in [0, 1).
    fn random_in(&self, node: u32, i: u32) -> f32 {
        unit_f32(hash(hash(self.seed ^ hash(node)).wrapping_add(i)))
    }
}

impl PerLightShader {
    /// Returns Σ V̂_i c_i, lux per channel, less what the queued rays will replace; [`PerLightShader::trace`] adds what
    /// they find.
    #[inline(always)]
    pub(super) fn sample_by_policy<S: Simd>(&mut self, simd: S, shaded: &Shaded<'_>, policy: SamplingPolicy) -> Vec3 {
        // Sum what is certain, and all light without shadows.
        let LightCutVisibility { lights, estimate, .. } = shaded.lights;
        let mut terms = std::mem::take(&mut self.terms);
        let (mut sum, total) = terms.evaluate(simd, lights, &shaded.receiver(), &estimate.certain);
        if lights.has_strata() {
            terms.raise_strata(simd, shaded.vertex.n, lights);
        }

        let step = policy.step * self.reference(&terms, estimate, sum, total);
        let always_above = policy.always_above[usize::from(estimate.near_occluder)] * total;
        // How much of the uncertain, and how much of the certain light passes until the next ray.
        let mut next_uncertain = None;
        let mut next_certain = match policy.agreement {
            TrustAgreement::Yes => f32::INFINITY,
            TrustAgreement::Unbiased => always_above * shaded.random(1),
        };
        let mut number = 0;
        for (block_index, (block, &partial)) in terms.blocks().iter().zip(estimate.partial()).enumerate() {
            let first_lane = block_index * LANES;
            let mut certain = block.contribution;

            // Add the partial lights, and queue a ray to each that matters; of the others one for every step.
            let singles = partial | block.towards_occluder;
            for i in set_bits::<LANES>(singles) {
                let is_partial = partial >> i & 1 != 0;
                let partial_number = number;
                number += usize::from(is_partial);
                let contribution = block.contributions[i];
                if contribution <= 0.0 {
                    continue;
                }
                certain -= contribution;
                let c = lights.intensity(first_lane + i) * block.factors[i];
                let (v, uncertainty) = if is_partial {
                    let v = estimate.estimate(partial_number);
                    sum += c * v;
                    (v, 2.0 * contribution * (v * (1.0 - v)).sqrt())
                } else {
                    (estimate.certain[first_lane + i], contribution)
                };
                // What seems to be certain has no share in the noise, unless that is wrong.
                let step = if is_partial { step } else { policy.step * total };
                let mut scale = 1.0;
                if uncertainty < step {
                    // In steps, so that partial and certain lights can be counted together.
                    let next = next_uncertain.get_or_insert_with(|| shaded.random(0));
                    *next -= uncertainty / step;
                    if *next >= 0.0 {
                        continue;
                    }
                    *next += 1.0;
                    scale = step / uncertainty;
                }
                let in_cluster = ClusterSampling::Some { rays: uncertainty / step };
                let request = ShadowRequest { block, first_lane, i, weight: c * scale, scale, expected: v, in_cluster };
                sum -= self.queue_shadow_ray(shaded, request);
            }

            // Queue a ray to each certain light that gives much; where agreement is not trusted, of the others one for
            // each such part of the light.
            let giving = block.giving(simd, always_above) & !singles;
            if giving == 0 && certain <= next_certain {
                next_certain -= certain;
                continue;
            }
            let candidates = match policy.agreement {
                TrustAgreement::Yes => giving,
                TrustAgreement::Unbiased => !singles & ((1 << LANES) - 1),
            };
            for i in set_bits::<LANES>(candidates) {
                let contribution = block.contributions[i];
                if contribution <= 0.0 {
                    continue;
                }
                let mut scale = 1.0;
                if contribution < always_above {
                    next_certain -= contribution;
                    if next_certain >= 0.0 {
                        continue;
                    }
                    next_certain += always_above;
                    scale = always_above / contribution;
                }
                let c = lights.intensity(first_lane + i) * block.factors[i];
                let expected = estimate.certain[first_lane + i];
                let in_cluster = ClusterSampling::Some { rays: contribution / always_above };
                let request = ShadowRequest { block, first_lane, i, weight: c * scale, scale, expected, in_cluster };
                sum -= self.queue_shadow_ray(shaded, request);
            }
        }
        self.terms = terms;
        sum
    }

    /// Returns the light that noise is measured against: all `unshadowed` light, but at most so many times what arrives,
    /// of which `certain` is a part; mean over the channels. Daylight outside a closed room must not make the noise of
    /// the lamp in it.
    #[inline(always)]
    fn reference(&self, terms: &LightTerms, estimate: &VisibilityEstimate, certain: Vec3, unshadowed: f32) -> f32 {
        let mut arriving = certain.element_sum() / 3.0;
        if unshadowed <= MOST_BLOCKED * arriving {
            return unshadowed;
        }
        let mut number = 0;
        for (block, &partial) in terms.blocks().iter().zip(estimate.partial()) {
            for i in set_bits::<LANES>(partial) {
                arriving += block.contributions[i] * estimate.estimate(number);
                number += 1;
            }
        }
        // Where nothing seems to arrive, there is nothing to compare with.
        if arriving > 0.0 { unshadowed.min(MOST_BLOCKED * arriving) } else { unshadowed }
    }

    /// Queues a ray whose result will be weight · (V − expected) in the mean; to a cluster, rays to some of its lights
    /// j, each chosen with a probability p_j, with c_j scale / p_j in place of the weight. Returns what is to be
    /// subtracted from the sum at once: weight · expected, where the rays only bring weight · V.
    #[inline(always)]
    fn queue_shadow_ray(&mut self, shaded: &Shaded<'_>, request: ShadowRequest<'_>) -> Vec3 {
        let ShadowRequest { block, first_lane, i, weight, scale, expected, in_cluster } = request;
        let LightCutVisibility { lights, clusters, .. } = shaded.lights;
        // Of a cluster, choose single lights.
        if let Some(clusters) = clusters
            && let Some(node) = clusters.node(first_lane + i)
        {
            match in_cluster {
                ClusterSampling::Some { rays } => {
                    let rays = rays.clamp(1.0, RAYS_PER_CLUSTER.min(clusters.count(node) as f32)).round();
                    let u = shaded.random_in(node, 0);
                    for ray in 0..rays as u32 {
                        let light = clusters.choose(node, (ray as f32 + u) / rays);
                        self.queue_cluster_ray(shaded, light, scale / rays, expected);
                    }
                    return Vec3::ZERO;
                }
                ClusterSampling::One { k } => {
                    let light = clusters.choose(node, shaded.random_in(node, k));
                    self.queue_cluster_ray(shaded, light, scale, 0.0);
                    return weight * expected;
                }
            }
        }

        // A single light that stands for a part of an emitter: trace a random point of that.
        let samples = shaded.scene.lights();
        if samples.has_strata() {
            let lane = clusters.map_or(first_lane + i, |clusters| clusters.sample(first_lane + i));
            if samples.stratum(lane) != Stratum::Point {
                // Parts of the sky get several where a window shows little of them.
                if let (ClusterSampling::Some { rays }, Stratum::Sky(_)) = (in_cluster, samples.stratum(lane)) {
                    let count = rays.round().clamp(1.0, RAYS_PER_CLUSTER);
                    for k in 0..count as u32 {
                        let emitters = shaded.scene.emitters();
                        let light = emitters.sky_direction(samples, lane, k, count as u32, shaded.seed);
                        self.queue_light(shaded, light, scale / count, 0.0);
                    }
                    return weight * expected;
                }
                let k = match in_cluster {
                    ClusterSampling::One { k } => k,
                    ClusterSampling::Some { .. } => 0,
                };
                let seed = shaded.seed ^ hash(hash(k));
                let light = shaded.scene.random_light(samples, lane, shaded.vertex.position, seed);
                let opposite = shaded.scene.emitters().opposite_point(samples, lane, shaded.vertex.position, seed);
                if opposite.is_some() {
                    self.queue_light(shaded, light, 0.5 * scale, 0.0);
                    self.queue_light(shaded, opposite, 0.5 * scale, 0.0);
                } else {
                    self.queue_light(shaded, light, scale, 0.0);
                }
                return weight * expected;
            }
        }

        // A point: trace it.
        self.rays.push(lights.shadow_ray(first_lane + i, shaded.origin_towards(block.direction(i))));
        self.queue.push(QueuedRay { weight, expected, surface: shaded.surface });
        Vec3::ZERO
    }

    /// Queues a ray to a light of a cluster.
    fn queue_cluster_ray(&mut self, shaded: &Shaded<'_>, light: ClusterLight, scale: f32, expected: f32) {
        let ClusterLight { lane, p } = light;
        let samples = shaded.scene.lights();
        let light = match samples.stratum(lane) {
            Stratum::Point => samples.sample(lane),
            _ => shaded.scene.random_light(samples, lane, shaded.vertex.position, shaded.seed),
        };
        if p > 0.0 {
            self.queue_light(shaded, light, scale / p, expected);
        }
    }

    /// Queues a ray to a light that is none of the lanes, with its own unshadowed irradiance times `scale` as weight;
    /// drops it where it gives none.
    fn queue_light(&mut self, shaded: &Shaded<'_>, light: Option<SampledLight>, scale: f32, expected: f32) {
        let Some(light) = light else { return };
        let ShadingPoint { position, n, .. } = *shaded.vertex;
        let (direction, f) = light.arriving(shaded.falloff, position);
        let c = light.intensity * (f * n.dot(direction).max(0.0));
        if c == Vec3::ZERO {
            return;
        }
        self.rays.push(shadow_ray_to(&light, shaded.origin_towards(direction)));
        self.queue.push(QueuedRay { weight: c * scale, expected, surface: shaded.surface });
    }

    /// Returns whether the queue is so long that it should be traced.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.rays.len() >= RAYS
    }

    /// Traces the queued rays and adds what they find to the irradiance of their surfaces, lux; returns how many they
    /// were.
    pub(super) fn trace(&mut self, scene: &Scene, irradiance: &mut [Vec3]) -> u64 {
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
