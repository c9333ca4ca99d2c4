//! Shading the hits of many gather rays region by region, where lights are clusters.
//!
//! The rays of one mesh point end all over the scene: nearly every hit is in a region of its own, whose lights must be
//! packed and whose points' states be read. The hits of some hundred points share them.

use super::shading::{DirectLighting, ShadingBatch, ShadingSeconds};
use crate::Error;
use crate::mesh::CornerVisibility;

/// Vertices that are shaded together: of few regions, and enough batches for many threads.
const CHUNK: usize = 2048;

impl DirectLighting<'_, '_> {
    /// Shades the vertices of the batches, of which each has the light that it would have in any other order.
    ///
    /// # Errors
    /// As [`DirectLighting::shade`].
    pub(super) fn shade_by_region(
        &mut self,
        visibility: CornerVisibility,
        batches: &mut [&mut ShadingBatch],
    ) -> Result<ShadingSeconds, Error> {
        // Sort all vertices by region.
        let lights = self.field.lights();
        let mut order: Vec<(u64, u32, u32)> = Vec::new();
        for (batch, b) in batches.iter().zip(0..) {
            let places = batch.vertices.iter().zip(0..);
            order.extend(places.map(|(vertex, i)| (lights.region(vertex.position), b, i)));
        }
        order.sort_unstable();

        // Shade them.
        let gathered = |chunk: &[(u64, u32, u32)]| {
            let mut gathered = ShadingBatch::default();
            gathered.vertices.extend(chunk.iter().map(|&(_, b, i)| batches[b as usize].vertices[i as usize]));
            gathered
        };
        let mut chunks: Vec<ShadingBatch> = order.chunks(CHUNK).map(gathered).collect();
        let seconds = self.shade_together(visibility, &mut chunks.iter_mut().collect::<Vec<_>>())?;

        // Put their light where it belongs.
        for batch in batches.iter_mut() {
            batch.direct.clear();
            batch.direct.resize(batch.vertices.len(), glam::Vec3::ZERO);
        }
        for (places, mut chunk) in order.chunks(CHUNK).zip(chunks) {
            for (&(_, b, i), &irradiance) in places.iter().zip(&chunk.direct) {
                batches[b as usize].direct[i as usize] = irradiance;
            }
            chunk.take_counts(self.stats);
        }
        Ok(seconds)
    }
}
