//! Snapshots: the points of a mesh as plain arrays, for files, other processes and analysis.
//!
//! A mesh only ever gains points, and the value of each depends on scene and settings alone. So a snapshot of the
//! points since some time brings another mesh of the same scene and settings up to date, and snapshots may be merged in
//! any order.

mod copy;
mod merge;
mod points;

pub use crate::direct::DirectValues;
use crate::mesh::LatticeShape;

/// Points of one mesh. Valid points have values; invalid ones are inside solids or on surfaces and have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointSnapshot {
    /// The lattice of each level; level l has half the spacing of level l − 1.
    pub lattices: Vec<LatticeShape>,
    /// Level and lattice coordinates of each valid point, `[level, i, j, k]`. N is their number.
    pub addresses: Vec<[i32; 4]>,
    /// For each valid point, the distance to the next opaque surface along +x, −x, +y, −y, +z, −z, in 1/255 of its
    /// level's spacing, rounded down, at most 254. 255: there is no surface up to the neighbouring point.
    pub clearances: Vec<[u8; 6]>,
    /// Level and lattice coordinates of each invalid point.
    pub invalid: Vec<[i32; 4]>,
}

/// Points of the direct mesh with their values.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectSnapshot {
    /// The points.
    pub points: PointSnapshot,
    /// Their values.
    pub values: DirectValues,
}

/// Points of the indirect mesh with their values.
#[derive(Clone, Debug, PartialEq)]
pub struct IndirectSnapshot {
    /// The points.
    pub points: PointSnapshot,
    /// B: there are values for 0 to B diffuse reflections.
    pub bounces: u32,
    /// S, the number of cube faces: 6, or 1 with [`Method::Paper`](crate::options::Method::Paper).
    pub faces: u32,
    /// Shape (B + 1, N, S, 3), RGB, lux. For each number of reflections k, each point and each plane that faces +x, −x,
    /// +y, −y, +z, −z: the irradiance after k diffuse reflections or fewer, without the light that comes straight from
    /// lamps. Where S is 1: IndirectLight of formula (4); if the light is the same from all sides, a quarter of it is
    /// the irradiance on any plane.
    pub values: Vec<f32>,
    /// The sum of the direct irradiances (mean over channels, lux) at the ends of gather rays, for the estimate of
    /// [`RenderStats::truncated_light`](crate::RenderStats::truncated_light).
    pub hit_irradiance: f64,
    /// The number of irradiances in that sum.
    pub hit_count: u64,
}

/// A copy of all points of a [`LightMesh`](crate::LightMesh), or of those that it has gained since some time.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Direct light.
    pub direct: DirectSnapshot,
    /// Indirect light, where the mesh has any.
    pub indirect: Option<IndirectSnapshot>,
}

/// A state of a mesh in time: which points it has. The default is the empty mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cursor {
    direct: PointCursor,
    indirect: PointCursor,
    hit_irradiance: (f64, u64),
}

/// How many points one mesh has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PointCursor {
    pub valid: usize,
    pub invalid: usize,
}

impl PointSnapshot {
    /// Returns the positions of the valid points, metres: shape (N, 3).
    pub fn positions(&self) -> Vec<[f32; 3]> {
        self.positions_of(&self.addresses)
    }

    /// Returns the positions of the invalid points, metres.
    pub fn invalid_positions(&self) -> Vec<[f32; 3]> {
        self.positions_of(&self.invalid)
    }

    /// Returns positions; NaN for addresses on levels that there are not.
    fn positions_of(&self, addresses: &[[i32; 4]]) -> Vec<[f32; 3]> {
        let position = |&[level, i, j, k]: &[i32; 4]| {
            self.lattices.get(level.max(0) as usize).map_or([f32::NAN; 3], |lattice| lattice.position([i, j, k]))
        };
        addresses.iter().map(position).collect()
    }
}

impl IndirectSnapshot {
    /// Returns the irradiance after `bounces` reflections or fewer: shape (N, S, 3), as in
    /// [`IndirectSnapshot::values`]; empty if `bounces` is more than [`IndirectSnapshot::bounces`].
    pub fn after(&self, bounces: u32) -> &[f32] {
        let one = self.points.addresses.len() * self.faces as usize * 3;
        let first = (bounces as usize).saturating_mul(one);
        self.values.get(first..first.saturating_add(one)).unwrap_or_default()
    }
}

impl Snapshot {
    /// Returns the number of valid and invalid points of both meshes.
    pub fn point_count(&self) -> u64 {
        let count = |points: &PointSnapshot| (points.addresses.len() + points.invalid.len()) as u64;
        count(&self.direct.points) + self.indirect.as_ref().map_or(0, |indirect| count(&indirect.points))
    }
}
