//! Meshes, and all surfaces that are placed in the world.

use glam::{Vec2, Vec3, Vec4};

use super::invalid;
use crate::Error;
use crate::geometry::{Aabb, TriangleMesh};
use crate::scene::data::{Instance, SceneData};

/// The largest coordinate in the world, metres, less than the diameter of the Sun; the fourth power of such a number is
/// finite, as integrals over the patches of lamps need it.
pub(super) const FARTHEST: f32 = 1e9;

/// The largest coordinate of a mesh before it is placed.
const FARTHEST_IN_MESH: f32 = 1e18;

pub(super) fn check_meshes(data: &SceneData) -> Result<(), Error> {
    for (index, mesh) in data.meshes.iter().enumerate() {
        let object = || format!("mesh {index} \"{}\"", mesh.name);
        // Indices into the mesh and the scene.
        let n = mesh.positions.len();
        if mesh.material >= data.materials.len() {
            return invalid(object(), format!("material {} does not exist", mesh.material));
        }
        if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
            return invalid(object(), format!("position {i} is not finite"));
        }
        if let Some(i) = mesh.positions.iter().position(|p| p.abs().max_element() > FARTHEST_IN_MESH) {
            let farthest = mesh.positions[i].abs().max_element();
            return invalid(object(), format!("position {i} reaches {farthest:e}; {FARTHEST_IN_MESH:e} is the most"));
        }
        if let Some(&i) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= n) {
            return invalid(object(), format!("index {i} is out of range: the mesh has {n} positions"));
        }
        // Attributes: as many as positions, and finite.
        let lengths =
            [mesh.normals.len(), mesh.tangents.len(), mesh.uvs[0].len(), mesh.uvs[1].len(), mesh.colors.len()];
        if lengths.iter().any(|&len| len != 0 && len != n) {
            return invalid(object(), format!("an attribute's length is neither 0 nor the {n} of the positions"));
        }
        let finite = mesh.uvs.iter().flatten().all(|v: &Vec2| v.is_finite())
            && mesh.colors.iter().chain(&mesh.tangents).all(|v: &Vec4| v.is_finite());
        if !finite {
            return invalid(object(), "a texture coordinate, colour or tangent is not finite");
        }
    }
    Ok(())
}

/// Checks everything that is placed in the world: instances, spheres and shapes.
pub(super) fn check_placements(data: &mut SceneData, warnings: &mut Vec<String>) -> Result<(), Error> {
    // Check the instances' transforms.
    let mesh_bounds: Vec<Aabb> = data.meshes.iter().map(TriangleMesh::bounds).collect();
    for (index, instance) in data.instances.iter().enumerate() {
        if instance.mesh >= data.meshes.len() {
            return invalid(format!("instance {index}"), format!("mesh {} does not exist", instance.mesh));
        }
        let world = &instance.world_from_object;
        let object = || format!("instance {index} of mesh {} \"{}\"", instance.mesh, data.meshes[instance.mesh].name);
        if !world.is_finite() {
            return invalid(object(), "its transform is not finite");
        }
        let bounds = mesh_bounds[instance.mesh].transformed(world);
        if !bounds.is_empty() && !is_within_reach(bounds.min, bounds.max) {
            let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
            return invalid(object(), format!("it reaches {farthest:e} m; {FARTHEST:e} m is the most"));
        }
    }
    // Leave out instances that are scaled to nothing: they have no surface.
    let before = data.instances.len();
    let flat = |i: &Instance| i.world_from_object.matrix3.determinant() == 0.0;
    data.instances.retain(|i| !flat(i));
    if data.instances.len() < before {
        warnings.push(format!("{} instance(s) are scaled to nothing and left out", before - data.instances.len()));
    }
    // Check spheres and user-defined shapes.
    let materials = data.materials.len();
    for (index, sphere) in data.spheres.iter().enumerate() {
        if !(sphere.radius > 0.0 && sphere.radius.is_finite() && sphere.center.is_finite()) {
            return invalid(format!("sphere {index}"), format!("its radius {} must be above 0", sphere.radius));
        }
        let Aabb { min, max } = sphere.bounds();
        if !is_within_reach(min, max) {
            return invalid(format!("sphere {index}"), format!("it reaches beyond {FARTHEST:e} m"));
        }
        if sphere.material >= materials {
            return invalid(format!("sphere {index}"), format!("material {} does not exist", sphere.material));
        }
    }
    for (index, entry) in data.shapes.iter().enumerate() {
        let bounds = entry.shape.bounds();
        if bounds.is_empty() || !bounds.size().is_finite() {
            return invalid(format!("shape {index}"), "its bounds are empty or not finite");
        }
        if entry.material >= materials {
            return invalid(format!("shape {index}"), format!("material {} does not exist", entry.material));
        }
    }
    Ok(())
}

/// Whether a box keeps to the coordinates that the world may have.
pub(super) fn is_within_reach(min: Vec3, max: Vec3) -> bool {
    min.abs().max(max.abs()).max_element() <= FARTHEST
}
