//! What a mesh knows, as plain arrays: for files, for other processes, and to look at.
//!
//! A mesh only ever gains points, and the value of each depends on scene and settings alone. So a copy of the points since some time
//! is all that another mesh of the same scene and settings lacks of what this one learned meanwhile, and it does not matter in which
//! order copies are taken in.

mod check;
mod copy;
mod merge;
mod points;

use crate::mesh::LatticeShape;

/// Points of a mesh: those that give light first, then those that were found inside solids or on surfaces and give none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointSnapshot {
    /// By level; level l has half the spacing of level l − 1.
    pub lattices: Vec<LatticeShape>,
    /// Level and lattice coordinates of each point that gives light: `[level, i, j, k]`. N of them in what follows.
    pub addresses: Vec<[u32; 4]>,
    /// For each of them, how far the next solid surface is along +x, −x, +y, −y, +z, −z: in 1/255 of its level's spacing, rounded down, at
    /// most 254; 255: there is none before the neighbour.
    pub clearances: Vec<[u8; 6]>,
    /// Level and lattice coordinates of each point that gives none.
    pub invalid: Vec<[u32; 4]>,
}

/// What is known of direct light. The variant follows from the method.
#[derive(Clone, Debug, PartialEq)]
pub enum DirectValues {
    /// [`Method::Mesh`](crate::options::Method::MESH): shape (N, 6, 2, 3), lux. By point, for the planes that face +x, −x, +y, −y, +z, −z, the
    /// irradiance that arrives and the one that would if nothing were in the way, RGB. (With another falloff than r², in its units.)
    SixAxis(Vec<f32>),
    /// [`Method::Paper`](crate::options::Method::PAPER): shape (N, 2, 3). DirectLight of formula (1), RGB, and what it is divided by.
    Scalar(Vec<f32>),
    /// What is known of each single light: a bit per light in two rows, lowest first. Both set: all of its light arrives; none: nothing
    /// does; only the second: some does, or the point cannot tell.
    Lights {
        /// W, words of a row.
        words: u32,
        /// Shape (N, 2, W).
        bits: Vec<u64>,
    },
    /// The same where lights are clusters: by point some runs, `leaf · 4 + state` of the light from which on the state holds, in the
    /// order of the light tree's leaves, the first for leaf 0; state 0 unknown, 1 nothing arrives, 2 all of it does.
    Runs {
        /// By point, where its runs end.
        ends: Vec<u64>,
        /// All runs, point by point.
        runs: Vec<u32>,
    },
}

/// The direct mesh's contents.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectSnapshot {
    /// Its points.
    pub points: PointSnapshot,
    /// What they know.
    pub values: DirectValues,
}

/// The indirect mesh's contents.
#[derive(Clone, Debug, PartialEq)]
pub struct IndirectSnapshot {
    /// Its points.
    pub points: PointSnapshot,
    /// The most reflections: there are values for 0 to so many.
    pub bounces: u32,
    /// S: 6, or 1 with [`Method::Paper`](crate::options::Method::PAPER).
    pub faces: u32,
    /// Shape (bounces + 1, N, S, 3). By number of reflections and point, for the planes that face +x, −x, +y, −y, +z, −z, the irradiance that
    /// arrives after so many diffuse reflections or fewer, RGB, lux; light that comes straight from lamps is not in it. Where S is 1,
    /// IndirectLight of formula (4): a quarter of it is the irradiance on any plane, were the light even.
    pub values: Vec<f32>,
    /// Sum of the direct irradiances (mean over channels, lux) where gather rays ended: for the estimate of
    /// [`RenderStats::truncated_light`](crate::RenderStats::truncated_light).
    pub hit_irradiance: f64,
    /// How many they were.
    pub hit_count: u64,
}

/// A copy of what a [`LightMesh`](crate::LightMesh) knows, or of what it learned since some time.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Of direct light.
    pub direct: DirectSnapshot,
    /// Of indirect light, where the mesh has any.
    pub indirect: Option<IndirectSnapshot>,
}

/// How much a mesh knew at some time. The default: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cursor {
    direct: PointCursor,
    indirect: PointCursor,
    hit_irradiance: (f64, u64),
}

/// Points of one mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PointCursor {
    pub valid: usize,
    pub invalid: usize,
}

impl PointSnapshot {
    /// Positions of the points that give light, metres: shape (N, 3).
    pub fn positions(&self) -> Vec<[f32; 3]> {
        self.positions_of(&self.addresses)
    }

    /// Positions of the points that give none, metres.
    pub fn invalid_positions(&self) -> Vec<[f32; 3]> {
        self.positions_of(&self.invalid)
    }

    /// Of addresses that lead nowhere NaN.
    fn positions_of(&self, addresses: &[[u32; 4]]) -> Vec<[f32; 3]> {
        let position = |&[level, i, j, k]: &[u32; 4]| {
            self.lattices.get(level as usize).map_or([f32::NAN; 3], |lattice| lattice.position([i, j, k]))
        };
        addresses.iter().map(position).collect()
    }
}

impl IndirectSnapshot {
    /// What arrives after so many reflections or fewer: shape (N, S, 3), as in [`IndirectSnapshot::values`]. Empty for more than there are.
    pub fn after(&self, bounces: u32) -> &[f32] {
        let one = self.points.addresses.len() * self.faces as usize * 3;
        let first = (bounces as usize).saturating_mul(one);
        self.values.get(first..first.saturating_add(one)).unwrap_or_default()
    }
}

impl Snapshot {
    /// How many points there are, those that give no light too.
    pub fn point_count(&self) -> u64 {
        let count = |points: &PointSnapshot| (points.addresses.len() + points.invalid.len()) as u64;
        count(&self.direct.points) + self.indirect.as_ref().map_or(0, |indirect| count(&indirect.points))
    }
}
