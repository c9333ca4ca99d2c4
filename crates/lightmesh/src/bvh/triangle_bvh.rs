//! A tree over triangles.

use fearless_simd::Simd;
use glam::Vec3;

use super::binary_tree::{self, BinaryNode, Item};
use super::collapse::{LeafRule, WideTree, collapse};
use super::node::Node;
use super::presplit::presplit;
use super::traverse::{AsTheyCome, BoxRay, FrontToBack, MAX_DEPTH, Stack, traverse};
use super::triangle_block::{BlockRay, LANES, TriangleBlock, TriangleHit};
use crate::geometry::{Aabb, Ray};

/// A block of four triangles costs as much as this many nodes. Empirical: from 0.5 to 1.5, Sponza's and a living room's
/// rays trade nodes for blocks at about this rate, and 0.7 makes the smaller tree.
const BLOCK_COST: f32 = 0.7;

/// Most blocks of a leaf. Empirical: 2 and 8 change the tests per ray by less than 1%.
const MAX_BLOCKS: usize = 4;

/// Set in the stored id of a triangle that several leaves hold.
const SPLIT: u32 = 1 << 31;

/// An 8-wide bounding volume hierarchy over the triangles of one mesh, or of the flattened world.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    tree: WideTree,
    blocks: Vec<TriangleBlock>,
    bounds: Aabb,
}

/// The closest hit so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub(super) hit: TriangleHit,
    pub(super) found: bool,
}

impl Closest {
    /// Nothing yet; only hits before `t_max` will count, and one at `t_max` itself if its id is below `id`.
    #[inline(always)]
    pub(super) fn before(t_max: f32, id: u32) -> Self {
        Self { hit: TriangleHit { t: t_max, u: 0.0, v: 0.0, id }, found: false }
    }
}

impl TriangleBvh {
    /// Builds the tree; a triangle's id is its index in the slice. Triangles without area or with a corner that is not
    /// finite are left out. At most 2³¹ triangles.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        // Box the triangles that can be hit, large ones in parts.
        let mut items = Vec::with_capacity(triangles.len());
        for (corners, primitive) in triangles.iter().zip(0..) {
            if has_area(corners) {
                items.push(Item { bounds: Aabb::from_points(*corners), primitive });
            }
        }
        let bounds = items.iter().fold(Aabb::EMPTY, |b, item| b.union(item.bounds));
        presplit(&mut items, triangles);
        let mut parts = vec![0_u32; triangles.len()];
        items.iter().for_each(|item| parts[item.primitive as usize] += 1);

        // Build a binary tree and collapse it; a balanced one where that is too deep for the stacks.
        let make = |binary: &[BinaryNode]| {
            let rule = LeafRule { primitives_per_item: LANES, max_items: MAX_BLOCKS, item_cost: BLOCK_COST };
            // Leaves are two thirds full or more, mostly.
            let mut blocks = Vec::with_capacity(items.len() * 2 / 5);
            let tree = collapse(binary, rule, &mut |under| {
                // Each triangle once, in a fixed order.
                let mut ids: Vec<u32> = under.iter().map(|&i| items[i as usize].primitive).collect();
                ids.sort_unstable();
                ids.dedup();
                let first = blocks.len();
                for ids in ids.chunks(LANES) {
                    let mark = |id: u32| if parts[id as usize] > 1 { id | SPLIT } else { id };
                    let lanes: Vec<_> = ids.iter().map(|&id| (mark(id), triangles[id as usize])).collect();
                    blocks.push(TriangleBlock::new(&lanes));
                }
                first..blocks.len()
            });
            (tree, blocks)
        };
        let (mut tree, mut blocks) = make(&binary_tree::build(&items));
        if tree.depth > MAX_DEPTH {
            (tree, blocks) = make(&binary_tree::median_tree(&items));
        }
        blocks.shrink_to_fit();
        Self { tree, blocks, bounds }
    }

    /// The box around the triangles, metres in their own space.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> u64 {
        (self.tree.nodes.len() * size_of::<Node>() + self.blocks.len() * size_of::<TriangleBlock>()) as u64
    }

    /// Replaces `closest` by a closer hit, if there is one.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(&self, simd: S, ray: &Ray, stack: &mut Stack, closest: &mut Closest) {
        let Some(root) = self.tree.root else { return };
        let boxes = BoxRay::new(simd, ray, &self.bounds);
        let blocks = BlockRay::new(simd, ray);
        let mut t_max = closest.hit.t;
        traverse::<S, FrontToBack>(
            simd,
            &self.tree.nodes,
            root,
            &boxes,
            &mut t_max,
            stack,
            #[inline(always)]
            |leaf, t_max| {
                // Test four triangles at once, and keep the closest hit, of equal ones that of the lower id.
                for block in &self.blocks[leaf.items()] {
                    blocks.hits(
                        simd,
                        block,
                        *t_max,
                        #[inline(always)]
                        |hit| {
                            let id = hit.id & !SPLIT;
                            if hit.t < closest.hit.t || (hit.t == closest.hit.t && id < closest.hit.id) {
                                *closest = Closest { hit: TriangleHit { id, ..hit }, found: true };
                            }
                            false
                        },
                    );
                    *t_max = closest.hit.t;
                }
                false
            },
        );
    }

    /// Whether the ray meets any triangle.
    #[inline(always)]
    pub(super) fn occluded<S: Simd>(&self, simd: S, ray: &Ray, stack: &mut Stack) -> bool {
        let Some(root) = self.tree.root else { return false };
        let boxes = BoxRay::new(simd, ray, &self.bounds);
        let blocks = BlockRay::new(simd, ray);
        traverse::<S, AsTheyCome>(
            simd,
            &self.tree.nodes,
            root,
            &boxes,
            &mut { ray.t_max },
            stack,
            #[inline(always)]
            |leaf, t_max| {
                for block in &self.blocks[leaf.items()] {
                    let found = blocks.hits(
                        simd,
                        block,
                        *t_max,
                        #[inline(always)]
                        |hit| hit.t < ray.t_max,
                    );
                    if found {
                        return true;
                    }
                }
                false
            },
        )
    }

    /// Offers each triangle that the ray meets once to `accept`, in any order, until it returns true; returns whether
    /// it did.
    #[inline(always)]
    pub(super) fn any_hit<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        stack: &mut Stack,
        accept: &mut dyn FnMut(TriangleHit) -> bool,
    ) -> bool {
        let Some(root) = self.tree.root else { return false };
        let boxes = BoxRay::new(simd, ray, &self.bounds);
        let blocks = BlockRay::new(simd, ray);
        // Triangles in several leaves that have been offered already; a ray meets few of them.
        let mut offered: Vec<u32> = Vec::new();
        traverse::<S, AsTheyCome>(
            simd,
            &self.tree.nodes,
            root,
            &boxes,
            &mut { ray.t_max },
            stack,
            #[inline(always)]
            |leaf, t_max| {
                let mut offer = |hit: TriangleHit| {
                    if hit.t >= ray.t_max {
                        return false;
                    }
                    if hit.id & SPLIT != 0 {
                        if offered.contains(&hit.id) {
                            return false;
                        }
                        offered.push(hit.id);
                    }
                    accept(TriangleHit { id: hit.id & !SPLIT, ..hit })
                };
                for block in &self.blocks[leaf.items()] {
                    if blocks.hits(simd, block, *t_max, &mut offer) {
                        return true;
                    }
                }
                false
            },
        )
    }
}

/// Whether a triangle can be hit: its corners are finite and do not lie on one line.
pub(super) fn has_area([a, b, c]: &[Vec3; 3]) -> bool {
    let finite = a.is_finite() && b.is_finite() && c.is_finite();
    let (e1, e2) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    finite && e1.cross(e2) != glam::DVec3::ZERO
}
