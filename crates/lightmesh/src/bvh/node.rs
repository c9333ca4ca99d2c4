//! The 8-wide node and the references between nodes.

/// Children per node.
pub(super) const WIDTH: usize = 8;

/// A node: the boxes of eight children, one array per bounding plane, and where each child is.
///
/// `planes[axis][side][lane]` is the lower (`side` 0) or upper (`side` 1) bound of child `lane` along `axis`. The float
/// therefore starts at byte `64·axis + 32·side + 4·lane`, and the reference of child `lane` at byte `192 + 4·lane`; 224
/// bytes in all. Example: the upper y bound of child 3 is at byte 64·1 + 32·1 + 4·3 = 108.
///
/// An empty slot has lower bounds +∞ and upper bounds −∞, which no ray meets whatever its direction.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct Node {
    pub(super) planes: [[[f32; WIDTH]; 2]; 3],
    pub(super) children: [u32; WIDTH],
}

impl Node {
    /// A node without children.
    pub(super) const EMPTY: Self =
        Self { planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3], children: [0; WIDTH] };

    /// Puts a child into slot `lane`.
    pub(super) fn set_child(&mut self, lane: usize, min: [f32; 3], max: [f32; 3], child: ChildRef) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = min[axis];
            self.planes[axis][1][lane] = max[axis];
        }
        self.children[lane] = child.0;
    }
}

/// Most items of a leaf: a leaf's count takes three bits.
pub(super) const MAX_LEAF_ITEMS: usize = 8;

/// Where a child is: a node, or a run of leaf items (triangle blocks, or objects of the top level).
///
/// A node's reference is its index. A leaf's is `2³¹ + 8·first + (count − 1)`. Example: items 5, 6 and 7 are
/// `2³¹ + 8·5 + 2`. So a tree holds at most 2²⁸ items, four triangles each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChildRef(pub(super) u32);

const LEAF: u32 = 1 << 31;

impl ChildRef {
    pub(super) fn node(index: usize) -> Self {
        debug_assert!(index < LEAF as usize);
        Self(index as u32)
    }

    pub(super) fn leaf(first: usize, count: usize) -> Self {
        debug_assert!((1..=MAX_LEAF_ITEMS).contains(&count) && first < 1 << 28);
        Self(LEAF | (first as u32) << 3 | (count as u32 - 1))
    }

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    /// The items of a leaf.
    #[inline(always)]
    pub(super) fn items(self) -> std::ops::Range<usize> {
        let first = ((self.0 & !LEAF) >> 3) as usize;
        first..first + (self.0 & 7) as usize + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worked examples of the docs above.
    #[test]
    fn layout_is_the_documented_one() {
        assert_eq!(size_of::<Node>(), 224);
        let mut node = Node::EMPTY;
        node.set_child(3, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], ChildRef::leaf(5, 3));
        let floats: &[f32] = node.planes.as_flattened().as_flattened();
        assert_eq!(floats[108 / 4], 5.0);
        assert_eq!(ChildRef(node.children[3]).items(), 5..8);
        assert!(ChildRef::leaf(5, 3).is_leaf() && !ChildRef::node(41).is_leaf());
        assert_eq!(ChildRef::leaf(5, 3).0, (1 << 31) + 8 * 5 + 2);
    }
}
