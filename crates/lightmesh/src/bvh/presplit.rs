//! Splitting large triangles: the boxes of the parts of a long slanted triangle hold less empty space.

use glam::Vec3;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;

use super::binary_tree::Item;
use crate::geometry::Aabb;

/// Replaces the boxes of large triangles by boxes of their parts, where that saves surface area.
pub(super) fn presplit(items: &mut Vec<Item>, triangles: &[[Vec3; 3]]) {
    if items.is_empty() {
        return;
    }
    // Split the boxes by obvhs.
    let mut boxes: Vec<obvhs::aabb::Aabb> =
        items.iter().map(|i| obvhs::aabb::Aabb::new(i.bounds.min.into(), i.bounds.max.into())).collect();
    let mut primitives: Vec<u32> = items.iter().map(|i| i.primitive).collect();
    let corners: Vec<Triangle> =
        triangles.iter().map(|[a, b, c]| Triangle { v0: (*a).into(), v1: (*b).into(), v2: (*c).into() }).collect();
    let sum: f64 = boxes.iter().map(|b| f64::from(b.half_area())).sum();
    let average = (sum / boxes.len() as f64) as f32;
    let largest = boxes.iter().map(|b| b.half_area()).fold(0.0, f32::max);
    split_aabbs_preset(&mut boxes, &mut primitives, &corners, average, largest);

    // Count the parts of each triangle.
    let mut parts = vec![0_u8; triangles.len()];
    primitives.iter().for_each(|&p| parts[p as usize] = parts[p as usize].saturating_add(1));
    // Take the boxes over, those of parts with a margin.
    items.clear();
    items.extend(boxes.iter().zip(primitives).map(|(b, primitive)| {
        let (mut bounds, whole) =
            (Aabb { min: b.min.into(), max: b.max.into() }, Aabb::from_points(triangles[primitive as usize]));
        // A cut point is interpolated: off by a few roundings of the triangle's coordinates, 2⁻²⁴ of them each.
        if parts[primitive as usize] > 1 {
            let margin = whole.min.abs().max(whole.max.abs()) * (1.0 / (1 << 21) as f32);
            bounds = Aabb { min: (bounds.min - margin).max(whole.min), max: (bounds.max + margin).min(whole.max) };
        }
        Item { bounds, primitive }
    }));
}
