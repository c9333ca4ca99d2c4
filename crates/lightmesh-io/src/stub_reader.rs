//! STUB, replaced by the glTF reader.
use std::path::Path;
use lightmesh::{Instance, Light, Material, SceneData, geometry::TriangleMesh};
/// Units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Units { #[default] Gltf, Blender }
/// Options.
#[derive(Clone, Debug, Default)]
#[allow(missing_docs)]
pub struct LoadOptions { pub units: Units, pub allow_outside: bool, pub scene: Option<String>, pub max_memory: u64 }
/// Result.
#[derive(Debug)]
#[allow(missing_docs)]
pub struct Loaded { pub data: SceneData, pub warnings: Vec<String> }
/// Error.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum Error { #[error("{0}: cannot be read: {1}")] Io(String, std::io::Error), #[error("{0}: bad")] Bad(String) }
/// Stub.
///
/// # Errors
/// Missing file.
pub fn load(path: &Path, _options: &LoadOptions) -> Result<Loaded, Error> {
    let bytes = std::fs::read(path).map_err(|e| Error::Io(path.display().to_string(), e))?;
    if bytes.is_empty() { return Err(Error::Bad(path.display().to_string())); }
    let text = String::from_utf8_lossy(&bytes);
    let mut data = SceneData::default();
    data.meshes.push(TriangleMesh { positions: vec![glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y], triangles: vec![[0, 1, 2]], ..Default::default() });
    data.instances.push(Instance { mesh: 0, world_from_object: glam::Affine3A::IDENTITY });
    data.materials.push(Material::default());
    if text.contains("KHR_lights_punctual") { data.lights.push(Light::Point { position: glam::Vec3::splat(2.0), intensity_cd: glam::Vec3::ONE, range: None }); }
    if text.contains("\"cameras\"") { data.cameras.push(lightmesh::Camera { name: "front".into(), ..lightmesh::Camera::look_at(glam::Vec3::new(0.3, 0.3, 3.0), glam::Vec3::new(0.3, 0.3, 0.0), 0.7) }); }
    Ok(Loaded { data, warnings: vec![] })
}
