//! The usable part of the points that a surface reads: a layer of the picture, on which no light depends.

use super::bricks::Slot;
use super::marks::Marks;
use super::missing_corners::usable_share;
use super::points::Points;
use super::reader::Reader;
use super::stencil::{Interpolator, nearest, sphere, trilinear};
use crate::interaction::ShadingPoint;

/// Returns the part, by φ4, of the points of D_y that a vertex can use: they are not inside a solid, and nothing hides
/// them from it. All of them have been evaluated.
pub(crate) fn usable_fraction(reader: &mut Reader<'_>, points: &Points, vertex: &ShadingPoint, marks: &Marks) -> f32 {
    // Sum the weights of all points and those of the usable ones.
    let (mut usable, mut total) = (0.0, 0.0);
    let mut visit = |slot: Slot, weight: f32| {
        total += weight;
        usable += if matches!(slot, Slot::Filled(_)) { weight } else { 0.0 };
        slot
    };
    let level = points.level(points.first_level(vertex.position));
    match points.interpolator {
        Interpolator::Trilinear => {
            let stencil = trilinear(&level.lattice, vertex);
            if let Ok(visible) = reader.corners(vertex, marks) {
                total = stencil.sum(stencil.read);
                usable = stencil.sum(visible.mask) + visible.refined;
            }
        }
        Interpolator::TrilinearWith(_) => return usable_share(level, vertex),
        Interpolator::Sphere(stencil) => {
            sphere(&level.lattice, vertex, stencil, |coordinate, w| visit(level.slot(coordinate), w));
        }
        Interpolator::Nearest => {
            nearest(&level.lattice, vertex, |coordinate| visit(level.slot(coordinate), 1.0));
        }
    }
    if total > 0.0 { usable / total } else { 0.0 }
}
