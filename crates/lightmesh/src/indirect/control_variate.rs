//! Indirect light without bias: gather rays, with the indirect mesh as control variate of what arrives where they end.
//!
//! At a surface, the irradiance of k reflections or fewer, the sum of formula (4) over its hemisphere, is the mean over
//! rays in proportion to the cosine
//!
//! > E_k = π ⟨Le + a/π (D + E_{k−1})⟩.
//!
//! D is the direct irradiance where they end, itself an unbiased estimate. The mesh approximates E_{k−1} there by M.
//! With probability q a ray goes on, and finds an estimate U of the same kind with one ray of its own. Then
//!
//! > M + (U − M) / q if it goes on, M if not
//!
//! has the expectation E_{k−1}, whatever M is; where no point can be read, 0. It is final gathering with a correction
//! for the mesh: with q = 0 it would be the mesh's own irradiance, with M = 0 path tracing with Russian roulette.

use std::f32::consts::PI;

use glam::Vec3;
use rayon::prelude::*;

use super::field::{IndirectField, IndirectReading};
use super::gather::{GatherRays, HemisphereRays};
use super::probing::Marked;
use crate::Error;
use crate::direct::DirectLighting;
use crate::interaction::ShadingPoint;
use crate::mesh::{CornerVisibility, Marks};
use crate::sampling::{hash, seed_of_surface, unit_f32};

/// Least and most of q, the albedo where a ray ends: with it the weight of what is found stays as it is, (a / π) π / q
/// = 1, and the noise of a ray that goes on and on does not grow. Empirical: docs/accuracy.md has error and time of
/// others.
const GO_ON: std::ops::RangeInclusive<f32> = 0.05..=0.95;

/// Rays that are alive at a time, some 300 B each, and rays that make a list. Empirical: a list for each surface took twice
/// the time.
const AT_ONCE: usize = 1 << 15;
const RAYS: usize = 256;

/// Where paths go on from the surfaces at which their rays end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GoOn {
    /// Everywhere, to correct the mesh.
    Everywhere,
    /// Where no mesh point can be read: what is read counts as it is.
    WithoutMesh,
    /// Nowhere.
    Nowhere,
}

/// The indirect light at a surface, as paths have found it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathSum {
    /// Irradiance, lux.
    pub irradiance: Vec3,
    /// The rays that ended at a surface for which a mesh point can be read.
    pub read: u32,
    /// The part of an even irradiance at those surfaces that would come back.
    pub gap: Vec3,
}

/// The paths that estimate the indirect light at a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GatherPaths {
    /// Most reflections of a path.
    pub bounces: u32,
    /// Rays from each surface.
    pub rays: u32,
    /// Other seeds give other rays.
    pub seed: u64,
    pub go_on: GoOn,
}

impl IndirectField {
    /// Estimates the indirect irradiance at each of the points without bias.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(crate) fn estimate_unbiased(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        points: &[ShadingPoint],
        paths: GatherPaths,
    ) -> Result<Vec<Vec3>, Error> {
        let sums = self.follow_paths(direct, marks, points, paths)?;
        Ok(sums.into_iter().map(|sum| sum.irradiance).collect())
    }

    /// Estimates the indirect irradiance at each of the points by paths.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(super) fn follow_paths(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        points: &[ShadingPoint],
        paths: GatherPaths,
    ) -> Result<Vec<PathSum>, Error> {
        let mut all: Vec<PathSum> = Vec::with_capacity(points.len());
        if points.is_empty() || (paths.bounces == 0 && !direct.scene.rays_find_emission()) {
            all.resize(points.len(), PathSum::default());
            return Ok(all);
        }
        let rays = HemisphereRays { count: paths.rays, seed: paths.seed };
        let together = (RAYS / paths.rays as usize).max(1);
        let mut gathers: Vec<GatherRays> = Vec::new();
        for chunk in points.chunks((AT_ONCE / paths.rays as usize).max(1)) {
            // Shoot the rays of several points as one list.
            let lists = chunk.len().div_ceil(together);
            gathers.resize_with(gathers.len().max(lists), GatherRays::default);
            let batch = &mut gathers[..lists];
            let (scene, options) = (direct.scene, direct.options);
            batch.par_iter_mut().zip(chunk.par_chunks(together)).for_each(|(gather, points)| {
                gather.hemispheres(scene, options, points, rays);
                if paths.bounces == 0 {
                    gather.hits.vertices.clear();
                }
            });

            // Estimate direct and indirect light where they end.
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.hits).collect();
            let seconds = direct.shade(CornerVisibility::Stochastic, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
            let indirect = self.correct(direct, marks, batch, paths)?;

            // Sum what arrives at each point.
            let mut indirect = indirect.as_slice();
            for (gather, points) in batch.iter_mut().zip(chunk.chunks(together)) {
                let first = all.len();
                all.resize(first + points.len(), PathSum::default());
                let sums = &mut all[first..];
                let of = |ray: u32| (ray / paths.rays) as usize;
                let lobe = |ray: u32| gather.lobes[ray as usize].x;
                for &(ray, radiance) in &gather.emitted {
                    sums[of(ray)].irradiance += radiance * lobe(ray);
                }
                let (own, others) = indirect.split_at(gather.hits.vertices.len().min(indirect.len()));
                let indirect_of = |i: usize| own.get(i).copied().unwrap_or_default();
                for (i, (hit, &direct)) in gather.hits.vertices.iter().zip(&gather.hits.direct).enumerate() {
                    let (sum, found) = (&mut sums[of(hit.id)], indirect_of(i));
                    sum.irradiance += hit.weight * (direct + found.irradiance) * lobe(hit.id);
                    sum.read += found.read;
                    if found.read == 0 {
                        sum.gap += hit.weight * lobe(hit.id);
                    }
                }
                indirect = others;
                gather.take_counts(direct);
            }
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(all)
    }

    /// Estimates the indirect irradiance at each hit of each gather: what the mesh says, corrected by the rays that go
    /// on.
    fn correct(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &[GatherRays],
        paths: GatherPaths,
    ) -> Result<Vec<PathSum>, Error> {
        let Some(bounces) = paths.bounces.checked_sub(1) else { return Ok(Vec::new()) };
        // Read the mesh everywhere, and let some hits go on, with probability q.
        let mut readings = self.read_hits(direct, marks, batch, bounces)?.into_iter();
        let (mut estimates, mut going_on, mut corrections) = (Vec::new(), Vec::new(), Vec::new());
        for hit in batch.iter().flat_map(|gather| &gather.hits.vertices) {
            let reading = readings.next().flatten();
            let (irradiance, read) = (reading.unwrap_or_default(), u32::from(reading.is_some()));
            estimates.push(PathSum { irradiance, read, gap: Vec3::ZERO });
            match paths.go_on {
                GoOn::Everywhere => {}
                GoOn::WithoutMesh if reading.is_none() => {}
                GoOn::WithoutMesh | GoOn::Nowhere => continue,
            }
            let q = (PI * hit.weight.max_element()).clamp(*GO_ON.start(), *GO_ON.end());
            // Not the numbers that the rays' directions are made of.
            if unit_f32(hash(seed_of_surface(!paths.seed, hit.position))) < q {
                going_on.push(*hit);
                corrections.push((estimates.len() - 1, q));
            }
        }

        // Replace the mesh's M by M + (U − M) / q where a ray has gone on.
        let paths = GatherPaths { bounces, rays: 1, ..paths };
        let found = self.estimate_unbiased(direct, marks, &going_on, paths)?;
        for ((index, q), u) in corrections.into_iter().zip(found) {
            let m = estimates[index].irradiance;
            estimates[index].irradiance = m + (u - m) / q;
        }
        Ok(estimates)
    }

    /// Reads the mesh at the hits of all gathers, one after the other, and fills it as far as they need. Returns
    /// `None` for hits that no mesh point can serve.
    pub(super) fn read_hits(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &[GatherRays],
        bounces: u32,
    ) -> Result<Vec<Option<Vec3>>, Error> {
        // Read everything again after each fill, until no hit waits.
        loop {
            let field = &*self;
            let read = |gather: &GatherRays| -> (Option<Vec<Option<Vec3>>>, u64) {
                let mut reader = field.reader(direct.scene, bounces, CornerVisibility::Stochastic);
                let mut complete = true;
                let readings = gather.hits.vertices.iter().map(|hit| match reader.read(hit, marks) {
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
            self.fill(direct, marks, Marked::ToRead)?;
        }
    }
}
