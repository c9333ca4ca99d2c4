//! Rays from a mesh point to bright spots, beside its even ones.
//!
//! Both kinds may find the same light: where n even rays and n_s rays to each spot s were shot, light along ω counts with
//! 1 / (n / 4π + Σ n_s p_s(ω)), whichever ray has found it (the balance heuristic: Veach 1997, eq. 9.8). The expectation
//! stays what it is with even rays alone, wherever the spots are, but for one thing: how many rays a spot gets depends on
//! what the even rays found, which left +0.6 to +1.1% of bias in the rooms of docs/measurements/gather.md. Only emission and direct light are weighed so: what
//! comes after further bounces is smooth, and even rays serve it.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::gather::GatherRays;
use super::spots::SpotDirections;
use super::spots::{BrightSpot, BrightSpots, SpotShape};
use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::sampling::{hash, unit_f32};
use crate::{RenderOptions, Scene};

/// Spots that get rays of a point, at most: the most important ones. Five left white blobs in a room with six lamps in
/// cans, each of which is two spots.
const MOST_SPOTS: usize = 12;

/// Spots of which it is found out whether the point sees them, at most.
const MOST_CANDIDATES: usize = 24;

/// A spot as large as so many of the cells that even rays stand for needs no others; and a patch of sunlight, which may light
/// all the rest.
const LARGE: f32 = 0.7;
const LARGE_PATCH: f32 = 8.0;

/// A spot gets rays where its noise in even rays would be this part of the light, or more.
const LEAST_NOISE: f32 = 0.1;

/// Or where a single even ray that meets it brings this part of the light: a blob, however rare. Empirical.
const LEAST_BLOB: f32 = 0.3;

/// A ray that brings more than so many times the mean counts as so many in the first, low guess of all light: it may
/// have met a spot by chance.
const MOST_TIMES_MEAN: f32 = 8.0;

/// Rays to a spot that gives all light, and to one spot.
const RAYS: f32 = 64.0;
const RAYS_PER_SPOT: std::ops::RangeInclusive<f32> = 2.0..=24.0;

/// How many times as many a patch of sunlight gets: it may give nearly all light, and a part of its rectangle is in the shade.
const PATCH_TIMES: f32 = 2.5;

/// Rays to each spot in the first estimate of all light.
const TENTATIVE: f32 = 4.0;

/// The rays of one point to its bright spots; and how much even rays count beside them.
#[derive(Debug, Default)]
pub(super) struct GuidedRays {
    /// The rays; their lobes are their directions over the density of all rays.
    pub rays: GatherRays,
    /// By even ray; empty where there are no others.
    weights: Vec<f32>,
}

/// A spot and how many rays it gets.
struct Guide {
    spot: BrightSpot,
    directions: SpotDirections,
    irradiance: f32,
    /// The noise of its light, were there only even rays, in units of its light.
    even_noise: f32,
    rays: f32,
}

impl Guide {
    /// Whether even rays alone do not serve the spot, among so much light of all kinds.
    fn matters_in(&self, irradiance: f32) -> bool {
        let noise = self.irradiance * self.even_noise;
        noise > LEAST_NOISE * irradiance || noise * self.even_noise * self.spot.contrast > LEAST_BLOB * irradiance
    }
}

/// The density per steradian of all rays of a point.
struct Mixture<'a> {
    /// Of even rays.
    even: f32,
    guides: &'a [Guide],
}

impl Mixture<'_> {
    #[inline]
    fn density(&self, direction: Vec3) -> f32 {
        self.even + self.guides.iter().map(|g| g.rays * g.directions.pdf(direction)).sum::<f32>()
    }

    /// How much an even ray counts.
    fn weight(&self, direction: Vec3) -> f32 {
        self.even / self.density(direction)
    }
}

impl GuidedRays {
    /// Shoots rays to the spots that matter at the origin of some even rays, whose hits have their light.
    pub(super) fn shoot(scene: &Scene, options: &RenderOptions, spots: &BrightSpots, even: &GatherRays) -> Self {
        let mut guided = Self::default();
        let Some(x) = even.origin() else { return guided };
        let count = even.lobes.len() as f32;
        let density = count / (4.0 * PI);

        // Guess all light from below, so that spots that cannot matter take no time.
        let least_light = low_guess(even) / density;

        // List the spots that are small, the most noisy ones first.
        let mut guides: Vec<Guide> = spots
            .iter()
            .filter_map(|&spot| {
                let large = if matches!(spot.shape, SpotShape::Patch(_)) { LARGE_PATCH } else { LARGE };
                let view = spot.seen_from(x).filter(|view| view.solid_angle * density < large)?;
                let even_noise = 1.0 / (view.solid_angle * density).max(1e-6).sqrt();
                let directions = spot.directions_from(x);
                let guide = Guide { spot, directions, irradiance: view.irradiance, even_noise, rays: TENTATIVE };
                guide.matters_in(least_light).then_some(guide)
            })
            .collect();
        if guides.is_empty() {
            return guided;
        }
        // Stable: equal spots keep their order.
        guides.sort_by(|a, b| (b.irradiance * b.even_noise).total_cmp(&(a.irradiance * a.even_noise)));
        guides.truncate(MOST_CANDIDATES);
        // Leave hidden ones to even rays; the expectation is the same with any spots.
        let rays: Vec<Ray> = guides.iter().flat_map(|guide| guide.spot.rays_from(x)).collect();
        let (mut visible, mut scratch) = (Vec::new(), VisibilityScratch::default());
        visibility(scene, &rays, &mut scratch, &mut visible);
        let mut visible = visible.iter();
        guides.retain(|guide| {
            let seen: Vec<_> = visible.by_ref().take(guide.spot.rays_from(x).count()).collect();
            seen.is_empty() || seen.into_iter().any(|&v| v != Vec3::ZERO)
        });
        guides.truncate(MOST_SPOTS);
        if guides.is_empty() {
            return guided;
        }

        // Estimate all light, and give the spots rays by their parts of it.
        let mixture = Mixture { even: density, guides: &guides };
        let weights: Vec<f32> = even.directions().map(|direction| mixture.weight(direction)).collect();
        let emitted = even.emitted.iter().map(|&(ray, radiance)| weights[ray as usize] * radiance.max_element());
        let mut total: f32 = emitted.sum();
        for (hit, &irradiance) in even.hits.vertices.iter().zip(&even.hits.direct) {
            total += weights[hit.id as usize] * (hit.weight * irradiance).max_element();
        }
        total /= density;
        guides.retain_mut(|guide| {
            let share = (guide.irradiance / total.max(f32::MIN_POSITIVE)).min(1.0);
            let times = if matches!(guide.spot.shape, SpotShape::Patch(_)) { PATCH_TIMES } else { 1.0 };
            let (least, most) = (*RAYS_PER_SPOT.start(), times * RAYS_PER_SPOT.end());
            guide.rays = (times * RAYS * share).ceil().clamp(least, most);
            guide.matters_in(total)
        });
        if guides.is_empty() {
            return guided;
        }

        // Shoot them, and weigh both kinds.
        let mixture = Mixture { even: density, guides: &guides };
        let mut directions = Vec::new();
        for (s, guide) in (0..).zip(&guides) {
            let seed = hash(even.seed() ^ hash(!s));
            for k in 0..guide.rays as u32 {
                let height = (k as f32 + unit_f32(hash(seed ^ k))) / guide.rays;
                let azimuth = unit_f32(k.wrapping_mul(2_654_435_769).wrapping_add(seed));
                directions.extend(guide.directions.sample(Vec2::new(height, azimuth)));
            }
        }
        guided.weights.extend(even.directions().map(|direction| mixture.weight(direction)));
        guided.rays.towards(scene, options, even, &directions);
        for (lobe, &direction) in guided.rays.lobes.iter_mut().zip(&directions) {
            *lobe /= mixture.density(direction);
        }
        guided
    }

    /// How much the light counts that even ray number `id` finds.
    #[inline(always)]
    pub(super) fn weight(&self, id: u32) -> f32 {
        self.weights.get(id as usize).copied().unwrap_or(1.0)
    }
}

/// Sums what even rays bring, in the largest channel, but for what few of them bring alone.
fn low_guess(even: &GatherRays) -> f32 {
    let mut found = vec![0.0; even.lobes.len()];
    for &(ray, radiance) in &even.emitted {
        found[ray as usize] += radiance.max_element();
    }
    for (hit, &irradiance) in even.hits.vertices.iter().zip(&even.hits.direct) {
        found[hit.id as usize] += (hit.weight * irradiance).max_element();
    }
    let most = MOST_TIMES_MEAN * found.iter().sum::<f32>() / found.len().max(1) as f32;
    found.iter().map(|light| light.min(most)).sum()
}
