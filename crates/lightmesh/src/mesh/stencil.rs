//! D_y: which mesh points a surface point reads, and with what weight.

use glam::{IVec3, Vec3, Vec4};

use super::bricks::Slot;
use super::corners::{ByCorner, ONES, corner};
use super::lattice::{Coordinate, Lattice, ON_SURFACE, PointBlock};
use crate::interaction::ShadingPoint;
use crate::{Interpolation, Method, MissingCorners, PaperScale, PointWeight, RenderOptions};

/// The trilinear reader reads at a position this far (cells) off the surface along its normal, so that a wall between
/// lattice planes reads mostly points in front of it. Measured on the room of 15 / 100 lights at 1/80 of its length,
/// error against exact shadow rays: offset 0.25: 5.13 / 3.20%, 0.5: 5.04 / 2.95%, 0.75: 5.26 / 2.89% with 1.6 times as
/// many points.
const NORMAL_OFFSET: f32 = 0.5;

/// Corners with less weight are not read: the rest is renormalised, so the step is at most this part of the differences
/// between corners. Keeps a flat wall on lattice planes from asking for the next plane because of rounding.
const MIN_WEIGHT: f32 = 1e-3;

/// Which points D_y holds, and their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Interpolator {
    Trilinear,
    TrilinearWith(MissingCorners),
    Sphere(SphereStencil),
    Nearest,
}

/// All points in a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SphereStencil {
    /// Its radius, in spacings.
    pub radius: f32,
    pub weight: PointWeight,
    /// How far its center is off the surface, along the normal, in spacings: 0 as in the paper.
    pub normal_offset: f32,
}

impl SphereStencil {
    /// [`SphereStencil::normal_offset`] of the paper's scalar. Measured with spheres of 1.5 spacings at 1/40 of the
    /// room of 15 lights, points inside solids left out: 0 16.4%, 0.25 15.5%, 0.5 15.0%, 0.6 14.8%, 0.75 14.5%, 1
    /// 13.8%.
    const PAPER_OFFSET: f32 = 0.6;
}

impl Interpolator {
    /// Returns the interpolator that the options choose.
    pub(crate) fn of(options: &RenderOptions) -> Self {
        let weight = options.mesh.weight;
        let scales_by_visibility = matches!(options.method, Method::Paper { scale: PaperScale::Visibility, .. });
        let normal_offset = if scales_by_visibility { SphereStencil::PAPER_OFFSET } else { 0.0 };
        match options.resolved().interpolation {
            Interpolation::Auto | Interpolation::Trilinear => Self::Trilinear,
            Interpolation::TrilinearWith(rule) => Self::TrilinearWith(rule),
            Interpolation::Sphere { radius } => Self::Sphere(SphereStencil { radius, weight, normal_offset }),
            Interpolation::Nearest => Self::Nearest,
        }
    }

    /// Returns the interpolator of the indirect field, which has no rules for missing corners: they are rules for
    /// visibility.
    pub(crate) fn without_rules(self) -> Self {
        if matches!(self, Self::TrilinearWith(_)) { Self::Trilinear } else { self }
    }

    /// Returns the smallest block that holds all the points that a surface at `p` reads, whichever way it faces.
    pub(crate) fn range_around(self, lattice: &Lattice, p: Vec3) -> PointBlock {
        let offset = match self {
            Self::Trilinear => NORMAL_OFFSET,
            Self::TrilinearWith(_) => ON_SURFACE,
            Self::Nearest => 0.0,
            Self::Sphere(stencil) => {
                // The sum is rounded otherwise than the reader's.
                let r = 1.001 * (stencil.radius + stencil.normal_offset) * lattice.spacing();
                return lattice.range(p - r, p + r);
            }
        };
        let offset = offset * lattice.spacing();
        PointBlock { low: lattice.cell(p - offset).0, high: lattice.cell(p + offset).0 + 1 }
    }

    /// Returns how many cells beyond the scene's box a surface may read.
    pub(crate) fn reach(self) -> u32 {
        match self {
            Self::Trilinear | Self::TrilinearWith(_) | Self::Nearest => 1,
            Self::Sphere(stencil) => (stencil.radius + stencil.normal_offset).ceil() as u32,
        }
    }
}

/// The eight corners of the cell at a vertex: corner k is the cell's lower corner plus bit 0 of k in x, bit 1 in y and
/// bit 2 in z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    /// The cell's lower corner.
    pub cell: Coordinate,
    /// Trilinear weights, four by four.
    pub weights: ByCorner,
    /// Heights of the corners above the vertex' tangent plane, in spacings.
    pub heights: ByCorner,
    /// Which corners are read, a bit each.
    pub read: u8,
}

impl Stencil {
    /// Returns the trilinear weights of some corners together.
    #[inline(always)]
    pub(super) fn sum(&self, corners: u8) -> f32 {
        self.weights[0].dot(ONES[corners as usize & 15]) + self.weights[1].dot(ONES[corners as usize >> 4])
    }

    /// Returns the trilinear weight of corner k.
    #[inline(always)]
    pub(super) fn weight(&self, k: usize) -> f32 {
        self.weights[k / 4][k % 4]
    }
}

/// Returns the trilinear weights at the vertex; corners behind its surface are left out.
#[inline(always)]
pub(super) fn trilinear(lattice: &Lattice, vertex: &ShadingPoint) -> Stencil {
    stencil(lattice, vertex, NORMAL_OFFSET)
}

/// Returns the trilinear weights at the position `offset` spacings off the surface.
#[inline(always)]
pub(super) fn stencil(lattice: &Lattice, vertex: &ShadingPoint, offset: f32) -> Stencil {
    let (cell, position) = lattice.cell_and_position(vertex.position + vertex.ng * (offset * lattice.spacing()));
    let frac = position.clamp(Vec3::ZERO, Vec3::ONE);
    // The vertex is below `position` by the offset.
    let height = offset - vertex.ng.dot(position);
    let rest = Vec3::ONE - frac;
    let flat = Vec4::new(rest.x, frac.x, rest.x, frac.x) * Vec4::new(rest.y, rest.y, frac.y, frac.y);
    let weights = [flat * rest.z, flat * frac.z];
    let heights = heights_above(vertex.ng, height);
    // By sign bits: they come out of a vector sooner than comparisons do.
    let read = [0, 1].map(|z| {
        let above = (Vec4::ZERO - heights[z]).is_negative_bitmask();
        above as u8 & !((weights[z] - MIN_WEIGHT).is_negative_bitmask() as u8)
    });
    Stencil { cell, weights, heights, read: read[0] | read[1] << 4 }
}

/// Returns how far a cell's corners are above a plane of unit normal `ng`, if corner 0 is `height` above it, all in
/// spacings.
#[inline(always)]
pub(super) fn heights_above(ng: Vec3, height: f32) -> ByCorner {
    let lower = height + Vec4::new(0.0, ng.x, 0.0, ng.x) + Vec4::new(0.0, 0.0, ng.y, ng.y);
    [lower, lower + ng.z]
}

/// Visits every point of the sphere that is before the vertex' plane, with its φ4.
pub(super) fn sphere(
    lattice: &Lattice,
    vertex: &ShadingPoint,
    stencil: SphereStencil,
    mut visit: impl FnMut(Coordinate, f32) -> Slot,
) {
    // Visit the block that holds the sphere.
    let SphereStencil { radius, weight, normal_offset } = stencil;
    let r = radius * lattice.spacing();
    let center = vertex.position + vertex.ng * (normal_offset * lattice.spacing());
    let PointBlock { low, high } = lattice.range(center - r, center + r);
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let coordinate = IVec3::new(x, y, z);
                let point = lattice.point(coordinate);
                let d = point - vertex.position;
                if point.distance_squared(center) <= r * r && vertex.ng.dot(d) > 0.0 {
                    visit(coordinate, phi(weight, d * lattice.inv_spacing(), radius, vertex.ng));
                }
            }
        }
    }
}

/// Returns φ4 of a point that is `d` spacings from a surface point of normal `ng`, in a sphere of `radius` spacings.
fn phi(weight: PointWeight, d: Vec3, radius: f32, ng: Vec3) -> f32 {
    match weight {
        PointWeight::Constant => 1.0,
        PointWeight::Gaussian => {
            let deviation = 0.5 * radius;
            libm::expf(-0.5 * d.length_squared() / (deviation * deviation))
        }
        PointWeight::Inverse => 1.0 / d.length().max(0.1),
        PointWeight::Cosine => ng.dot(d).max(0.0) / d.length(),
    }
}

/// Visits the cell's corners that are in front of the surface, the nearest first, until `visit` returns the slot of a
/// usable one.
pub(super) fn nearest(lattice: &Lattice, vertex: &ShadingPoint, mut visit: impl FnMut(Coordinate) -> Slot) {
    let (base, _) = lattice.cell(vertex.position);
    // Sort the corners by distance; those behind the surface are last.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The formulas, at 2 spacings along a 3-4-5 triangle, R = 2: exp(−2), 1/2, 4/5.
    #[test]
    fn weights_follow_their_formulas() {
        let d = Vec3::new(1.2, 1.6, 0.0);
        for (weight, expected) in [
            (PointWeight::Constant, 1.0),
            (PointWeight::Gaussian, 0.135_335_28),
            (PointWeight::Inverse, 0.5),
            (PointWeight::Cosine, 0.8),
        ] {
            let got = phi(weight, d, 2.0, Vec3::Y);
            assert!((got - expected).abs() < 1e-6, "{weight:?}: {got}");
        }
        assert!((phi(PointWeight::Inverse, 0.01 * d, 2.0, Vec3::Y) - 10.0).abs() < 1e-5);
        assert_eq!(phi(PointWeight::Cosine, d, 2.0, Vec3::NEG_Y), 0.0);
    }
}
