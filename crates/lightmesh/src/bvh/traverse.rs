//! The traversal, written once for closest hits and for any hit, for triangles and for the top level.

use std::cell::Cell;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use glam::Vec3;

use super::node::{ChildRef, Node, WIDTH};
use crate::geometry::{Aabb, Ray};

/// Entries of the traversal stack. A tree of [`MAX_DEPTH`] never needs more; what would not fit is left out.
pub(super) const STACK: usize = 256;

/// Deepest wide tree whose traversal fits the stack: each node on the way pushes at most seven siblings.
pub(super) const MAX_DEPTH: usize = STACK / (WIDTH - 1);

/// Children still to visit: the distance where the ray enters them in the upper half, their reference in the lower.
pub(super) type Stack = [u64; STACK];

/// What traversals of two levels need. Threads keep theirs from ray to ray: clearing 4 kB takes a third as long as a
/// short shadow ray.
pub(super) struct Stacks {
    pub(super) mesh: Stack,
    pub(super) top: Stack,
}

thread_local! {
    static SPARE: Cell<Option<Box<Stacks>>> = const { Cell::new(None) };
}

impl Stacks {
    /// Those of this thread, or new ones where a traversal goes on inside another one.
    pub(super) fn take() -> Box<Self> {
        SPARE.take().unwrap_or_else(|| Box::new(Self { mesh: [0; STACK], top: [0; STACK] }))
    }

    /// Leaves them to the thread's next ray.
    pub(super) fn give_back(self: Box<Self>) {
        SPARE.set(Some(self));
    }
}

/// The order in which a node's children are visited.
pub(super) trait Order {
    /// Front to back, or as they come.
    const FRONT_TO_BACK: bool;
}

/// For the closest hit.
pub(super) struct FrontToBack;

impl Order for FrontToBack {
    const FRONT_TO_BACK: bool = true;
}

/// For any hit, where sorting costs more than it saves.
pub(super) struct AsTheyCome;

impl Order for AsTheyCome {
    const FRONT_TO_BACK: bool = false;
}

/// A ray prepared for box tests against one tree.
///
/// The test is the slab test with the origin moved apart by a margin, one copy for the planes where the ray enters and
/// one for those where it leaves, as in Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013,
/// section 4. With u = 2⁻²⁴ and D the largest distance along an axis from the origin to a side of the tree's box, the
/// margin 16·u·D covers
/// - the triangle test, which sees corners moved by up to 6·u·D (translation, shear constant, product, difference), and
/// - the rounding of this test itself, (p − o)·(1/d), at most 4·u·D when expressed as a shift of the plane.
///
/// Where D is small beside the origin's coordinate the margin is 4·u·|o| instead, so that adding it never rounds away.
#[derive(Clone, Copy)]
pub(super) struct BoxRay<S: Simd> {
    near_origin: [f32x8<S>; 3],
    far_origin: [f32x8<S>; 3],
    inverse: [f32x8<S>; 3],
    /// Per axis, 0 where the ray enters through the lower plane and 1 where through the upper.
    near_side: [usize; 3],
    t_min: f32x8<S>,
    /// Whether origin and direction are numbers. With others, box tests compare NaN, and may enter empty slots.
    is_finite: bool,
}

impl<S: Simd> BoxRay<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, ray: &Ray, bounds: &Aabb) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        let reach = (o - bounds.min).abs().max((o - bounds.max).abs()).max_element();
        let margin = Vec3::splat(reach * (1.0 / (1 << 20) as f32)).max(o.abs() * (1.0 / (1 << 22) as f32));
        // A finite 1/0 keeps 0 · ∞ = NaN out: (p − o) / 0 then is ±huge, or 0 on the plane itself, which counts as
        // inside.
        let inverse = d.to_array().map(|d| (1.0 / d).clamp(-f32::MAX, f32::MAX));
        let side = inverse.map(|r| (r.to_bits() >> 31) as usize);
        let shift = |axis: usize| if side[axis] == 0 { margin[axis] } else { -margin[axis] };
        let splat = |x: f32| f32x8::splat(simd, x);
        Self {
            is_finite: reach.is_finite() && d.is_finite(),
            near_origin: [splat(o.x + shift(0)), splat(o.y + shift(1)), splat(o.z + shift(2))],
            far_origin: [splat(o.x - shift(0)), splat(o.y - shift(1)), splat(o.z - shift(2))],
            inverse: [splat(inverse[0]), splat(inverse[1]), splat(inverse[2])],
            near_side: side,
            t_min: splat(ray.t_min.max(0.0)),
        }
    }

    /// Returns where the ray enters each child's box, and a bit mask of the children that it meets before `t_max`.
    #[inline(always)]
    fn enter(&self, simd: S, node: &Node, t_max: f32x8<S>) -> (f32x8<S>, u32) {
        let slab = |axis: usize| {
            let side = self.near_side[axis] & 1;
            let near = f32x8::load_array_ref(simd, &node.planes[axis][side]);
            let far = f32x8::load_array_ref(simd, &node.planes[axis][side ^ 1]);
            ((near - self.near_origin[axis]) * self.inverse[axis], (far - self.far_origin[axis]) * self.inverse[axis])
        };
        let ((nx, fx), (ny, fy), (nz, fz)) = (slab(0), slab(1), slab(2));
        let near = nx.max(ny).max(nz.max(self.t_min));
        let far = fx.min(fy).min(fz.min(t_max));
        (near, near.simd_le(far).to_bitmask() as u32)
    }
}

/// Visits the leaves that the ray meets before `t_max`. `leaf` gets a leaf's reference, may shorten `t_max`, and stops
/// the traversal by returning true; `traverse` returns whether it did. A ray that is not finite meets nothing.
///
/// Children of equal distance are visited in the order of their references, so the order of visits does not depend on
/// the SIMD level.
#[inline(always)]
pub(super) fn traverse<S: Simd, O: Order>(
    simd: S,
    nodes: &[Node],
    root: ChildRef,
    ray: &BoxRay<S>,
    t_max: &mut f32,
    stack: &mut Stack,
    mut leaf: impl FnMut(ChildRef, &mut f32) -> bool,
) -> bool {
    if !ray.is_finite {
        return false;
    }
    let mut depth = 0;
    let mut current = root.0;
    let mut far = f32x8::splat(simd, *t_max);
    loop {
        // Walk down to a leaf.
        let found = 'down: loop {
            if ChildRef(current).is_leaf() {
                break 'down true;
            }
            let node = &nodes[current as usize];
            let (near, mut mask) = ray.enter(simd, node, far);
            if mask == 0 {
                break 'down false;
            }
            let lane = mask.trailing_zeros() as usize & 7;
            current = node.children[lane];
            mask &= mask - 1;
            // Most often one child is met: go on with it.
            if mask == 0 {
                continue;
            }
            if O::FRONT_TO_BACK {
                let near: [f32; WIDTH] = near.into();
                let entry =
                    |lane: usize| u64::from(near[lane].to_bits() & 0x7fff_ffff) << 32 | u64::from(node.children[lane]);
                let mut nearest = entry(lane);
                let base = depth;
                while mask != 0 && depth < STACK {
                    // Keep the nearest in hand and insert the other among this node's, the farthest lowest.
                    let other = entry(mask.trailing_zeros() as usize & 7);
                    mask &= mask - 1;
                    let pushed = nearest.max(other);
                    nearest = nearest.min(other);
                    let mut slot = depth;
                    while slot > base && stack[slot - 1] < pushed {
                        stack[slot] = stack[slot - 1];
                        slot -= 1;
                    }
                    stack[slot] = pushed;
                    depth += 1;
                }
                current = nearest as u32;
            } else {
                while mask != 0 && depth < STACK {
                    stack[depth] = u64::from(node.children[mask.trailing_zeros() as usize & 7]);
                    mask &= mask - 1;
                    depth += 1;
                }
            }
        };
        // Visit the leaf, which may shorten the ray.
        if found {
            if leaf(ChildRef(current), t_max) {
                return true;
            }
            if O::FRONT_TO_BACK {
                far = f32x8::splat(simd, *t_max);
            }
        }
        // Take the next child that still lies before the closest hit.
        loop {
            if depth == 0 {
                return false;
            }
            depth -= 1;
            let entry = stack[depth];
            current = entry as u32;
            if !O::FRONT_TO_BACK || f32::from_bits((entry >> 32) as u32) <= *t_max {
                break;
            }
        }
    }
}
