//! Soft shadows from a single shadow ray: Parker, Shirley and Smits, "Single Sample Soft Shadows" (University of Utah,
//! UUCS-98-019, 1998), by the description that the paper gives of its reference [4].
//!
//! A light of radius R gives an object an outer penumbra: where the ray to the light's centre misses the object by δ at
//! distance t from the surface, with the light D away, τ = δ / (R t / D) of the penumbra's width is behind it, and (1 +
//! sin(πτ − π/2)) / 2 of the light arrives. Where the ray meets the object, none does: shadows grow outward only. Of
//! several objects the darkest counts.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::Vec3;
use lightmesh::bvh::Target;
use lightmesh::geometry::Ray;
use lightmesh::{Image, Light};
use rayon::prelude::*;

use crate::lab::Place;

/// A triangle in world space, and its instance.
struct Sheet {
    instance: u32,
    corners: [Vec3; 3],
}

/// Renders a place of Lambertian triangles without textures under one point light, one ray through each pixel centre.
/// `size`: width and height, pixels.
pub(crate) fn picture(place: &Place, size: (u32, u32), radius: f32) -> Image {
    let (width, height) = size;
    let film = place.camera.film(width, height);
    let sheets = sheets(place);
    let pixel = |i: u32| {
        let ray = film.ray((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        radiance(place, &sheets, &ray, radius).unwrap_or(Vec3::ZERO)
    };
    Image::new(width, height, (0..width * height).into_par_iter().map(pixel).collect())
}

fn sheets(place: &Place) -> Vec<Sheet> {
    let mut sheets = Vec::new();
    for (instance, placed) in (0..).zip(&place.data.instances) {
        let mesh = &place.data.meshes[placed.mesh];
        let world = |i: u32| placed.world_from_object.transform_point3(mesh.positions[i as usize]);
        sheets.extend(mesh.triangles.iter().map(|triangle| Sheet { instance, corners: triangle.map(world) }));
    }
    sheets
}

/// Returns the radiance along a camera ray, cd/m²; `None` where it hits nothing.
fn radiance(place: &Place, sheets: &[Sheet], ray: &Ray, radius: f32) -> Option<Vec3> {
    let hit = place.scene.bvh().closest(ray)?;
    let Target::Triangle { instance, triangle } = hit.target else { return None };
    let placed = &place.data.instances[instance as usize];
    let mesh = &place.data.meshes[placed.mesh];

    // Compute the normal of the triangle, towards the camera.
    let corners = mesh.triangles[triangle as usize]
        .map(|i| placed.world_from_object.transform_point3(mesh.positions[i as usize]));
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let normal = if normal.dot(ray.direction) < 0.0 { normal } else { -normal };

    // Find the light.
    let point = ray.at(hit.t);
    let Some(Light::Point { position, intensity_cd, .. }) = place.data.lights.first() else { return None };
    let to_light = *position - point;
    let cos = normal.dot(to_light.normalize()).max(0.0);

    // Let the other sheets dim it.
    let others = sheets.iter().filter(|sheet| sheet.instance != instance);
    let passed = others.map(|sheet| passed(sheet, point, *position, radius)).fold(1.0, f64::min);
    let albedo = place.data.materials[mesh.material].base_color;
    Some(albedo * *intensity_cd * (cos * passed as f32 / (to_light.length_squared() * std::f32::consts::PI)))
}

/// Returns the fraction of the light at `light` that passes a triangle on its way to `point`.
fn passed(sheet: &Sheet, point: Vec3, light: Vec3, radius: f32) -> f64 {
    let Sheet { corners: [a, b, c], .. } = *sheet;
    let (direction, distance) = ((light - point).normalize(), light.distance(point));

    // A ray that meets the triangle is blocked.
    let side = |a: Vec3, b: Vec3| (a - point).cross(b - point).dot(direction);
    let sides = [side(a, b), side(b, c), side(c, a)];
    let normal = (b - a).cross(c - a);
    let along = (a - point).dot(normal) / direction.dot(normal);
    let meets = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
    if meets && along > 0.0 && along < distance {
        return 0.0;
    }

    // A ray that misses it is dimmed by how near it comes to an edge, seen from the light's radius.
    let tau = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        let (miss, t) = nearest(point, direction, from, to);
        if t <= 0.0 || t >= distance { 1.0 } else { f64::from(miss * distance / (radius * t)) }
    });
    let tau = tau.into_iter().fold(1.0, f64::min);
    0.5 * (1.0 + (PI * tau - FRAC_PI_2).sin())
}

/// Returns how near a ray of unit direction comes to a segment, and the distance along the ray.
fn nearest(origin: Vec3, direction: Vec3, from: Vec3, to: Vec3) -> (f32, f32) {
    let (edge, offset) = (to - from, from - origin);
    // Both without their part along the ray: then the distance is that of a point from a segment.
    let (flat_edge, flat_offset) = (edge - direction * edge.dot(direction), offset - direction * offset.dot(direction));
    let s = (-flat_offset.dot(flat_edge) / flat_edge.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    ((flat_offset + flat_edge * s).length(), (offset + edge * s).dot(direction))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge half-way to the light: the penumbra is half as wide as the light's radius, all of it outside the shadow.
    #[test]
    fn penumbrae_grow_outward() {
        let corners = [Vec3::new(0.0, 1.0, -9.0), Vec3::new(0.0, 1.0, 9.0), Vec3::new(-9.0, 1.0, 0.0)];
        let sheet = Sheet { instance: 0, corners };
        let at = |x: f32| passed(&sheet, Vec3::new(x, 0.0, 0.0), Vec3::new(x, 2.0, 0.0), 0.4);
        assert_eq!((at(-0.01), at(0.21)), (0.0, 1.0));
        assert!((at(0.1) - 0.5).abs() < 1e-4, "{}", at(0.1));
    }
}
