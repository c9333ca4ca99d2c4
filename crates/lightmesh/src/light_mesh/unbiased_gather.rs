//! Indirect light without bias: gather rays, with the indirect mesh as control variate of what arrives where they end.
//!
//! At a surface, the irradiance of k reflections or fewer is E_k = π ⟨Le + a/π (D + E_{k−1})⟩, the mean over rays in proportion to the
//! cosine; D is the direct irradiance where they end, itself an unbiased estimate. The mesh knows E_{k−1} there nearly: M. With
//! probability q a ray goes on, and finds an estimate U of the same kind with one ray of its own. Then
//!
//! > M + (U − M) / q if it goes on, M if not
//!
//! has the expectation E_{k−1}, whatever M is. Where no point can be read all rays go on. It is final gathering with a correction
//! for the mesh: with q = 0 it would be the mesh's own answer, with M = 0 and q = 1 path tracing.

use glam::Vec3;
use rayon::prelude::*;

use super::gather::{Gather, Heights, seed_of_surface, unit};
use super::indirect::{IndirectField, IndirectReading};
use super::marks::Marks;
use super::reader::Sight;
use crate::Error;
use crate::integrator::{DirectLighting, Vertex, hash};

/// q. Empirical: docs/accuracy.md has error and time of others.
const GO_ON: f32 = 0.25;

/// Surface points whose rays are alive at a time.
const AT_ONCE: usize = 4096;

/// What rays are shot from each surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paths {
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
        vertices: &[Vertex],
        paths: Paths,
    ) -> Result<Vec<Vec3>, Error> {
        let mut irradiance = Vec::with_capacity(vertices.len());
        if paths.bounces == 0 && !direct.scene.has_gathered_emitters() {
            irradiance.resize(vertices.len(), Vec3::ZERO);
            return Ok(irradiance);
        }
        for chunk in vertices.chunks(AT_ONCE) {
            let mut batch: Vec<Gather> = chunk.iter().map(|_| Gather::default()).collect();
            let (scene, options) = (direct.scene, direct.options);
            batch.par_iter_mut().zip(chunk).for_each(|(gather, vertex)| {
                gather.hemisphere(scene, options, vertex, (paths.rays, paths.seed, Heights::Random));
                if paths.bounces == 0 {
                    gather.lit.vertices.clear();
                }
            });
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.lit).collect();
            let seconds = direct.light(Sight::One, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
            let arriving = self.correct(direct, marks, &batch, paths)?;
            let mut arriving = arriving.as_slice();
            for mut gather in batch {
                let lobe = |ray: u32| gather.lobes[ray as usize].x;
                let mut sum: Vec3 = gather.emitted.iter().map(|&(ray, radiance)| radiance * lobe(ray)).sum();
                let (own, others) = arriving.split_at(gather.lit.vertices.len());
                for ((vertex, &direct), &indirect) in gather.lit.vertices.iter().zip(&gather.lit.direct).zip(own) {
                    sum += vertex.weight * lobe(vertex.pixel) * (direct + indirect);
                }
                irradiance.push(sum);
                arriving = others;
                gather.lit.take_counts(direct.stats);
                direct.stats.rays.gather += gather.rays;
                direct.reporter.add(0, gather.rays);
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
        batch: &[Gather],
        paths: Paths,
    ) -> Result<Vec<Vec3>, Error> {
        let Some(bounces) = paths.bounces.checked_sub(1) else { return Ok(Vec::new()) };
        let mut readings = self.read_hits(direct, marks, batch, bounces)?.into_iter();
        let (mut arriving, mut going_on, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for vertex in batch.iter().flat_map(|gather| &gather.lit.vertices) {
            let reading = readings.next().flatten();
            let q = if reading.is_some() { GO_ON } else { 1.0 };
            // Not the numbers that the rays' directions are made of.
            if unit(hash(seed_of_surface(!paths.seed, vertex.position))) < q {
                going_on.push(*vertex);
                places.push((arriving.len(), q));
            }
            arriving.push(reading.unwrap_or_default());
        }
        let further = self.estimate_at(direct, marks, &going_on, Paths { bounces, rays: 1, ..paths })?;
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
        batch: &[Gather],
        bounces: u32,
    ) -> Result<Vec<Option<Vec3>>, Error> {
        loop {
            let field = &*self;
            let read = |gather: &Gather| -> (Option<Vec<Option<Vec3>>>, u64) {
                let mut reader = field.reader(direct.scene, bounces, Sight::One);
                let mut complete = true;
                let readings = gather.lit.vertices.iter().map(|vertex| match reader.read(vertex, marks) {
                    IndirectReading::Irradiance(irradiance) => Some(irradiance),
                    IndirectReading::Nothing => None,
                    IndirectReading::Empty => {
                        complete = false;
                        None
                    }
                });
                let readings = readings.collect();
                (complete.then_some(readings), reader.sight_rays())
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
