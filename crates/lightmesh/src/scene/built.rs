//! STUB, replaced on main.
use super::SceneData;
use crate::{Error, geometry::Aabb};
/// The checked, built scene.
#[derive(Debug)]
pub struct Scene { data: SceneData }
impl Scene {
    /// Checks `data` once and builds what rays need.
    ///
    /// # Errors
    /// What is wrong with `data`.
    pub fn new(data: SceneData) -> Result<Self, Error> { Ok(Self { data }) }
    /// The description it was built from.
    pub fn data(&self) -> &SceneData { &self.data }
    /// The box around all surfaces, metres.
    pub fn bounds(&self) -> Aabb { self.data.meshes.iter().map(|m| m.bounds()).fold(Aabb::EMPTY, Aabb::union) }
    /// What was mended while building (zero-area triangles dropped, ...), one sentence each.
    pub fn warnings(&self) -> &[String] { &[] }
    /// Triangles with instances counted each.
    pub fn triangle_count(&self) -> u64 { 0 }
    /// Light samples that stand for all emitters.
    pub fn light_sample_count(&self) -> u64 { 0 }
}
