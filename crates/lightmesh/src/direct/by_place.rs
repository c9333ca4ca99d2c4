//! Vertices from all over the scene, as gather rays find them, sorted by place.
//!
//! The rays of one mesh point end all over the scene: nearly every hit is in a cell of its own, whose corners must be
//! looked up, and in a region of its own, where lights are clusters, whose lights must be packed. The hits of some hundred
//! points share them.

use glam::Vec3;
use rayon::prelude::*;

use super::plan::Shading;
use super::shading::{DirectLighting, ShadingBatch, ShadingSeconds};
use crate::Error;
use crate::interaction::ShadingPoint;
use crate::mesh::CornerVisibility;

/// Vertices that are handled together: of few places, and enough batches for many threads.
const CHUNK: usize = 2048;

/// The vertices of some lists, those of one place one after the other. Each gets the light that it would get in any other
/// order.
#[derive(Debug, Default)]
pub(crate) struct PlacedVertices {
    /// Where each comes from: number of the list, index in it.
    sources: Vec<(u32, u32)>,
    chunks: Vec<ShadingBatch>,
}

impl PlacedVertices {
    /// Copies the vertices of some lists; `place` is a number that those at one place share.
    pub(crate) fn sort<'a>(
        lists: impl Iterator<Item = &'a [ShadingPoint]> + Clone,
        place: impl Fn(Vec3) -> u64 + Sync,
    ) -> Self {
        // Sort numbers of 64 bits: the place, and below it the vertex' number.
        let mut vertices = Vec::new();
        for (list, number) in lists.zip(0..) {
            vertices.extend(list.iter().zip(0..).map(|(vertex, index)| (vertex, (number, index))));
        }
        let key = |(i, &(vertex, _)): (usize, &(&ShadingPoint, _))| fold(place(vertex.position)) << 32 | i as u64;
        let mut order: Vec<u64> = vertices.par_iter().enumerate().map(key).collect();
        order.par_sort_unstable();
        order.par_iter_mut().for_each(|key| *key &= u64::from(u32::MAX));

        // Copy them in that order.
        let copy = |chunk: &[u64]| {
            let mut batch = ShadingBatch::default();
            batch.vertices.extend(chunk.iter().map(|&i| vertices[i as usize].0));
            batch
        };
        Self {
            sources: order.par_iter().map(|&i| vertices[i as usize].1).collect(),
            chunks: order.par_chunks(CHUNK).map(copy).collect(),
        }
    }

    /// The vertices, some at a time.
    pub(crate) fn chunks(&self) -> impl IndexedParallelIterator<Item = &[ShadingPoint]> {
        self.chunks.par_iter().map(|chunk| chunk.vertices.as_slice())
    }

    /// Where they come from, in the order of [`Self::chunks`]: number of the list, index in it.
    pub(crate) fn sources(&self) -> impl Iterator<Item = (usize, usize)> {
        self.sources.iter().map(|&(list, index)| (list as usize, index as usize))
    }

    /// Copies their light to where they come from.
    fn put_back(&self, lists: &mut [&mut ShadingBatch]) {
        for list in lists.iter_mut() {
            list.direct.clear();
            list.direct.resize(list.vertices.len(), Vec3::ZERO);
        }
        let irradiance = self.chunks.iter().flat_map(|chunk| &chunk.direct);
        for ((list, index), &irradiance) in self.sources().zip(irradiance) {
            lists[list].direct[index] = irradiance;
        }
    }
}

/// Returns 32 bits of a place: of those of a brick, the lower nine stay.
fn fold(place: u64) -> u64 {
    // 2⁶⁴ / golden ratio, odd.
    (place >> 9).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 41 << 9 | place & 511
}

impl DirectLighting<'_, '_> {
    /// Computes the direct light at every vertex of the batches; the mesh is filled as far as they need it. Rays of the
    /// fill are added to the frame's; those of the rest stay with the batches.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(crate) fn shade(
        &mut self,
        visibility: CornerVisibility,
        batches: &mut [&mut ShadingBatch],
    ) -> Result<ShadingSeconds, Error> {
        if visibility != CornerVisibility::Stochastic || self.plan.shading(visibility) == Shading::Exact {
            return self.shade_together(visibility, batches);
        }
        // Of gather hits only the sum counts, and they come from all over.
        let lists = batches.iter().map(|batch| batch.vertices.as_slice());
        let mut placed = PlacedVertices::sort(lists, |p| self.field.place(p));
        self.shade_placed(visibility, &mut placed, batches)
    }

    /// [`DirectLighting::shade`] for the sorted vertices of some lists, and for these lists.
    ///
    /// # Errors
    /// As [`DirectLighting::shade`].
    pub(crate) fn shade_placed(
        &mut self,
        visibility: CornerVisibility,
        placed: &mut PlacedVertices,
        lists: &mut [&mut ShadingBatch],
    ) -> Result<ShadingSeconds, Error> {
        let seconds = self.shade_together(visibility, &mut placed.chunks.iter_mut().collect::<Vec<_>>())?;
        placed.put_back(lists);
        placed.chunks.iter_mut().for_each(|chunk| chunk.take_counts(self.stats));
        Ok(seconds)
    }
}
