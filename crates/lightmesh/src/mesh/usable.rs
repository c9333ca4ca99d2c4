//! How much of what a surface asks the mesh for it can use: a layer of the picture, nothing that light depends on.

use super::bricks::Slot;
use super::marks::Marks;
use super::missing_corners::usable_share;
use super::points::Points;
use super::reader::Reader;
use super::stencil::{Interpolator, nearest, sphere, trilinear};
use crate::interaction::ShadingPoint;

/// The part, by φ4, of the points of D_y that a vertex can use: they are not inside a solid, and nothing hides them
/// from it. All of them have been evaluated.
pub(crate) fn usable_fraction(reader: &mut Reader<'_>, points: &Points, vertex: &ShadingPoint, marks: &Marks) -> f32 {
    let (mut usable, mut asked) = (0.0, 0.0);
    let mut visit = |slot: Slot, weight: f32| {
        asked += weight;
        usable += if matches!(slot, Slot::Filled(_)) { weight } else { 0.0 };
        slot
    };
    match points.neighbourhood {
        Interpolator::Trilinear => {
            let stencil = trilinear(&points.level(0).lattice, vertex);
            if let Ok(seen) = reader.corners(vertex, marks) {
                asked = stencil.sum(stencil.read);
                usable = stencil.sum(seen.mask) + seen.refined;
            }
        }
        Interpolator::TrilinearWith(_) => return usable_share(points.level(0), vertex),
        Interpolator::Sphere(ball) => {
            let level = points.level(0);
            sphere(&level.lattice, vertex, ball, |coordinate, w| visit(level.slot(coordinate), w));
        }
        Interpolator::Nearest => {
            let level = points.level(0);
            nearest(&level.lattice, vertex, |coordinate| visit(level.slot(coordinate), 1.0));
        }
    }
    if asked > 0.0 { usable / asked } else { 0.0 }
}
