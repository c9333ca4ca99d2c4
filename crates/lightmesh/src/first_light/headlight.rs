//! A lamp at the camera, for rooms into which no light comes.

use std::f32::consts::PI;

use glam::Vec3;

use super::survey::Survey;
use crate::geometry::Ray;
use crate::{Light, Scene};

/// Luminance of a white surface at the median distance of what is seen, cd/m²: that of a lit room.
const WHITE: f32 = 100.0;

/// How far the lamp may be from the camera along each axis, as a part of the distance to what is seen: so near, shadows
/// stay small.
const AWAY: f32 = 0.25;

/// Returns the lamp: near the camera, towards the middle of the free space about it, as a lamp next to a wall behind the
/// camera would light little else.
pub(super) fn lamp(scene: &Scene, survey: &Survey) -> Light {
    let distance = survey.distance.max(f32::MIN_POSITIVE);
    let clearance = |direction| {
        let hit = scene.bvh().closest(&Ray::new(survey.eye, direction));
        hit.map_or(distance, |hit| hit.t.min(distance))
    };
    let towards_middle = |axis: Vec3| {
        let shift = 0.5 * (clearance(axis) - clearance(-axis));
        axis * shift.clamp(-AWAY * distance, AWAY * distance)
    };
    let position = survey.eye + survey.axes.map(towards_middle).iter().sum::<Vec3>();
    // Do not leave the room by a corner.
    let way = Ray::segment(survey.eye, position);
    let position = if position != survey.eye && scene.bvh().occluded(&way) { survey.eye } else { position };
    // L = I / (π d²) on a white surface.
    let intensity_cd = Vec3::splat(WHITE * PI * distance * distance).min(Vec3::splat(f32::MAX));
    Light::Point { position, intensity_cd, range: None }
}
