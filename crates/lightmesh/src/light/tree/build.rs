//! Building the trees: halves of the widest extent, from the top down.

use glam::Vec3;

use super::super::sample::{LightEmission, SampledLight};
use super::super::samples::LightSamples;
use super::{Kind, LightTree, Node, moments};

/// A light sample on its way into a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub luminaire: SampledLight,
    pub lane: u32,
}

impl Leaf {
    /// R + G + B.
    pub(super) fn strength(&self) -> f32 {
        self.luminaire.intensity.element_sum()
    }

    /// Which way it shines; zero for even ones and directions, whose place says it.
    pub(super) fn axis(&self) -> Vec3 {
        match self.luminaire.emission {
            LightEmission::Isotropic => Vec3::ZERO,
            LightEmission::Patch { axis, .. } | LightEmission::Spot { axis, .. } => axis,
        }
    }

    fn kind(&self) -> Kind {
        match self.luminaire.emission {
            LightEmission::Isotropic => Kind::Even,
            LightEmission::Patch { back: 0.0, .. } => Kind::OneSided,
            LightEmission::Patch { .. } => Kind::TwoSided,
            LightEmission::Spot { w: 0.0, .. } => Kind::Direction,
            LightEmission::Spot { .. } => Kind::Shaped,
        }
    }

    /// With a normal of the upper hemisphere where both sides shine: patches that are one behind the other are alike.
    fn upright(mut self) -> Self {
        if let LightEmission::Patch { axis, back, .. } = &mut self.luminaire.emission
            && *back != 0.0
            && axis.to_array() < [0.0; 3]
        {
            *axis = -*axis;
        }
        self
    }
}

impl LightTree {
    /// The trees over all samples.
    pub(crate) fn new(samples: &LightSamples) -> Self {
        let leaf = |lane| samples.sample(lane).map(|luminaire| Leaf { luminaire, lane: lane as u32 }.upright());
        let mut leaves: Vec<Leaf> = (0..samples.lanes()).filter_map(leaf).collect();
        leaves.sort_by_key(Leaf::kind);
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * leaves.len()),
            luminaires: Vec::with_capacity(2 * leaves.len()),
            orientations: Vec::new(),
            first_oriented: usize::MAX,
            first_direction: u32::MAX,
            roots: Vec::new(),
            lanes: Vec::new(),
            sums: Vec::new(),
        };
        let mut first = 0;
        for of_kind in leaves.chunk_by_mut(|a, b| a.kind() == b.kind()) {
            let (root, kind) = (tree.nodes.len() as u32, of_kind[0].kind());
            tree.roots.push(root);
            if kind == Kind::Direction {
                tree.first_direction = root;
            }
            tree.add(kind, of_kind, first);
            tree.grow(of_kind, first);
            first += of_kind.len();
        }
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
        let (node, mut luminaire) = Node::new(kind, leaves, first as u32);
        if let Some((orientation, oriented)) = moments::orientation(kind, leaves, &luminaire) {
            self.first_oriented = self.first_oriented.min(self.nodes.len());
            self.orientations.push(orientation);
            luminaire = oriented;
        }
        self.luminaires.push(luminaire);
        self.nodes.push(node);
    }
}

/// Divides leaves at the middle of their widest extent, in place and in order, and returns how many come first. Axes count too, as in
/// Lightcuts (section 3.3): a right angle between them as much as half of the box's diagonal; empirical, as the paper's.
fn split(leaves: &mut [Leaf], kind: Kind, scratch: &mut Vec<Leaf>) -> usize {
    let range = |of: fn(&Leaf) -> Vec3| {
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        leaves.iter().fold(start, |(min, max), leaf| (min.min(of(leaf)), max.max(of(leaf))))
    };
    let place: fn(&Leaf) -> Vec3 = |leaf| leaf.luminaire.position;
    let (min, max) = range(place);
    let mut widest = (place, min, max);
    if !matches!(kind, Kind::Even | Kind::Direction) {
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
    // Partition in order.
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
    // All in one place: any halves are as good.
    if left == 0 || left == leaves.len() { leaves.len() / 2 } else { left }
}
