//! Indirect light without bias: gather rays, with the indirect mesh as control variate of what arrives where they end.
//!
//! At a surface, the irradiance of k reflections or fewer, the sum of formula (4) over its hemisphere, is E_k = π ⟨Le + a/π (D + E_{k−1})⟩, the mean over rays in proportion to the
//! cosine; D is the direct irradiance where they end, itself an unbiased estimate. The mesh knows E_{k−1} there nearly: M. With
//! probability q a ray goes on, and finds an estimate U of the same kind with one ray of its own. Then
//!
//! > M + (U − M) / q if it goes on, M if not
//!
//! has the expectation E_{k−1}, whatever M is; where no point can be read, 0. It is final gathering with a correction
//! for the mesh: with q = 0 it would be the mesh's own answer, with M = 0 path tracing with Russian roulette.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use super::field::{IndirectField, IndirectReading};
use super::gather::{GatherRays, Strata};
use crate::Error;
use crate::direct::DirectLighting;
use crate::interaction::ShadingPoint;
use crate::mesh::{CornerVisibility, Marks};
use crate::sampling::{hash, seed_of_surface, unit_f32};

/// Least and most of q, the albedo where a ray ends: with it the weight of what is found stays as it is, (a / π) π / q = 1, and the noise
/// of a ray that goes on and on does not grow. Empirical: docs/accuracy.md has error and time of others.
const GO_ON: std::ops::RangeInclusive<f32> = 0.05..=0.95;

/// Surface points whose rays are alive at a time, and rays that make a list. Empirical: a list for each surface took twice the time.
const AT_ONCE: usize = 1 << 14;
const RAYS: usize = 256;

/// What rays are shot from each surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GatherPaths {
    /// Reflections.
    pub bounces: u32,
    /// Rays.
    pub rays: u32,
    pub seed: u64,
}

impl IndirectField {
    /// Unbiased estimates of the indirect irradiance at each of the vertices.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(crate) fn estimate_at(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        vertices: &[ShadingPoint],
        paths: GatherPaths,
    ) -> Result<Vec<Vec3>, Error> {
        let mut irradiance = Vec::with_capacity(vertices.len());
        if vertices.is_empty() || (paths.bounces == 0 && !direct.scene.has_gathered_emitters()) {
            irradiance.resize(vertices.len(), Vec3::ZERO);
            return Ok(irradiance);
        }
        let together = (RAYS / paths.rays as usize).max(1);
        let mut gathers: Vec<GatherRays> = Vec::new();
        for chunk in vertices.chunks(AT_ONCE) {
            let lists = chunk.len().div_ceil(together);
            gathers.resize_with(gathers.len().max(lists), GatherRays::default);
            let batch = &mut gathers[..lists];
            let (scene, options) = (direct.scene, direct.options);
            batch.par_iter_mut().zip(chunk.par_chunks(together)).for_each(|(gather, vertices)| {
                gather.hemispheres(scene, options, vertices, (paths.rays, paths.seed, Strata::Jittered));
                if paths.bounces == 0 {
                    gather.lit.vertices.clear();
                }
            });
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.lit).collect();
            let seconds = direct.light(CornerVisibility::Stochastic, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
            let arriving = self.correct(direct, marks, batch, paths)?;
            let mut arriving = arriving.as_slice();
            for (gather, vertices) in batch.iter_mut().zip(chunk.chunks(together)) {
                let first = irradiance.len();
                irradiance.resize(first + vertices.len(), Vec3::ZERO);
                let sums = &mut irradiance[first..];
                let mut add = |ray: u32, radiance: Vec3| {
                    sums[(ray / paths.rays) as usize] += radiance * gather.lobes[ray as usize].x;
                };
                gather.emitted.iter().for_each(|&(ray, radiance)| add(ray, radiance));
                let (own, others) = arriving.split_at(gather.lit.vertices.len());
                for ((vertex, &direct), &indirect) in gather.lit.vertices.iter().zip(&gather.lit.direct).zip(own) {
                    add(vertex.pixel, vertex.weight * (direct + indirect));
                }
                arriving = others;
                gather.lit.take_counts(direct.stats);
                let rays = std::mem::take(&mut gather.rays);
                direct.stats.rays.gather += rays;
                direct.reporter.add(0, rays);
            }
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(irradiance)
    }

    /// The indirect irradiance at each hit of each gather: the mesh's, corrected by the rays that go on.
    fn correct(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &[GatherRays],
        paths: GatherPaths,
    ) -> Result<Vec<Vec3>, Error> {
        let Some(bounces) = paths.bounces.checked_sub(1) else { return Ok(Vec::new()) };
        let mut readings = self.read_hits(direct, marks, batch, bounces)?.into_iter();
        let (mut arriving, mut going_on, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for vertex in batch.iter().flat_map(|gather| &gather.lit.vertices) {
            let reading = readings.next().flatten();
            let q = (PI * vertex.weight.max_element()).clamp(*GO_ON.start(), *GO_ON.end());
            // Not the numbers that the rays' directions are made of.
            if unit_f32(hash(seed_of_surface(!paths.seed, vertex.position))) < q {
                going_on.push(*vertex);
                places.push((arriving.len(), q));
            }
            arriving.push(reading.unwrap_or_default());
        }
        let further = self.estimate_at(direct, marks, &going_on, GatherPaths { bounces, rays: 1, ..paths })?;
        for ((at, q), u) in places.into_iter().zip(further) {
            let m = arriving[at];
            arriving[at] = m + (u - m) / q;
        }
        Ok(arriving)
    }

    /// What the mesh says at the hits of all gathers, one after the other; it is filled as far as they ask for it.
    fn read_hits(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &[GatherRays],
        bounces: u32,
    ) -> Result<Vec<Option<Vec3>>, Error> {
        loop {
            let field = &*self;
            let read = |gather: &GatherRays| -> (Option<Vec<Option<Vec3>>>, u64) {
                let mut reader = field.reader(direct.scene, bounces, CornerVisibility::Stochastic);
                let mut complete = true;
                let readings = gather.lit.vertices.iter().map(|vertex| match reader.read(vertex, marks) {
                    IndirectReading::Irradiance(irradiance) => Some(irradiance),
                    IndirectReading::Unavailable => None,
                    IndirectReading::Pending => {
                        complete = false;
                        None
                    }
                });
                let readings = readings.collect();
                (complete.then_some(readings), reader.visibility_rays())
            };
            let read: Vec<_> = batch.par_iter().map(read).collect();
            direct.stats.rays.secondary += read.iter().map(|(_, rays)| rays).sum::<u64>();
            let readings: Option<Vec<_>> = read.into_iter().map(|(readings, _)| readings).collect();
            if let Some(readings) = readings {
                return Ok(readings.into_iter().flatten().collect());
            }
            self.fill(direct, marks)?;
        }
    }
}
