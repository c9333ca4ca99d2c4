//! Four triangles side by side and the watertight test: Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection",
//! JCGT 2013.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};
use glam::Vec3;

use crate::geometry::Ray;

/// Triangles per block.
pub(super) const LANES: usize = 4;

/// Four triangles: row `3·corner + axis` holds that coordinate of that corner, row 9 the bits of the primitives' ids.
/// 160 bytes. A lane without a triangle holds NaN, which no test accepts.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct TriangleBlock {
    rows: [[f32; LANES]; 10],
}

impl TriangleBlock {
    /// A block of up to four (id, corners).
    pub(crate) fn new(triangles: &[(u32, [Vec3; 3])]) -> Self {
        let mut rows = [[f32::NAN; LANES]; 10];
        for (lane, (id, corners)) in triangles.iter().enumerate() {
            for (row, x) in corners.iter().flat_map(|c| c.to_array()).enumerate() {
                rows[row][lane] = x;
            }
            rows[9][lane] = f32::from_bits(*id);
        }
        Self { rows }
    }

    #[inline(always)]
    fn id(&self, lane: usize) -> u32 {
        self.rows[9][lane].to_bits()
    }
}

/// The part of the test that depends on the ray alone (the paper's section 3): the axes so renamed that z is the
/// longest component of the direction, and the shear that turns the direction into +z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear {
    kx: usize,
    ky: usize,
    kz: usize,
    origin: [f32; 3],
    scale: [f32; 3],
}

impl Shear {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let a = ray.direction.abs();
        let kz = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        // The paper swaps x and y when d.z < 0 to keep the winding; both sides count here, so there is no need to.
        let kx = if kz == 2 { 0 } else { kz + 1 };
        let ky = if kx == 2 { 0 } else { kx + 1 };
        let o = ray.origin.to_array();
        Self { kx, ky, kz, origin: [o[kx], o[ky], o[kz]], scale: [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]] }
    }
}

/// A triangle that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangleHit {
    pub(super) t: f32,
    pub(super) u: f32,
    pub(super) v: f32,
    /// The id that the block stores.
    pub(super) id: u32,
}

/// The test of one triangle, plain: the twin of [`BlockRay::hits`], which gives the same bits, and the one judge where
/// a ray meets an edge.
///
/// The signs of U, V and W say on which side of each edge the ray passes. Rounding is monotonic, so in f32 a sign is
/// right or the value is zero; two triangles at an edge compute the same products and so agree. Zeros are decided in
/// f64, where products of f32 are exact, so a ray through a corner meets one of its triangles at least. What remains is
/// the rounding of the sheared corners themselves, which neighbours share.
pub(super) fn intersect_triangle(shear: &Shear, corners: &[Vec3; 3]) -> Option<[f32; 3]> {
    let [sx, sy, sz] = shear.scale;
    // Corners relative to the origin, sheared.
    let [a, b, c] = corners.map(|corner| {
        let p = [
            corner[shear.kx] - shear.origin[0],
            corner[shear.ky] - shear.origin[1],
            corner[shear.kz] - shear.origin[2],
        ];
        [p[0] - sx * p[2], p[1] - sy * p[2], p[2]]
    });
    // Scaled barycentric coordinates.
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if u == 0.0 || v == 0.0 || w == 0.0 {
        return intersect_in_f64(sz, a, b, c);
    }
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    // Distance and weights.
    let det = u + v + w;
    let t = (u * (sz * a[2]) + v * (sz * b[2]) + w * (sz * c[2])) / det;
    Some([t, v / det, w / det])
}

/// [`intersect_triangle`] from the sheared corners on, in f64.
#[cold]
fn intersect_in_f64(sz: f32, a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Option<[f32; 3]> {
    let depth = [a, b, c].map(|p| f64::from(sz * p[2]));
    let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    // Seen edge on, or without area.
    let det = u + v + w;
    if det == 0.0 || det.is_nan() {
        return None;
    }
    let t = (u * depth[0] + v * depth[1] + w * depth[2]) / det;
    Some([t as f32, (v / det) as f32, (w / det) as f32])
}

/// A [`Shear`] spread over the lanes.
#[derive(Clone, Copy)]
pub(super) struct BlockRay<S: Simd> {
    shear: Shear,
    origin: [f32x4<S>; 3],
    scale: [f32x4<S>; 3],
    t_min: f32x4<S>,
}

impl<S: Simd> BlockRay<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray) -> Self {
        let shear = Shear::new(ray);
        let splat = |x: f32| f32x4::splat(simd, x);
        let ([ox, oy, oz], [sx, sy, sz]) = (shear.origin, shear.scale);
        Self {
            shear,
            origin: [splat(ox), splat(oy), splat(oz)],
            scale: [splat(sx), splat(sy), splat(sz)],
            t_min: splat(ray.t_min),
        }
    }

    /// Offers the block's hits with `t_min` < t ≤ `t_max` to `found`, until it returns true; returns whether it did.
    /// Hits at `t_max` itself are included so that ties can be decided by id.
    #[inline(always)]
    pub(super) fn hits(
        &self,
        simd: S,
        block: &TriangleBlock,
        t_max: f32,
        mut found: impl FnMut(TriangleHit) -> bool,
    ) -> bool {
        let Shear { kx, ky, kz, .. } = self.shear;
        let row = |corner: usize, axis: usize| f32x4::load_array_ref(simd, &block.rows[3 * corner + (axis & 3)]);
        let [sx, sy, sz] = self.scale;
        // Corners relative to the origin, sheared.
        let corner = |i: usize| {
            let z = row(i, kz) - self.origin[2];
            let x = row(i, kx) - self.origin[0];
            let y = row(i, ky) - self.origin[1];
            [x - sx * z, y - sy * z, z]
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        // Scaled barycentric coordinates.
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let zero = f32x4::splat(simd, 0.0);
        let positive = u.simd_ge(zero) & v.simd_ge(zero) & w.simd_ge(zero);
        let negative = u.simd_le(zero) & v.simd_le(zero) & w.simd_le(zero);
        let inside = positive | negative;
        if !inside.any_true() {
            return false;
        }
        // On an edge, as far as f32 can tell.
        let edge = (u.simd_eq(zero) | v.simd_eq(zero) | w.simd_eq(zero)) & inside;
        let edge = edge.to_bitmask() as u32;
        // Distance.
        let det = u + v + w;
        let t = (u * (sz * a[2]) + v * (sz * b[2]) + w * (sz * c[2])) / det;
        let within = t.simd_gt(self.t_min) & t.simd_le(f32x4::splat(simd, t_max)) & inside;
        let mut mask = within.to_bitmask() as u32 | edge;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & 3;
            mask &= mask - 1;
            let hit = if edge >> lane & 1 == 0 {
                TriangleHit { t: t[lane], u: v[lane] / det[lane], v: w[lane] / det[lane], id: block.id(lane) }
            } else {
                let at = |p: [f32x4<S>; 3]| [p[0][lane], p[1][lane], p[2][lane]];
                match intersect_in_f64(self.shear.scale[2], at(a), at(b), at(c)) {
                    Some([t, u, v]) if t > self.t_min[lane] && t <= t_max => {
                        TriangleHit { t, u, v, id: block.id(lane) }
                    }
                    _ => continue,
                }
            };
            if found(hit) {
                return true;
            }
        }
        false
    }
}
