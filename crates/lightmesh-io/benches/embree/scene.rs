//! The scene that the rays are shot in.

use glam::Vec3;
use lightmesh::geometry::Ray;
use lightmesh::{Camera, Light, Projection, SceneData};
use lightmesh_io::LoadOptions;

/// A scene file's geometry, its first camera and its lights' positions.
pub(crate) struct BenchScene {
    pub(crate) data: SceneData,
    pub(crate) lights: Vec<Vec3>,
    camera: Camera,
}

impl BenchScene {
    /// Loads a scene, Sponza by default.
    pub(crate) fn load(path: Option<&str>) -> Result<Self, String> {
        let sponza = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes/sponza_25.glb");
        let path = path.unwrap_or(sponza);
        let data = lightmesh_io::load(path.as_ref(), &LoadOptions::default()).map_err(|e| format!("{path}: {e}"))?.data;
        let camera = data.cameras.first().cloned().ok_or_else(|| format!("{path}: no camera"))?;
        let lights = data.lights.iter().filter_map(position).collect();
        Ok(Self { data, lights, camera })
    }

    /// All triangles in world space, instance by instance.
    pub(crate) fn world_triangles(&self) -> Vec<[Vec3; 3]> {
        let count = |i: usize| self.data.meshes[self.data.instances[i].mesh].triangles.len() as u32;
        (0..self.data.instances.len()).flat_map(|i| (0..count(i)).map(move |t| self.triangle(i as u32, t))).collect()
    }

    /// One triangle in world space.
    pub(crate) fn triangle(&self, instance: u32, triangle: u32) -> [Vec3; 3] {
        let instance = &self.data.instances[instance as usize];
        let mesh = &self.data.meshes[instance.mesh];
        mesh.triangles[triangle as usize]
            .map(|i| instance.world_from_object.transform_point3(mesh.positions[i as usize]))
    }

    /// The ray through a pixel's centre; orthographic cameras are taken for a pinhole of 45°.
    pub(crate) fn camera_ray(&self, x: usize, y: usize, width: usize, height: usize) -> Ray {
        let yfov = match self.camera.projection {
            Projection::Perspective { yfov, .. } => yfov,
            Projection::Orthographic { .. } => std::f32::consts::FRAC_PI_4,
        };
        let scale = 2.0 * (0.5 * yfov).tan() / height as f32;
        let px = (x as f32 + 0.5 - 0.5 * width as f32) * scale;
        let py = (0.5 * height as f32 - y as f32 - 0.5) * scale;
        let place = self.camera.world_from_camera.as_affine3a();
        Ray::new(place.translation.into(), place.transform_vector3(Vec3::new(px, py, -1.0)).normalize())
    }
}

/// Where a light with a place stands.
fn position(light: &Light) -> Option<Vec3> {
    match *light {
        Light::Point { position, .. } | Light::Spot { position, .. } => Some(position),
        Light::Directional { .. } => None,
    }
}
