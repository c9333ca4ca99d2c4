//! Which meshes are copied into the world's tree, and which keep a tree of their own.

use glam::{Affine3A, DAffine3, DMat3, Mat3, Vec3};

use crate::geometry::{Ray, TriangleMesh};
use crate::scene::{Instance, SceneData};

/// Meshes used more than once are flattened as well if all copies together have no more triangles than this: a tree of
/// their own would cost more time than the copies cost memory (160 kB at most, for all of them 40 B a triangle).
const SMALL: usize = 1024;

/// Says of each mesh whether its instances are flattened.
pub(crate) fn flattened_meshes(data: &SceneData) -> Vec<bool> {
    let mut uses = vec![0_usize; data.meshes.len()];
    data.instances.iter().for_each(|i| uses[i.mesh] += 1);
    data.meshes.iter().zip(uses).map(|(mesh, n)| n <= 1 || n * mesh.triangles.len() <= SMALL).collect()
}

/// The corners of a mesh's triangles, transformed by `map`.
pub(crate) fn corners(mesh: &TriangleMesh, map: impl Fn(Vec3) -> Vec3) -> impl Iterator<Item = [Vec3; 3]> {
    let positions: Vec<Vec3> = mesh.positions.iter().map(|&p| map(p)).collect();
    mesh.triangles.iter().map(move |t| t.map(|i| positions[i as usize]))
}

/// Takes rays into an instance's object space.
///
/// The translation is subtracted before anything is rotated: for a ray that starts on the instance, far from the
/// world's origin, the difference is exact or nearly so.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectFromWorld {
    linear: Mat3,
    translation: Vec3,
}

impl ObjectFromWorld {
    /// `None` where `world_from_object` has no inverse: what it flattens to nothing is never hit.
    pub(crate) fn new(instance: &Instance) -> Option<Self> {
        let Affine3A { matrix3, translation } = instance.world_from_object;
        let affine = DAffine3 { matrix3: Mat3::from(matrix3).as_dmat3(), translation: glam::DVec3::ZERO };
        let inverse: DMat3 = affine.matrix3.inverse();
        let linear = inverse.as_mat3();
        let usable = affine.matrix3.determinant() != 0.0 && linear.is_finite() && translation.is_finite();
        usable.then_some(Self { linear, translation: translation.into() })
    }

    /// The same ray in object space; t stays the same number.
    pub(super) fn ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.linear * (ray.origin - self.translation), direction: self.linear * ray.direction, ..*ray }
    }
}
