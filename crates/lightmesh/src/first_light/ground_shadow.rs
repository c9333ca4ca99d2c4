//! The shadow that a scene in the studio casts on the floor under it.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::Scene;
use crate::geometry::Ray;
use crate::interaction::{VisibilityScratch, visibility};
use crate::light::emitters::luminance;
use crate::sampling::{film_samples, hash};
use crate::world::GroundShadow;

/// Points along the longer side of the grid.
const SIDE: usize = 80;
/// Rays per point.
const RAYS: u32 = 48;
/// Light that the floor keeps in full shadow: what would reach it from the scene's own walls.
const LEFT: f32 = 0.12;

/// Returns the shadow on a floor just under the scene's lowest point; `None` for scenes without height and breadth, and
/// for those without an environment.
///
/// Each point estimates the part of the irradiance that the scene lets through, with rays towards the environment in
/// proportion to its luminance, turned by a random amount of its own, so that no outline shows twice; neighbours are
/// then averaged.
pub(super) fn of(scene: &Scene) -> Option<GroundShadow> {
    let environment = scene.emitters().environment.as_ref()?;
    let bounds = scene.bounds();
    let size = bounds.size();
    // As far as the key light, 50° up, throws a shadow, and its soft edge.
    let margin = 1.1 * size.y + 0.25 * size.x.max(size.z);
    let (width, depth) = (size.x + 2.0 * margin, size.z + 2.0 * margin);
    let step = width.max(depth) / (SIDE - 1) as f32;
    if !(step > 0.0 && step.is_finite()) {
        return None;
    }
    let count = |length: f32| ((length / step).ceil() as usize + 1).clamp(2, SIDE);
    let (columns, rows) = (count(width), count(depth));
    let center = bounds.center();
    let first = Vec2::new(center.x, center.z) - 0.5 * step * Vec2::new((columns - 1) as f32, (rows - 1) as f32);
    // Below what lies on the floor.
    let y = bounds.min.y - 1e-3 * step - 4.0 * f32::EPSILON * bounds.min.y.abs();

    // Sample every point.
    let samples = film_samples(RAYS);
    let unit = |bits: u32| (bits >> 8) as f32 * (1.0 / (1 << 24) as f32);
    let noisy: Vec<f32> = (0..rows * columns)
        .into_par_iter()
        .map_init(
            || (Vec::new(), Vec::new(), VisibilityScratch::default(), Vec::new()),
            |(rays, weights, scratch, passed), i| {
                let xz = first + step * Vec2::new((i % columns) as f32, (i / columns) as f32);
                let origin = Vec3::new(xz.x, y, xz.y);
                let scramble = [hash(i as u32), hash(hash(i as u32))];
                rays.clear();
                weights.clear();
                for [a, b] in &samples {
                    let u = Vec2::new(unit(a ^ scramble[0]), unit(b ^ scramble[1]));
                    let (direction, pdf) = environment.sample(u);
                    if direction.y > 0.0 && pdf > 0.0 {
                        rays.push(Ray::new(origin, direction));
                        weights.push(luminance(environment.radiance(direction)) * direction.y / pdf);
                    }
                }
                visibility(scene, rays, scratch, passed);
                let all: f32 = weights.iter().sum();
                let seen: f32 = weights.iter().zip(&*passed).map(|(w, p)| w * luminance(*p)).sum();
                if all > 0.0 { seen / all } else { 1.0 }
            },
        )
        .collect();

    // Average neighbours, and end in full light at the edge.
    let smooth = |i: usize| {
        let (x, z) = (i % columns, i / columns);
        let tent = |d: usize| if d == 1 { 2.0 } else { 1.0 };
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dx, dz) in (0..9).map(|k| (k % 3, k / 3)) {
            let (x, z) = ((x + dx).clamp(1, columns) - 1, (z + dz).clamp(1, rows) - 1);
            let weight = tent(dx) * tent(dz);
            (sum, weights) = (sum + weight * noisy[z * columns + x], weights + weight);
        }
        let edge = x.min(z).min(columns - 1 - x).min(rows - 1 - z) as f32 / (0.1 * SIDE as f32);
        let fade = (1.0 - edge).max(0.0);
        let visible = LEFT + (1.0 - LEFT) * (sum / weights);
        visible + (1.0 - visible) * fade
    };
    let visible = (0..rows * columns).map(smooth).collect();
    Some(GroundShadow { y, first, step: Vec2::splat(step), columns, visible })
}
