//! The binary tree that the wide one is collapsed from: obvhs' PLOC and parallel reinsertion, driven so that the result
//! does not depend on the number of threads.

use std::ops::Range;

use glam::Vec3A;
use obvhs::Boundable;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

use crate::geometry::Aabb;

/// A primitive's box, or the box of a part of it, and which primitive it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) bounds: Aabb,
    pub(super) primitive: u32,
}

impl Boundable for Item {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        obvhs::aabb::Aabb::new(self.bounds.min.into(), self.bounds.max.into())
    }
}

/// A binary tree's node. Children of an inner node stand side by side, both after their parent.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub(super) bounds: Aabb,
    pub(super) content: Content,
}

/// What a [`BinaryNode`] holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// The index of the first of two children.
    Inner(u32),
    /// An index into the items the tree was built over.
    Item(u32),
}

/// Deepest tree whose subtrees are moved about. PLOC over boxes in geometric progression, each twice as large as all
/// before it, gives a chain; f32 leaves room for some 250 doublings with a few boxes each.
const MAX_OPTIMIZED_DEPTH: usize = 1000;

/// Rounds of PLOC that compare direct neighbours only: none. Empirical: one such round costs Sponza's rays 9% more
/// nodes and a living room's 4%, but a staircase's 12% fewer; which local optimum PLOC falls into is a matter of luck.
const FULL_SEARCH: usize = 0;

/// Boxes that a ray through all of the scene meets on average, by the ratio of surfaces, up to which there is a tree that is
/// worth looking for. Rooms have 10 to 60. A judgement.
const MOST_OVERLAP: f64 = 1024.0;

/// Boxes of which PLOC may merge one pair per round: that takes milliseconds.
const FEW: usize = 2048;

/// Builds the tree over `items`, node 0 the root; empty for no items.
pub(super) fn build(items: &[Item]) -> Vec<BinaryNode> {
    if items.is_empty() {
        return Vec::new();
    }
    if overlap_everywhere(items) || are_nested(items) {
        return median_tree(items);
    }

    // Items with one and the same box count as one: PLOC merges a single pair of equals per round, so that 40,000
    // copies of a triangle took it 55 s.
    let mut order: Vec<u32> = (0..items.len() as u32).collect();
    order.par_sort_unstable_by_key(|&i| (bits(&items[i as usize].bounds), i));
    let mut groups: Vec<Range<u32>> = Vec::with_capacity(items.len());
    let mut distinct: Vec<Item> = Vec::with_capacity(items.len());
    for (index, &i) in (0..).zip(&order) {
        match (groups.last_mut(), distinct.last()) {
            (Some(group), Some(item)) if bits(&item.bounds) == bits(&items[i as usize].bounds) => group.end = index + 1,
            _ => {
                groups.push(index..index + 1);
                distinct.push(items[i as usize]);
            }
        }
    }

    // Merge neighbours along a Morton curve, bottom up.
    let indices = (0..distinct.len() as u32).collect();
    let mut bvh = PlocBuilder::with_capacity(distinct.len()).build(
        PlocSearchDistance::Medium,
        &distinct,
        indices,
        SortPrecision::U128,
        FULL_SEARCH,
    );
    // Improve; obvhs sizes its stacks by the depth, which moves can increase.
    if bvh.max_depth <= MAX_OPTIMIZED_DEPTH {
        bvh.max_depth *= 4;
        reinsert(&mut bvh);
    }
    drop(distinct);
    breadth_first(&bvh, &order, &groups)
}

/// Whether boxes overlap so much that no tree is good: moving subtrees would compare each with hundreds of others, and 60,000
/// triangles that each fill a third of the scene took 12 s.
fn overlap_everywhere(items: &[Item]) -> bool {
    let half_area = |b: &Aabb| {
        let d = b.size().as_dvec3();
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    let (mut sum, mut all) = (0.0, Aabb::EMPTY);
    for item in items {
        sum += half_area(&item.bounds);
        all = all.union(item.bounds);
    }
    sum > MOST_OVERLAP * half_area(&all)
}

/// Whether most boxes hold the next smaller one, as Russian dolls do: of 200,000, PLOC merges one pair per round. False for
/// so few that rounds do not count.
fn are_nested(items: &[Item]) -> bool {
    if items.len() < FEW {
        return false;
    }
    let size = |item: &&Item| item.bounds.size().length_squared();
    let mut by_size: Vec<&Item> = items.iter().collect();
    by_size.par_sort_unstable_by(|a, b| size(a).total_cmp(&size(b)).then(a.primitive.cmp(&b.primitive)));
    let holds = |outer: &Aabb, inner: &Aabb| {
        outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all() && bits(outer) != bits(inner)
    };
    let nested = by_size.windows(2).filter(|pair| holds(&pair[1].bounds, &pair[0].bounds)).count();
    2 * nested > items.len()
}

/// A box as integers, to sort and compare by.
fn bits(bounds: &Aabb) -> [[u32; 3]; 2] {
    [bounds.min, bounds.max].map(|p| p.to_array().map(f32::to_bits))
}

/// Moves subtrees to where they cost least: Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy
/// Optimization", 2018. Rounds k = 1, 3, 5 … take the 1/k of the nodes with the largest surface.
///
/// The candidates are chosen here and not by `ReinsertionOptimizer::run`, whose radix sort is unstable and picks its
/// algorithm by the number of threads for more than 4 million nodes.
fn reinsert(bvh: &mut Bvh2) {
    let mut optimizer = ReinsertionOptimizer::default();
    for k in (1..32).step_by(2) {
        let mut candidates: Vec<(u32, u32)> =
            bvh.nodes.iter().zip(0..).skip(1).map(|(n, i)| (area_key(n), i)).collect();
        let count = candidates.len().div_ceil(k);
        if count < candidates.len() {
            candidates.select_nth_unstable(count);
            candidates.truncate(count);
        }
        candidates.par_sort_unstable();
        let candidates: Vec<u32> = candidates.into_iter().map(|(_, i)| i).collect();
        optimizer.run_with_candidates(bvh, &candidates, 1);
    }
}

/// Sorts nodes by falling surface; unique together with the index. Positive floats sort like their bits.
fn area_key(node: &Bvh2Node) -> u32 {
    !node.aabb().half_area().max(0.0).to_bits()
}

/// The tree in breadth-first order, which puts children after parents. Leaf i of `bvh` stands for the items
/// `order[groups[i]]`, which hang under it in a balanced tree.
fn breadth_first(bvh: &Bvh2, order: &[u32], groups: &[Range<u32>]) -> Vec<BinaryNode> {
    #[derive(Clone)]
    enum Source {
        Node(u32),
        Group(Aabb, Range<u32>),
    }
    let mut queue = vec![Source::Node(0)];
    let mut nodes = Vec::with_capacity(2 * order.len());
    while let Some(source) = queue.get(nodes.len()).cloned() {
        // A leaf is the group it stands for.
        let source = match source {
            Source::Node(i) if bvh.nodes[i as usize].is_leaf() => {
                let node = &bvh.nodes[i as usize];
                let group = bvh.primitive_indices[node.first_index as usize];
                Source::Group(aabb(node), groups[group as usize].clone())
            }
            other => other,
        };
        // Queue the children of an inner node, and the halves of a group.
        let first = queue.len() as u32;
        let (bounds, content) = match source {
            Source::Node(i) => {
                let node = &bvh.nodes[i as usize];
                queue.extend([Source::Node(node.first_index), Source::Node(node.first_index + 1)]);
                (aabb(node), Content::Inner(first))
            }
            Source::Group(bounds, range) if range.len() == 1 => (bounds, Content::Item(order[range.start as usize])),
            Source::Group(bounds, Range { start, end }) => {
                let middle = start.midpoint(end);
                queue.extend([Source::Group(bounds, start..middle), Source::Group(bounds, middle..end)]);
                (bounds, Content::Inner(first))
            }
        };
        nodes.push(BinaryNode { bounds, content });
    }
    nodes
}

fn aabb(node: &Bvh2Node) -> Aabb {
    Aabb { min: node.aabb().min.into(), max: node.aabb().max.into() }
}

/// A balanced tree for inputs of which [`build`] makes a chain: each node splits its items at the median of the centres
/// along the longest axis of their box. Depth ≤ 1 + ⌈log₂ n⌉. Empty for no items.
pub(super) fn median_tree(items: &[Item]) -> Vec<BinaryNode> {
    if items.is_empty() {
        return Vec::new();
    }
    let mut order: Vec<u32> = (0..items.len() as u32).collect();
    let union = |ids: &[u32]| ids.iter().fold(Aabb::EMPTY, |b, &i| b.union(items[i as usize].bounds));
    let mut nodes = vec![BinaryNode { bounds: union(&order), content: Content::Item(0) }];
    let mut pending = vec![(0, 0..items.len())];
    while let Some((node, range)) = pending.pop() {
        let ids = &mut order[range.clone()];
        if let [id] = *ids {
            nodes[node].content = Content::Item(id);
            continue;
        }
        // Split at the median along the longest axis.
        let centers = ids.iter().map(|&i| items[i as usize].bounds.center());
        let axis = Vec3A::from(Aabb::from_points(centers).size()).max_position();
        let half = ids.len() / 2;
        let key = |i: u32| items[i as usize].bounds.center()[axis];
        ids.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        // Both halves become children.
        let first = nodes.len();
        nodes[node].content = Content::Inner(first as u32);
        for part in [range.start..range.start + half, range.start + half..range.end] {
            pending.push((nodes.len(), part.clone()));
            nodes.push(BinaryNode { bounds: union(&order[part]), content: Content::Item(0) });
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(nodes: &[BinaryNode]) -> u32 {
        let mut depths = vec![0; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            if let Content::Inner(first) = node.content {
                let below = depths[i] + 1;
                depths[first as usize..][..2].fill(below);
            }
        }
        depths.into_iter().max().unwrap_or_default()
    }

    fn cubes(sizes: impl Iterator<Item = f32>) -> Vec<Item> {
        let bounds = |size: f32| Aabb { min: Vec3A::splat(-size).into(), max: Vec3A::splat(size).into() };
        (0..).zip(sizes).map(|(primitive, size)| Item { bounds: bounds(size), primitive }).collect()
    }

    /// Boxes in boxes, evenly or each a part larger than the last: PLOC would make a chain of them, one link a round.
    #[test]
    fn boxes_in_boxes_make_a_shallow_tree() {
        for items in [cubes((1..20_000).map(|i| i as f32)), cubes((1..20_000).map(|i| 1.004_f32.powi(i)))] {
            let nodes = build(&items);
            assert_eq!(nodes.len(), 2 * items.len() - 1);
            assert!(depth(&nodes) <= 16, "{}", depth(&nodes));
        }
    }
}
