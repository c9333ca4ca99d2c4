//! Builds meshes, with one index per corner, from the arrays of the text, where each corner has three.

use std::collections::HashMap;

use glam::{Affine3A, DVec3, Vec2, Vec3};
use lightmesh::geometry::TriangleMesh;
use lightmesh::{Instance, SceneData};

use super::Context;
use super::material::Materials;
use super::parse::{Corner, Obj, Part};
use crate::error::{Error, one_line};
use crate::polygon::triangulate;
use crate::world_origin::{WorldOrigin, relative};

/// Builds the scene: one mesh for each part that has faces, placed once.
pub(super) fn build(context: &mut Context<'_>, obj: &Obj) -> Result<SceneData, Error> {
    let mut origin = WorldOrigin::default();
    origin.add(&obj.positions, 1.0);
    let mut data = SceneData { origin: origin.choose(), ..SceneData::default() };
    let mut materials = Materials::load(context, &obj.libraries)?;
    for part in obj.parts.iter().filter(|part| !part.ends.is_empty()) {
        let material = materials.index_of(context, &part.material, &mut data)?;
        let mesh = mesh(context, obj, part, material, data.origin)?;
        data.instances.push(Instance { mesh: data.meshes.len(), world_from_object: Affine3A::IDENTITY });
        data.meshes.push(mesh);
    }
    if data.meshes.is_empty() {
        let what = match obj.positions.len() {
            0 => "the file has no vertices".into(),
            n => format!("the file has {n} vertices but no face of three corners or more"),
        };
        return Err(Error::Empty { file: one_line(context.file), what });
    }
    Ok(data)
}

/// The bytes that a vertex takes in the mesh and in the map that finds it again.
const VERTEX_BYTES: usize = 3 * size_of::<Vec3>() + size_of::<glam::Vec4>() + 2 * size_of::<(Corner, u32)>();

/// Builds the mesh of one part, relative to the scene's origin. Corners share a vertex if position, texture coordinate
/// and normal are the same.
fn mesh(
    context: &mut Context<'_>,
    obj: &Obj,
    part: &Part,
    material: usize,
    origin: DVec3,
) -> Result<TriangleMesh, Error> {
    // Find out which attributes the mesh has.
    let has_normal = |corner: &Corner| corner.normal.is_some_and(|i| obj.normals[i as usize] != Vec3::ZERO);
    let normals = part.corners.iter().any(has_normal);
    let uvs = part.corners.iter().any(|corner| corner.uv.is_some());
    let colors = !obj.colors.is_empty();
    let mut mesh = TriangleMesh { name: part.name.clone(), material, ..TriangleMesh::default() };

    // Pay for it as if no vertex were shared.
    let place = if part.name.is_empty() { "faces" } else { part.name.as_str() };
    context.budget.take(
        context.file,
        place,
        part.corners.len() as u64,
        (VERTEX_BYTES + size_of::<[u32; 3]>()) as u64,
    )?;
    // Read each face: share vertices that are known, add the others, and cut it into triangles.
    let mut vertex_of: HashMap<Corner, u32> = HashMap::new();
    let (mut positions, mut indices): (Vec<Vec3>, Vec<u32>) = (Vec::new(), Vec::new());
    let mut start = 0;
    for &end in &part.ends {
        let corners = &part.corners[start..end];
        start = end;
        positions.clear();
        positions.extend(corners.iter().map(|corner| relative(obj.positions[corner.position as usize], origin)));
        // Where other faces have normals, a corner without one takes its face's, and a vertex of its own.
        let face_normal = if normals && !corners.iter().all(has_normal) { newell(&positions) } else { Vec3::ZERO };
        indices.clear();
        for corner in corners {
            let own_normal = normals && !has_normal(corner);
            let known = if own_normal { None } else { vertex_of.get(corner).copied() };
            indices.push(known.unwrap_or_else(|| {
                let index = mesh.positions.len() as u32;
                mesh.positions.push(relative(obj.positions[corner.position as usize], origin));
                if normals {
                    let given = corner.normal.map_or(Vec3::ZERO, |i| obj.normals[i as usize]);
                    mesh.normals.push(if own_normal { face_normal } else { given });
                }
                if uvs {
                    mesh.uvs[0].push(corner.uv.map_or(Vec2::ZERO, |i| obj.uvs[i as usize]));
                }
                if colors {
                    let color = obj.colors.get(corner.position as usize).copied().unwrap_or(Vec3::ONE);
                    mesh.colors.push(color.extend(1.0));
                }
                if !own_normal {
                    vertex_of.insert(*corner, index);
                }
                index
            }));
        }
        triangulate(&positions, |t| mesh.triangles.push(t.map(|i| indices[i])));
    }
    Ok(mesh)
}

/// Returns the unit normal of a polygon; +Z if it has no area.
fn newell(corners: &[Vec3]) -> Vec3 {
    let origin = corners[0].as_dvec3();
    let sum: glam::DVec3 =
        corners[1..].windows(2).map(|p| (p[0].as_dvec3() - origin).cross(p[1].as_dvec3() - origin)).sum();
    sum.try_normalize().map_or(Vec3::Z, |n| n.as_vec3())
}
