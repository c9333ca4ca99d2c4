//! Indexed triangle meshes.

use glam::{Vec2, Vec3, Vec4};

use super::aabb::Aabb;

/// A triangle mesh in object space with one material.
///
/// Every attribute but `positions` may be empty ("not given"); otherwise it has the length of `positions`.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TriangleMesh {
    /// Name in the file, for messages; may be empty.
    pub name: String,
    /// Corner positions, metres before the instance's transform.
    pub positions: Vec<Vec3>,
    /// Three indices into the attributes per triangle; counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals, unit. Empty: the geometric normal.
    pub normals: Vec<Vec3>,
    /// Tangents, unit, w = ±1 the handedness as in glTF. Empty: derived from `uvs[0]`.
    pub tangents: Vec<Vec4>,
    /// Texture coordinates of set 0 and set 1, (0, 0) the image's upper left corner.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear RGBA that multiplies the base colour.
    pub colors: Vec<Vec4>,
    /// Index into [`SceneData::materials`](crate::scene::SceneData::materials).
    pub material: usize,
}

impl TriangleMesh {
    /// The box around all positions that a triangle uses.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.triangles.iter().flatten().map(|&i| self.positions[i as usize]))
    }
}
