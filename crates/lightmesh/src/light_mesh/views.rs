//! What cameras see of a scene, and so where its mesh is to be fine.
//!
//! Rays of each camera, and diffuse reflections of them, find the room that a picture is of: what is behind the camera or
//! round a corner, too. A wall ends it. Where nothing does, as out of doors, it ends at twice the distance
//! within which most of the picture is.

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::{Aabb, Ray};
use crate::interaction::evaluate;
use crate::mesh::Focus;
use crate::sampling::{Sampler, basis, sample_cosine_hemisphere};
use crate::{Camera, RenderOptions, Scene, Spacing};

/// Rays of a camera along its picture's width and height.
const RAYS: [u32; 2] = [48, 32];

/// Diffuse reflections that a ray is followed for. Measured with the reach below: the longest edge is 0.94 of the scene's
/// in Sponza, and 0.98 to 1.00 in a staircase and eight rooms.
const REFLECTIONS: u32 = 3;

/// How much longer a room is than what rays find of it, which miss its last corners. Empirical: between what they find in
/// Sponza and in the others.
const MISSED: f32 = 1.04;

/// Surfaces that a ray may pass through.
const PASSES: u32 = 8;

/// A room of this part of the scene's longest edge counts as as long. A judgement: with the scene's edge for that of its
/// views, Sponza has 8% fewer points.
const ROOM: f32 = 0.95;

/// The part of a picture that is near. Empirical, as is what follows.
const NEAR: f32 = 0.8;

/// What is farther away than this times that part is left out.
const REACH: f32 = 2.0;

/// The part of the surfaces that may lie outside the box along an axis, at each end, and how much larger the box with
/// all of them may be to be taken nevertheless.
const STRAY: f32 = 0.01;
const WHOLE: f32 = 1.3;

/// What of the picture's surfaces are the nearest.
const NEAREST: f32 = 0.25;

/// Pixels between points of the direct mesh there, at least, where as many pixels are empty as show a surface; more where
/// more are empty, in proportion to the root of their number, and fewer where fewer are. Empty pixels take no time, and a
/// mesh of more points than the others read takes more than it saves: a box of 2 m in a picture of 160 × 120 took 38 times
/// as long as paths with a spacing of one pixel. A picture of a room is not limited.
const PIXELS: f32 = 4.0;

/// How much larger spacings may become by it.
const COARSEST: f32 = 4.0;

/// A surface that a ray of a camera finds.
#[derive(Clone, Copy, Debug)]
struct Seen {
    position: Vec3,
    /// From where its camera's ray starts, metres.
    distance: f32,
}

/// Returns where a mesh for pictures by these cameras is to be fine; `None` where they see nothing.
pub(super) fn focus(scene: &Scene, options: &RenderOptions, cameras: &[Camera]) -> Option<Focus> {
    // Follow the rays of all cameras.
    let (mut first, mut pixels, mut seen) = (Vec::new(), Vec::new(), Vec::new());
    for camera in cameras {
        let [width, height] = RAYS;
        let rays = camera.film_in(scene.data().origin, &scene.bounds(), width, height);
        let along = |pixel: u32| {
            let ray = rays.ray((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
            follow(scene, ray, pixel)
        };
        let found: Vec<Vec<Seen>> = (0..width * height).into_par_iter().map(along).collect();
        for found in found {
            let Some(Seen { position, distance }) = found.first() else { continue };
            first.push(*distance);
            pixels.push(height as f32 / options.picture.height.max(1) as f32 / rays.project(*position).1);
            seen.extend(found);
        }
    }

    // Leave out what is far behind most of the picture.
    let near = quantile(&mut first, NEAR)?;
    seen.retain(|seen| seen.distance <= REACH * near);
    let (mut min, mut max) = (Vec3::ZERO, Vec3::ZERO);
    for axis in 0..3 {
        (min[axis], max[axis]) = extent(seen.iter().map(|seen| seen.position[axis]).collect());
    }
    let mut longest = MISSED * (max - min).max_element();
    // Nearly all of the scene is all of it: its spacing is the same in every picture.
    let whole = scene.bounds().size().max_element();
    if longest >= ROOM * whole {
        longest = longest.max(whole);
    }
    let rays = (RAYS[0] * RAYS[1]) as f32 * cameras.len() as f32;
    let finest = PIXELS * (rays / pixels.len() as f32 - 1.0).max(0.0).sqrt() * quantile(&mut pixels, NEAREST)?;
    Focus::on(&Aabb { min, max }, longest.max(finest * Spacing::AUTO).min(longest * COARSEST))
}

/// Follows a camera's ray through what is clear to the first surface, and on by diffuse reflections. Returns the surfaces
/// that it meets.
fn follow(scene: &Scene, ray: Ray, pixel: u32) -> Vec<Seen> {
    let (start, mut seen) = (ray.origin, Vec::new());
    let (mut ray, mut sampler) = (ray, Sampler::new(0, pixel, 0));
    let (mut reflections, mut passes) = (0, 0);
    while let Some(hit) = scene.bvh().closest(&ray) {
        let surface = evaluate(scene, &ray, &hit);
        let clear = surface.refraction.max_element() + (1.0 - surface.opacity);
        if clear > 0.5 && passes < PASSES {
            passes += 1;
            ray = surface.spawn_ray(ray.direction);
            continue;
        }
        seen.push(Seen { position: surface.position, distance: surface.position.distance(start) });
        if reflections == REFLECTIONS {
            break;
        }
        reflections += 1;
        let (t, b) = basis(surface.ng);
        let local = sample_cosine_hemisphere(sampler.next_pair());
        ray = surface.spawn_ray(t * local.x + b * local.y + surface.ng * local.z);
    }
    seen
}

/// Returns the value below which a part of the values is; `None` for none.
fn quantile(values: &mut [f32], part: f32) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    values.get((part * values.len() as f32) as usize).copied()
}

/// Returns the ends of the range of some positions along an axis, of which there is at least one, without strays.
fn extent(mut x: Vec<f32>) -> (f32, f32) {
    x.sort_by(f32::total_cmp);
    let last = x.len() - 1;
    let stray = (STRAY * x.len() as f32) as usize;
    let (whole, most) = ((x[0], x[last]), (x[stray], x[last - stray]));
    if whole.1 - whole.0 <= WHOLE * (most.1 - most.0) { whole } else { most }
}
