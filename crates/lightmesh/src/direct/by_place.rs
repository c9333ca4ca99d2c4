//! Shading the hits of many gather rays place by place.
//!
//! The rays of one mesh point end all over the scene: nearly every hit is in a cell of its own, whose corners must be
//! looked up, and in a region of its own, where lights are clusters, whose lights must be packed. The hits of some hundred
//! points share them.

use glam::Vec3;

use super::shading::{DirectLighting, ShadingBatch, ShadingSeconds};
use crate::Error;
use crate::interaction::ShadingPoint;
use crate::mesh::CornerVisibility;

/// Vertices that are handled together: of few places, and enough batches for many threads.
pub(crate) const CHUNK: usize = 2048;

/// One vertex of many lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct PlacedVertex {
    place: u64,
    pub list: u32,
    pub index: u32,
}

/// Returns the vertices of some lists sorted by place: those of one place follow each other.
pub(crate) fn sort_by_place<'a>(
    lists: impl Iterator<Item = &'a [ShadingPoint]>,
    place: impl Fn(Vec3) -> u64,
) -> Vec<PlacedVertex> {
    let mut sorted = Vec::new();
    for (list, vertices) in lists.zip(0..).map(|(vertices, list)| (list, vertices)) {
        let placed =
            vertices.iter().zip(0..).map(|(v, index)| PlacedVertex { place: place(v.position), list, index });
        sorted.extend(placed);
    }
    sorted.sort_unstable();
    sorted
}

impl DirectLighting<'_, '_> {
    /// Shades the vertices of the batches, of which each has the light that it would have in any other order.
    ///
    /// # Errors
    /// As [`DirectLighting::shade`].
    pub(super) fn shade_by_place(
        &mut self,
        visibility: CornerVisibility,
        batches: &mut [&mut ShadingBatch],
    ) -> Result<ShadingSeconds, Error> {
        // Sort all vertices by place.
        let field = &*self.field;
        let order = sort_by_place(batches.iter().map(|batch| batch.vertices.as_slice()), |p| field.place(p));

        // Shade them.
        let gathered = |chunk: &[PlacedVertex]| {
            let mut gathered = ShadingBatch::default();
            let vertices = chunk.iter().map(|v| batches[v.list as usize].vertices[v.index as usize]);
            gathered.vertices.extend(vertices);
            gathered
        };
        let mut chunks: Vec<ShadingBatch> = order.chunks(CHUNK).map(gathered).collect();
        let seconds = self.shade_together(visibility, &mut chunks.iter_mut().collect::<Vec<_>>())?;

        // Put their light where it belongs.
        for batch in batches.iter_mut() {
            batch.direct.clear();
            batch.direct.resize(batch.vertices.len(), Vec3::ZERO);
        }
        for (vertices, mut chunk) in order.chunks(CHUNK).zip(chunks) {
            for (vertex, &irradiance) in vertices.iter().zip(&chunk.direct) {
                batches[vertex.list as usize].direct[vertex.index as usize] = irradiance;
            }
            chunk.take_counts(self.stats);
        }
        Ok(seconds)
    }
}
