//! Patches of sunlight in a room: bright spots that few of evenly spread gather rays meet, and that light all the rest.
//!
//! Rays along the sunlight, evenly spread over the box of the room, find what it meets there. Neighbouring rays that end
//! in one plane are one patch, and a rectangle around it the spot; what else is lit, as round or thin things are, is in
//! balls.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::bright_spots::{BrightSpot, SpotShape};
use super::rectangle::Rectangle;
use crate::Scene;
use crate::geometry::{Aabb, Ray};
use crate::interaction::evaluate;
use crate::light::Stratum;
use crate::sampling::basis;

/// Rays along each side of the box's shadow.
const SIDE: usize = 128;

/// Suns, at most: the strongest parallel lights.
const MOST_SUNS: usize = 4;

/// A part of the sky counts as a sun where it is no larger than this, radians.
const SMALL: f32 = 0.1;

/// Patches of each sun, at most: those that reflect most.
const MOST_PATCHES: usize = 12;

/// Rays of a patch in a plane, at least, and of one in a ball.
const LEAST_RAYS: usize = 6;
const LEAST_RAYS_OF_BALL: usize = 2;

/// The cosine between the normals of surfaces in one plane, at least; and how many times a cell's diagonal neighbours in a ball
/// are apart, at most.
const SAME_NORMAL: f32 = 0.999;
const NEAR: f32 = 2.5;

/// Surfaces that a ray may pass through.
const PASSES: u32 = 8;

/// A place that sunlight meets.
#[derive(Clone, Copy)]
struct LitPlace {
    position: Vec3,
    n: Vec3,
    albedo: f32,
}

/// Looks for patches of sunlight in a box.
pub(in crate::indirect) fn sun_patches(scene: &Scene, bounds: &Aabb) -> Vec<BrightSpot> {
    // Choose the suns.
    let lights = scene.lights();
    let is_sun = |&lane: &usize| {
        let is_small = match lights.stratum(lane) {
            Stratum::Point => true,
            Stratum::Sky(_) => lights.radius(lane) < SMALL,
            _ => false,
        };
        is_small && lights.is_directional(lane) && lights.intensity(lane) != Vec3::ZERO
    };
    let strength = |lane: usize| lights.intensity(lane).max_element();
    let mut suns: Vec<usize> = (0..lights.lanes()).filter(is_sun).collect();
    suns.sort_by(|&a, &b| strength(b).total_cmp(&strength(a)));
    suns.truncate(MOST_SUNS);

    // Look where each shines.
    let towards = |lane: usize| lights.sample(lane).map(|light| (light.position, strength(lane)));
    suns.into_iter().filter_map(towards).flat_map(|(towards, lux)| patches_of(scene, bounds, towards, lux)).collect()
}

/// The patches of one sun, which is in the unit direction `towards`.
fn patches_of(scene: &Scene, bounds: &Aabb, towards: Vec3, lux: f32) -> Vec<BrightSpot> {
    // Measure the box's shadow.
    let (t, b) = basis(towards);
    let corners = (0..8).map(|k| {
        let upper = Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32);
        bounds.min + upper * bounds.size()
    });
    let projected: Vec<Vec2> = corners.map(|corner| Vec2::new(t.dot(corner), b.dot(corner))).collect();
    let min = projected.iter().copied().fold(Vec2::INFINITY, Vec2::min);
    let max = projected.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
    let cell = (max - min) / SIDE as f32;

    // Let the sun shine on it.
    let middle = 0.5 * (bounds.min + bounds.max);
    let all = scene.bounds();
    let away = all.size().length() + middle.distance(0.5 * (all.min + all.max));
    let slack = 1e-3 * bounds.size().max_element();
    let place = |i: usize| {
        let at = min + cell * Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5);
        let start = t * at.x + b * at.y + towards * (towards.dot(middle) + away);
        let place = first_opaque(scene, Ray::new(start, -towards))?;
        let is_inside =
            place.position.cmpge(bounds.min - slack).all() && place.position.cmple(bounds.max + slack).all();
        is_inside.then_some(place)
    };
    let places: Vec<Option<LitPlace>> = (0..SIDE * SIDE).into_par_iter().map(place).collect();

    // Put a rectangle around each patch in a plane, and a ball around each of what is left.
    let lumen = lux * cell.x * cell.y;
    let in_plane =
        |a: &LitPlace, b: &LitPlace| a.n.dot(b.n) > SAME_NORMAL && a.n.dot(b.position - a.position).abs() < slack;
    let near = |a: &LitPlace, b: &LitPlace| a.position.distance(b.position) < NEAR * cell.length();
    let spot = |patch: &[LitPlace], shape: SpotShape| BrightSpot {
        shape,
        flux: lumen * patch.iter().map(|place| place.albedo).sum::<f32>(),
        contrast: 1.0,
        mirror: None,
    };
    let mut left = places;
    let planes = take_connected(&mut left, LEAST_RAYS, in_plane);
    let balls = take_connected(&mut left, LEAST_RAYS_OF_BALL, near);
    let rectangles = planes.iter().filter_map(|patch| {
        let rectangle = rectangle_around(patch, towards, cell)?;
        Some(spot(patch, SpotShape::Patch(rectangle)))
    });
    let mut spots: Vec<BrightSpot> =
        rectangles.chain(balls.iter().map(|patch| spot(patch, ball_around(patch, cell)))).collect();
    spots.retain(|spot| spot.flux > 0.0);
    // Stable: equal patches keep their order.
    spots.sort_by(|a, b| b.flux.total_cmp(&a.flux));
    spots.truncate(MOST_PATCHES);
    spots
}

/// Follows sunlight through what is clear to the first surface.
fn first_opaque(scene: &Scene, mut ray: Ray) -> Option<LitPlace> {
    for _ in 0..=PASSES {
        let hit = scene.bvh().closest(&ray)?;
        let surface = evaluate(scene, &ray, &hit);
        if surface.refraction.max_element() + (1.0 - surface.opacity) <= 0.5 {
            return Some(LitPlace { position: surface.position, n: surface.ng, albedo: surface.diffuse.max_element() });
        }
        ray = surface.spawn_ray(ray.direction);
    }
    None
}

/// Takes groups of places out of the grid, of at least so many each: neighbours that belong to the first of the group.
fn take_connected(
    places: &mut [Option<LitPlace>],
    least: usize,
    belongs: impl Fn(&LitPlace, &LitPlace) -> bool,
) -> Vec<Vec<LitPlace>> {
    let mut is_seen = vec![false; places.len()];
    let mut groups = Vec::new();
    for first in 0..places.len() {
        let (Some(seed), false) = (places[first], is_seen[first]) else { continue };
        let (mut group, mut next) = (Vec::new(), vec![(first, seed)]);
        is_seen[first] = true;
        while let Some((i, place)) = next.pop() {
            group.push((i, place));
            for k in neighbours(i) {
                if let (Some(other), false) = (places[k], is_seen[k])
                    && belongs(&place, &other)
                {
                    is_seen[k] = true;
                    next.push((k, other));
                }
            }
        }
        if group.len() >= least {
            group.iter().for_each(|&(i, _)| places[i] = None);
            groups.push(group.into_iter().map(|(_, place)| place).collect());
        }
    }
    groups
}

/// The eight cells of the grid around one, less at its edge.
fn neighbours(i: usize) -> impl Iterator<Item = usize> {
    let (x, y) = ((i % SIDE) as isize, (i / SIDE) as isize);
    let is_inside = |c: isize| (0..SIDE as isize).contains(&c);
    let around = (0..9).filter(|k| *k != 4).map(move |k| (x + k % 3 - 1, y + k / 3 - 1));
    around.filter(move |&(x, y)| is_inside(x) && is_inside(y)).map(|(x, y)| y as usize * SIDE + x as usize)
}

/// The ball around some places, of which each stands for a `cell` of the sunlight.
fn ball_around(patch: &[LitPlace], cell: Vec2) -> SpotShape {
    let center = patch.iter().map(|place| place.position).sum::<Vec3>() / patch.len() as f32;
    let farthest = patch.iter().map(|place| place.position.distance(center)).fold(0.0, f32::max);
    SpotShape::Ball { center, radius: farthest + 0.5 * cell.length() }
}

/// The rectangle around some places in one plane, of which each stands for a `cell` of the sunlight; `None` where it shines
/// along the plane.
fn rectangle_around(patch: &[LitPlace], towards: Vec3, cell: Vec2) -> Option<Rectangle> {
    let n = patch.first()?.n;
    let cos = n.dot(towards);
    if cos <= 1e-3 {
        return None;
    }
    // Along the main axis of the places.
    let mean = patch.iter().map(|place| place.position).sum::<Vec3>() / patch.len() as f32;
    let (t, b) = basis(n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for place in patch {
        let d = place.position - mean;
        let (x, y) = (t.dot(d), b.dot(d));
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    let angle = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
    let u = t * libm::cosf(angle) + b * libm::sinf(angle);
    let v = n.cross(u);
    let range = |axis: Vec3| {
        let along = patch.iter().map(|place| axis.dot(place.position));
        along.fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), x| (min.min(x), max.max(x)))
    };
    // A cell reaches beyond its middle.
    let margin = 0.5 * cell.length() / cos.max(0.1);
    let [(u0, u1), (v0, v1)] = [range(u), range(v)];
    let center = mean + u * (0.5 * (u0 + u1) - u.dot(mean)) + v * (0.5 * (v0 + v1) - v.dot(mean));
    Some(Rectangle { center, n, half: [u * (0.5 * (u1 - u0) + margin), v * (0.5 * (v1 - v0) + margin)] })
}
