//! Indirect light at surfaces that no mesh point can be read from: gather rays from the surface itself.

use glam::Vec3;
use rayon::prelude::*;

use super::field::{IndirectField, IndirectReading};
use super::gather::{GatherRays, Strata};
use crate::Error;
use crate::direct::DirectLighting;
use crate::interaction::ShadingPoint;
use crate::mesh::{CornerVisibility, Marks};

/// Rays per surface point: each of them is as good as a path, but pixels have several samples.
const RAYS: u32 = 64;

/// Surface points whose rays are alive at a time.
const AT_ONCE: usize = 1024;

impl IndirectField {
    /// The indirect irradiance at each of the vertices after so many `bounces`: formula (4) over their own hemispheres, with
    /// the mesh read where the rays end.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(crate) fn gather_at(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        vertices: &[ShadingPoint],
        (bounces, seed): (u32, u64),
    ) -> Result<Vec<Vec3>, Error> {
        let mut irradiance = Vec::with_capacity(vertices.len());
        let mut gathers: Vec<GatherRays> = Vec::new();
        for chunk in vertices.chunks(AT_ONCE) {
            gathers.resize_with(gathers.len().max(chunk.len()), GatherRays::default);
            let batch = &mut gathers[..chunk.len()];
            let (scene, options) = (direct.scene, direct.options);
            batch.par_iter_mut().zip(chunk).for_each(|(gather, vertex)| {
                gather.hemispheres(scene, options, std::slice::from_ref(vertex), (RAYS, seed, Strata::Centered));
                if bounces == 0 {
                    gather.lit.vertices.clear();
                }
            });
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.lit).collect();
            let seconds = direct.light(CornerVisibility::Stochastic, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
            irradiance.extend(self.sum(direct, marks, batch, bounces)?);
            for gather in batch {
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

    /// The irradiance of each gather's surface. Hits that cannot read the mesh in their turn lie in the same gap as
    /// the surface, and are taken to receive what it does: I = S + ρI, summed bounce by bounce.
    fn sum(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &[GatherRays],
        bounces: u32,
    ) -> Result<Vec<Vec3>, Error> {
        loop {
            let field = &*self;
            let sums: Vec<(Option<Vec3>, u64)> = batch
                .par_iter()
                .map(|gather| {
                    let mut reader =
                        field.reader(direct.scene, bounces.saturating_sub(1), CornerVisibility::Stochastic);
                    let lobe = |ray: u32| gather.lobes[ray as usize].x;
                    let mut sum: Vec3 = gather.emitted.iter().map(|&(ray, radiance)| radiance * lobe(ray)).sum();
                    let (mut gap, mut complete) = (Vec3::ZERO, true);
                    for (vertex, &direct) in gather.lit.vertices.iter().zip(&gather.lit.direct) {
                        let weight = vertex.weight * lobe(vertex.pixel);
                        sum += weight * direct;
                        match reader.read(vertex, marks) {
                            IndirectReading::Irradiance(irradiance) => sum += weight * irradiance,
                            IndirectReading::Unavailable => gap += weight,
                            IndirectReading::Pending => complete = false,
                        }
                    }
                    let sum = geometric_series(gap, bounces) * sum;
                    (complete.then_some(sum), reader.visibility_rays())
                })
                .collect();
            direct.stats.rays.secondary += sums.iter().map(|s| s.1).sum::<u64>();
            if let Some(sums) = sums.iter().map(|s| s.0).collect() {
                return Ok(sums);
            }
            self.fill(direct, marks)?;
        }
    }
}

/// 1 + q + q² … + qⁿ, n at most 64: q is an albedo at most, and 0.9 to that power a thousandth.
fn geometric_series(q: Vec3, n: u32) -> Vec3 {
    (0..n.min(64)).fold(Vec3::ONE, |sum, _| sum * q + Vec3::ONE)
}
