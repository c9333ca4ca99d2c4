//! D_y: which mesh points a surface point reads, and with what weight.

use glam::{UVec3, Vec3};

use super::Coordinate;
use super::bricks::Slot;
use super::lattice::Lattice;
use crate::integrator::Vertex;
use crate::{Interpolation, Method};

/// The trilinear reader looks this far (cells) off the surface along its normal, so that a wall between lattice planes
/// reads mostly points in front of it. Measured on the room of 15 / 100 lights at 1/80 of its length, error against exact
/// shadow rays: offset 0.25: 5.13 / 3.20%, 0.5: 5.04 / 2.95%, 0.75: 5.26 / 2.89% with 1.6 times as many points.
const NORMAL_OFFSET: f32 = 0.5;

/// Corners with less weight are not read: the rest is renormalised, so the step is at most this part of the differences
/// between corners. Keeps a flat wall on lattice planes from asking for the next plane because of rounding.
const MIN_WEIGHT: f32 = 1e-3;

/// Which points D_y holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Neighbourhood {
    Trilinear,
    Sphere { radius: f32 },
    Nearest,
}

impl Neighbourhood {
    pub(super) fn new(method: Method, interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Auto if method == Method::Paper => Self::Sphere { radius: Interpolation::DEFAULT_RADIUS },
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
}

/// The eight corners of the cell at a vertex: corner k is the cell's lower corner plus bit 0 of k in x, bit 1 in y and bit
/// 2 in z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    /// The cell's lower corner.
    pub cell: Coordinate,
    /// Trilinear weights.
    pub weights: [f32; 8],
    /// Which corners are read, a bit each.
    pub read: u8,
}

/// Trilinear weights about the vertex; corners behind its surface are left out.
#[inline(always)]
pub(super) fn trilinear(lattice: &Lattice, vertex: &Vertex) -> Stencil {
    let h = lattice.spacing();
    let (cell, frac) = lattice.cell(vertex.position + vertex.ng * (NORMAL_OFFSET * h));
    let height = vertex.ng.dot(lattice.point(cell) - vertex.position);
    let step = vertex.ng * h;
    let rest = Vec3::ONE - frac;
    let (mut weights, mut read) = ([0.0; 8], 0);
    for (k, weight) in weights.iter_mut().enumerate() {
        let (x, y, z) = (k & 1 != 0, k & 2 != 0, k & 4 != 0);
        let pick = |upper: bool, a: f32, b: f32| if upper { a } else { b };
        *weight = pick(x, frac.x, rest.x) * pick(y, frac.y, rest.y) * pick(z, frac.z, rest.z);
        let above = height + pick(x, step.x, 0.0) + pick(y, step.y, 0.0) + pick(z, step.z, 0.0);
        read |= u8::from(*weight >= MIN_WEIGHT && above > 0.0) << k;
    }
    Stencil { cell, weights, read }
}

/// The coordinate of corner k of a cell.
#[inline(always)]
pub(super) fn corner(cell: Coordinate, k: usize) -> Coordinate {
    cell + UVec3::new(k as u32 & 1, k as u32 >> 1 & 1, k as u32 >> 2)
}

/// Every point within `radius` spacings, φ4 = 1.
pub(super) fn sphere(lattice: &Lattice, vertex: &Vertex, radius: f32, mut visit: impl FnMut(Coordinate) -> Slot) {
    let r = radius * lattice.spacing();
    let (low, high) = lattice.range(vertex.position - r, vertex.position + r);
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let coordinate = UVec3::new(x, y, z);
                let d = lattice.point(coordinate) - vertex.position;
                if d.length_squared() <= r * r && vertex.ng.dot(d) > 0.0 {
                    visit(coordinate);
                }
            }
        }
    }
}

/// The cell's corners that are in front of the surface, the nearest first, until `visit` finds a usable one: it says what
/// is at the point.
pub(super) fn nearest(lattice: &Lattice, vertex: &Vertex, mut visit: impl FnMut(Coordinate) -> Slot) {
    let (base, _) = lattice.cell(vertex.position);
    let mut corners: [(f32, Coordinate); 8] = std::array::from_fn(|k| {
        let coordinate = corner(base, k);
        let d = lattice.point(coordinate) - vertex.position;
        let distance = if vertex.ng.dot(d) > 0.0 { d.length_squared() } else { f32::INFINITY };
        (distance, coordinate)
    });
    // Stable: equal distances keep the order of the corners.
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (distance, coordinate) in corners {
        if distance == f32::INFINITY || visit(coordinate) != Slot::Invalid {
            return;
        }
    }
}
