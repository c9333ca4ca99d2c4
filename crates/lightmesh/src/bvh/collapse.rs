//! From the binary tree to the 8-wide one with leaves, at the least expected cost.

use super::binary_tree::{BinaryNode, Content};
use super::node::{ChildRef, MAX_LEAF_ITEMS, Node, WIDTH};
use crate::geometry::Aabb;

/// How leaves are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafRule {
    /// Primitives that one leaf item holds.
    pub(super) primitives_per_item: usize,
    /// Most items of one leaf, at most [`MAX_LEAF_ITEMS`].
    pub(super) max_items: usize,
    /// Cost of testing one leaf item, in units of testing one node.
    pub(super) item_cost: f32,
}

/// A wide tree: its nodes in depth-first order, and a reference to its root.
#[derive(Clone, Debug, Default)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<Node>,
    /// `None`: there is nothing in the tree.
    pub(super) root: Option<ChildRef>,
    /// Nodes on the longest way from the root to a leaf.
    pub(super) depth: usize,
}

/// How a subtree is best cut into at most `i + 1` pieces.
#[derive(Clone, Copy, Debug)]
enum Cut {
    /// One piece: a leaf.
    Leaf,
    /// One piece: a wide node over the best `WIDTH` pieces.
    Node,
    /// So many pieces from the left child, the others from the right one.
    Split { left: u8 },
    /// As with one piece fewer.
    Fewer,
}

/// Costs and choices of one binary node for 1 … `WIDTH` pieces.
#[derive(Clone, Copy)]
struct Choice {
    cost: [f32; WIDTH],
    cut: [Cut; WIDTH],
    primitives: u32,
}

/// Collapses a binary tree by dynamic programming over the number of pieces a subtree is cut into: Ylitie, Karras and
/// Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017, section 4.1. `emit_leaf`
/// gets the items under each leaf, depth first, and returns the run of leaf items it made of them.
pub(super) fn collapse(
    binary: &[BinaryNode],
    rule: LeafRule,
    emit_leaf: &mut dyn FnMut(&[u32]) -> std::ops::Range<usize>,
) -> WideTree {
    if binary.is_empty() {
        return WideTree::default();
    }
    let mut builder =
        Builder { binary, choices: choices(binary, rule), tree: WideTree::default(), under: Vec::new(), emit_leaf };
    // Emit the pieces depth first. Each entry: a piece's binary node, the slot of its reference, and its depth.
    let mut pending = vec![(0_usize, None, 0_usize)];
    while let Some((index, slot, depth)) = pending.pop() {
        let (child, grandchildren) = builder.emit(index);
        builder.tree.depth = builder.tree.depth.max(depth + 1);
        // Enter the reference into the parent.
        match slot {
            None => builder.tree.root = Some(child),
            Some((node, lane)) => {
                let Aabb { min, max } = binary[index].bounds;
                let node: &mut Node = &mut builder.tree.nodes[node];
                node.set_child(lane, min.to_array(), max.to_array(), child);
            }
        }
        // Go on with the pieces, the first on top.
        let node = child.0 as usize;
        pending.extend(
            grandchildren.into_iter().enumerate().rev().map(|(lane, piece)| (piece, Some((node, lane)), depth + 1)),
        );
    }
    builder.tree.nodes.shrink_to_fit();
    builder.tree
}

struct Builder<'a> {
    binary: &'a [BinaryNode],
    choices: Vec<Choice>,
    tree: WideTree,
    under: Vec<u32>,
    emit_leaf: &'a mut dyn FnMut(&[u32]) -> std::ops::Range<usize>,
}

impl Builder<'_> {
    /// Makes a leaf or a node of the subtree under a binary node. Returns its reference and the pieces that are its
    /// children.
    fn emit(&mut self, index: usize) -> (ChildRef, Vec<usize>) {
        if matches!(self.choices[index].cut[0], Cut::Leaf) {
            self.under.clear();
            items_under(self.binary, index, &mut self.under);
            let items = (self.emit_leaf)(&self.under);
            return (ChildRef::leaf(items.start, items.len()), Vec::new());
        }
        self.tree.nodes.push(Node::EMPTY);
        let mut pieces = Vec::with_capacity(WIDTH);
        self.pieces(index, WIDTH, true, &mut pieces);
        // The largest first, which rays meet most often.
        let area = |index: usize| half_area(&self.binary[index].bounds);
        pieces.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
        (ChildRef::node(self.tree.nodes.len() - 1), pieces)
    }

    /// Collects the roots of the at most `count` pieces that a binary node is best cut into; with `open` it is cut in
    /// any case.
    fn pieces(&self, index: usize, count: usize, open: bool, out: &mut Vec<usize>) {
        let mut count = count;
        while let Cut::Fewer = self.choices[index].cut[count - 1] {
            count -= 1;
        }
        match (self.choices[index].cut[count - 1], self.binary[index].content) {
            (Cut::Split { left }, Content::Inner(first)) => {
                self.pieces(first as usize, left as usize, false, out);
                self.pieces(first as usize + 1, count - left as usize, false, out);
            }
            // `choices` never makes one piece the best cut of an opened node.
            _ => {
                debug_assert!(!open);
                out.push(index);
            }
        }
    }
}

/// Collects the items under a binary node, depth first.
fn items_under(binary: &[BinaryNode], index: usize, out: &mut Vec<u32>) {
    let mut pending = vec![index];
    while let Some(index) = pending.pop() {
        match binary[index].content {
            Content::Item(item) => out.push(item),
            Content::Inner(first) => pending.extend([first as usize + 1, first as usize]),
        }
    }
}

/// Finds the best costs of every binary node, children before parents.
fn choices(binary: &[BinaryNode], rule: LeafRule) -> Vec<Choice> {
    let none = Choice { cost: [0.0; WIDTH], cut: [Cut::Leaf; WIDTH], primitives: 1 };
    let max_leaf = (rule.max_items.min(MAX_LEAF_ITEMS) * rule.primitives_per_item) as u32;
    let mut choices = vec![none; binary.len()];
    for (index, node) in binary.iter().enumerate().rev() {
        let area = half_area(&node.bounds);
        // An item is one piece, a leaf.
        let Content::Inner(first) = node.content else {
            let cost = area * rule.item_cost;
            choices[index] = Choice { cost: [cost; WIDTH], cut: [Cut::Leaf; WIDTH], primitives: 1 };
            choices[index].cut[1..].fill(Cut::Fewer);
            continue;
        };
        let (left, right) = (choices[first as usize], choices[first as usize + 1]);
        let mut choice = none;
        choice.primitives = left.primitives + right.primitives;

        // Two or more pieces: the best way to share them between the children.
        for pieces in 2..=WIDTH {
            let share = |l: usize| left.cost[l - 1] + right.cost[pieces - l - 1];
            let mut best = (share(1), 1);
            for l in 2..pieces {
                if share(l) < best.0 {
                    best = (share(l), l);
                }
            }
            choice.cost[pieces - 1] = best.0;
            choice.cut[pieces - 1] = Cut::Split { left: best.1 as u8 };
        }

        // One piece: a wide node over the best eight, or a leaf if it is small enough and cheaper.
        let as_node = area + choice.cost[WIDTH - 1];
        let items = (choice.primitives as usize).div_ceil(rule.primitives_per_item);
        let as_leaf = area * items as f32 * rule.item_cost;
        let leaf = choice.primitives <= max_leaf && as_leaf <= as_node;
        (choice.cost[0], choice.cut[0]) = if leaf { (as_leaf, Cut::Leaf) } else { (as_node, Cut::Node) };

        // Fewer pieces may be cheaper; an opened node keeps the best real split, of two pieces or more.
        for pieces in 2..WIDTH {
            if choice.cost[pieces - 2] <= choice.cost[pieces - 1] {
                choice.cost[pieces - 1] = choice.cost[pieces - 2];
                choice.cut[pieces - 1] = Cut::Fewer;
            }
        }
        choices[index] = choice;
    }
    choices
}

/// Half the surface of a box, square metres.
pub(super) fn half_area(bounds: &Aabb) -> f32 {
    let d = bounds.size();
    d.x * d.y + d.y * d.z + d.z * d.x
}
