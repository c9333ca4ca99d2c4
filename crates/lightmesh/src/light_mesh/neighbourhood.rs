//! D_y: which mesh points a surface point reads, and with what weight.

use glam::{UVec3, Vec3};

use super::Coordinate;
use super::bricks::Slot;
use super::lattice::Lattice;

use crate::integrator::Vertex;
use crate::{Interpolation, Method};

/// The trilinear reader looks this far (cells) off the surface along its normal, so that a wall between lattice planes
/// reads mostly points in front of it.
const NORMAL_OFFSET: f32 = 0.5;

/// Corners with less weight are not read: the rest is renormalised, so the step is at most this part of the differences
/// between corners. Keeps a flat wall on lattice planes from asking for the next plane because of rounding.
const MIN_WEIGHT: f32 = 1e-3;

/// The neighbourhood, with its weight φ4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Neighbourhood {
    Trilinear,
    Sphere { radius: f32 },
    Nearest,
}

impl Neighbourhood {
    pub(super) fn new(method: Method, interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Auto if method == Method::Paper => Self::Sphere { radius: 1.5 },
            Interpolation::Auto => Self::Trilinear,
            Interpolation::Trilinear => Self::Trilinear,
            Interpolation::Sphere { radius } => Self::Sphere { radius },
            Interpolation::Nearest => Self::Nearest,
        }
    }

    /// How many cells beyond the scene's box a reader may look.
    pub(super) fn reach(self) -> u32 {
        match self {
            Self::Trilinear | Self::Nearest => 1,
            Self::Sphere { radius } => radius.ceil() as u32,
        }
    }

    /// Calls `visit(point, weight)` for the points of D_y, always in the same order. Points behind the surface are left
    /// out. `visit` says what it found at the point: the nearest usable one ends the search of [`Self::Nearest`].
    #[inline(always)]
    pub(super) fn for_each(self, lattice: &Lattice, vertex: &Vertex, visit: impl FnMut(Coordinate, f32) -> Slot) {
        match self {
            Self::Trilinear => trilinear(lattice, vertex, visit),
            Self::Sphere { radius } => sphere(lattice, vertex, radius, visit),
            Self::Nearest => nearest(lattice, vertex, visit),
        }
    }
}

#[inline(always)]
fn trilinear(lattice: &Lattice, vertex: &Vertex, mut visit: impl FnMut(Coordinate, f32) -> Slot) {
    let h = lattice.spacing();
    let (base, frac) = lattice.cell(vertex.position + vertex.ng * (NORMAL_OFFSET * h));
    let height = vertex.ng.dot(lattice.point(base) - vertex.position);
    let step = vertex.ng * h;
    for corner in CORNERS {
        let c = corner.as_vec3();
        // Componentwise: frac where the corner is the upper one, 1 − frac where it is the lower.
        let w = (Vec3::ONE - c) + (c + c - Vec3::ONE) * frac;
        let weight = w.x * w.y * w.z;
        if weight >= MIN_WEIGHT && height + step.dot(c) > 0.0 {
            visit(base + corner, weight);
        }
    }
}

const CORNERS: [UVec3; 8] = [
    UVec3::new(0, 0, 0),
    UVec3::new(1, 0, 0),
    UVec3::new(0, 1, 0),
    UVec3::new(1, 1, 0),
    UVec3::new(0, 0, 1),
    UVec3::new(1, 0, 1),
    UVec3::new(0, 1, 1),
    UVec3::new(1, 1, 1),
];

/// Every point within `radius` spacings, φ4 = 1.
#[inline(always)]
fn sphere(lattice: &Lattice, vertex: &Vertex, radius: f32, mut visit: impl FnMut(Coordinate, f32) -> Slot) {
    let r = radius * lattice.spacing();
    let (low, high) = lattice.range(vertex.position - r, vertex.position + r);
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let coordinate = UVec3::new(x, y, z);
                let d = lattice.point(coordinate) - vertex.position;
                if d.length_squared() <= r * r && vertex.ng.dot(d) > 0.0 {
                    visit(coordinate, 1.0);
                }
            }
        }
    }
}

/// The nearest of the cell's corners that is in front of the surface and usable.
#[inline(always)]
fn nearest(lattice: &Lattice, vertex: &Vertex, mut visit: impl FnMut(Coordinate, f32) -> Slot) {
    let (base, _) = lattice.cell(vertex.position);
    let mut corners = CORNERS.map(|corner| {
        let d = lattice.point(base + corner) - vertex.position;
        let distance = if vertex.ng.dot(d) > 0.0 { d.length_squared() } else { f32::INFINITY };
        (distance, base + corner)
    });
    // Stable: equal distances keep the order of the corners.
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (distance, coordinate) in corners {
        if distance == f32::INFINITY || visit(coordinate, 1.0) != Slot::Invalid {
            return;
        }
    }
}
