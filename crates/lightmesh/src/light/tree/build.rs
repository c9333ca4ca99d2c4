//! Building the trees from the top down: each node is split at the middle of its widest extent.

use glam::Vec3;

use super::super::sample::{LightEmission, SampledLight};
use super::super::samples::LightSamples;
use super::{Kind, LightTree, Node, moments};

/// A light sample on its way into a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub light: SampledLight,
    pub lane: u32,
}

impl Leaf {
    /// R + G + B.
    pub(super) fn strength(&self) -> f32 {
        self.light.intensity.element_sum()
    }

    /// Which way it shines; zero for isotropic and directional lights.
    pub(super) fn axis(&self) -> Vec3 {
        match self.light.emission {
            LightEmission::Isotropic | LightEmission::Directional => Vec3::ZERO,
            LightEmission::Patch { normal, .. } => normal,
            LightEmission::Spot { cone, .. } => cone.axis,
        }
    }

    fn kind(&self) -> Kind {
        match self.light.emission {
            LightEmission::Isotropic => Kind::Isotropic,
            LightEmission::Patch { back: 0.0, .. } => Kind::OneSided,
            LightEmission::Patch { .. } => Kind::TwoSided,
            LightEmission::Spot { .. } => Kind::Spot,
            LightEmission::Directional => Kind::Directional,
        }
    }

    /// Turns a patch whose both sides shine to have its normal in the upper hemisphere: patches of opposite normals are
    /// alike.
    fn upright(mut self) -> Self {
        if let LightEmission::Patch { normal, back, .. } = &mut self.light.emission
            && *back != 0.0
            && normal.to_array() < [0.0; 3]
        {
            *normal = -*normal;
        }
        self
    }
}

impl LightTree {
    /// The trees over all samples.
    pub(crate) fn new(samples: &LightSamples) -> Self {
        // Sort the lights by kind.
        let leaf = |lane| samples.sample(lane).map(|light| Leaf { light, lane: lane as u32 }.upright());
        let mut leaves: Vec<Leaf> = (0..samples.lanes()).filter_map(leaf).collect();
        leaves.sort_by_key(Leaf::kind);
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * leaves.len()),
            representatives: Vec::with_capacity(2 * leaves.len()),
            orientations: Vec::new(),
            first_oriented: usize::MAX,
            first_direction: u32::MAX,
            roots: Vec::new(),
            lanes: Vec::new(),
            sums: Vec::new(),
        };
        // Build a tree for each kind.
        let mut first = 0;
        for kind_leaves in leaves.chunk_by_mut(|a, b| a.kind() == b.kind()) {
            let (root, kind) = (tree.nodes.len() as u32, kind_leaves[0].kind());
            tree.roots.push(root);
            if kind == Kind::Directional {
                tree.first_direction = root;
            }
            tree.add(kind, kind_leaves, first);
            tree.grow(kind_leaves, first);
            first += kind_leaves.len();
        }
        // Sum the strengths in the order of the leaves, to choose lights by.
        let mut sum = 0.0;
        for leaf in &leaves {
            sum += f64::from(leaf.strength());
            tree.lanes.push(leaf.lane);
            tree.sums.push(sum);
        }
        tree
    }

    /// Grows a tree from its root, which was added last.
    fn grow(&mut self, leaves: &mut [Leaf], offset: usize) {
        let mut scratch = Vec::new();
        let mut open = vec![self.nodes.len() - 1];
        while let Some(parent) = open.pop() {
            let Node { kind, first, count, .. } = self.nodes[parent];
            if count < 2 {
                continue;
            }
            let begin = first as usize - offset;
            let part = &mut leaves[begin..][..count as usize];
            let left = split(part, kind, &mut scratch);
            let (left, right) = part.split_at(left);
            let child = self.nodes.len();
            self.add(kind, left, first as usize);
            self.add(kind, right, first as usize + left.len());
            self.nodes[parent].child = child as u32;
            open.extend([child + 1, child]);
        }
    }

    fn add(&mut self, kind: Kind, leaves: &[Leaf], first: usize) {
        let (node, mut representative) = Node::new(kind, leaves, first as u32);
        if let Some((orientation, oriented)) = moments::orientation(kind, leaves, &representative) {
            self.first_oriented = self.first_oriented.min(self.nodes.len());
            self.orientations.push(orientation);
            representative = oriented;
        }
        self.representatives.push(representative);
        self.nodes.push(node);
    }
}

/// Partitions leaves at the middle of their widest extent, in place and in order, and returns how many are in the first
/// part. Axes count too, as in Lightcuts (section 3.3): a right angle between them as much as half of the box's
/// diagonal; empirical, as the paper's.
fn split(leaves: &mut [Leaf], kind: Kind, scratch: &mut Vec<Leaf>) -> usize {
    // Find the widest extent, of positions or of axes.
    let range = |of: fn(&Leaf) -> Vec3| {
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        leaves.iter().fold(start, |(min, max), leaf| (min.min(of(leaf)), max.max(of(leaf))))
    };
    let position: fn(&Leaf) -> Vec3 = |leaf| leaf.light.position;
    let (min, max) = range(position);
    let mut widest = (position, min, max);
    if !matches!(kind, Kind::Isotropic | Kind::Directional) {
        let axes = range(Leaf::axis);
        if (axes.1 - axes.0).max_element() * 0.5 * (max - min).length() > (max - min).max_element() {
            widest = (Leaf::axis, axes.0, axes.1);
        }
    }
    let (of, min, max) = widest;
    let size = max - min;
    let axis = if size.x >= size.y.max(size.z) {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = 0.5 * (min[axis] + max[axis]);
    // Partition at its middle, in order.
    scratch.clear();
    let mut left = 0;
    for i in 0..leaves.len() {
        if of(&leaves[i])[axis] < middle {
            leaves[left] = leaves[i];
            left += 1;
        } else {
            scratch.push(leaves[i]);
        }
    }
    leaves[left..].copy_from_slice(scratch);
    // All are at one position: any halves are as good.
    if left == 0 || left == leaves.len() { leaves.len() / 2 } else { left }
}
