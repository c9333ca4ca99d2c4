//! The plain description of a scene, as a reader or a program fills it in.

use std::sync::Arc;

use glam::{Affine3A, DVec3};

use super::camera::Camera;
use super::environment::Environment;
use super::light::Light;
use super::material::Material;
use super::texture::{ImageData, Texture};
use crate::geometry::{Aabb, Shape, Sphere, TriangleMesh};

/// A mesh placed in the world.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instance {
    /// Index into [`SceneData::meshes`].
    pub mesh: usize,
    /// World space from the mesh's object space; a mirroring transform keeps the front side the front.
    pub world_from_object: Affine3A,
}

/// A user-defined surface and its material.
#[derive(Clone, Debug)]
pub struct ShapeEntry {
    /// The surface, in world space.
    pub shape: Arc<dyn Shape>,
    /// Index into [`SceneData::materials`].
    pub material: usize,
}

/// Everything that a scene file says, in plain arrays: metres, Y up or not as the author likes, candela, lux and cd/m².
///
/// It may be inconsistent: `Scene::new` checks it once and builds what rays need.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SceneData {
    /// Where the origin of world space is in the coordinates of the file, metres; zero unless a reader chose another.
    /// Everything here is relative to it but [`SceneData::cameras`], which keep the file's coordinates: what is far from
    /// the file's origin, as in a survey, keeps the digits of 32-bit floats for itself.
    #[cfg_attr(feature = "serde", serde(default))]
    pub origin: DVec3,
    /// Triangle meshes in object space.
    pub meshes: Vec<TriangleMesh>,
    /// Meshes placed in the world. A mesh with many instances is stored once.
    pub instances: Vec<Instance>,
    /// Analytic spheres in world space.
    pub spheres: Vec<Sphere>,
    /// User-defined surfaces in world space; they are not serialised.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub shapes: Vec<ShapeEntry>,
    /// Materials; surfaces refer to them by index.
    pub materials: Vec<Material>,
    /// Textures: an image with its wrap modes and filter.
    pub textures: Vec<Texture>,
    /// Decoded images.
    pub images: Vec<ImageData>,
    /// Punctual lights.
    pub lights: Vec<Light>,
    /// The light of rays that leave the scene; `None`: black.
    pub environment: Option<Environment>,
    /// Cameras of the file, in its own coordinates.
    pub cameras: Vec<Camera>,
}

impl SceneData {
    /// Returns [`Camera::framing`] of all surfaces, in the file's coordinates.
    pub fn framing_camera(&self) -> Camera {
        let mut camera = Camera::framing(&self.bounds());
        camera.world_from_camera.translation += self.origin;
        camera
    }

    /// Returns a box around all surfaces, metres. The data may be unchecked: indices out of range are left out. The box
    /// of a rotated instance may be larger than needed, as the box of the mesh is transformed.
    pub fn bounds(&self) -> Aabb {
        let placed = self.instances.iter().filter_map(|instance| {
            let mesh = self.meshes.get(instance.mesh)?;
            let used = mesh.triangles.iter().flatten().filter_map(|&i| mesh.positions.get(i as usize));
            Some(Aabb::from_points(used.copied()).transformed(&instance.world_from_object))
        });
        let spheres = self.spheres.iter().map(Sphere::bounds);
        let shapes = self.shapes.iter().map(|entry| entry.shape.bounds());
        placed.chain(spheres).chain(shapes).fold(Aabb::EMPTY, Aabb::union)
    }
}
