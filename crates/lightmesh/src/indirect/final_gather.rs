//! Indirect light at surfaces that no mesh point can serve: gather rays from the surface itself.

use glam::Vec3;
use rayon::prelude::*;

use super::field::{IndirectField, IndirectReading};
use super::gather::{GatherRays, HemisphereRays, Strata};
use crate::Error;
use crate::direct::DirectLighting;
use crate::interaction::ShadingPoint;
use crate::mesh::{CornerVisibility, Marks};

/// Rays per surface point: each of them is as good as a path, but pixels have several samples.
const RAYS: u32 = 64;

/// Surface points whose rays are alive at a time.
const AT_ONCE: usize = 1024;

impl IndirectField {
    /// Computes the indirect irradiance at each of the points after so many `bounces`: formula (4) over their own
    /// hemispheres, with the mesh read where the rays end. Other seeds give other rays.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(crate) fn final_gather(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        points: &[ShadingPoint],
        bounces: u32,
        seed: u64,
    ) -> Result<Vec<Vec3>, Error> {
        let mut irradiance = Vec::with_capacity(points.len());
        let mut gathers: Vec<GatherRays> = Vec::new();
        let rays = HemisphereRays { count: RAYS, seed, strata: Strata::Centered };
        for chunk in points.chunks(AT_ONCE) {
            // Shoot the rays of each point.
            gathers.resize_with(gathers.len().max(chunk.len()), GatherRays::default);
            let batch = &mut gathers[..chunk.len()];
            let (scene, options) = (direct.scene, direct.options);
            batch.par_iter_mut().zip(chunk).for_each(|(gather, point)| {
                gather.hemispheres(scene, options, std::slice::from_ref(point), rays);
                if bounces == 0 {
                    gather.hits.vertices.clear();
                }
            });

            // Light the surfaces where they end, and sum what arrives.
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.hits).collect();
            let seconds = direct.shade(CornerVisibility::Stochastic, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
            irradiance.extend(self.sum_arriving(direct, marks, batch, bounces)?);
            for gather in batch {
                gather.take_counts(direct);
            }
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(irradiance)
    }

    /// Sums the light that arrives along each point's rays. Hits that cannot read the mesh in their turn lie in the
    /// same gap as the point, and are taken to receive what it does: I = S + ρI, summed bounce by bounce.
    fn sum_arriving(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &[GatherRays],
        bounces: u32,
    ) -> Result<Vec<Vec3>, Error> {
        // Read the mesh and fill it, until no hit waits.
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
                    for (hit, &direct) in gather.hits.vertices.iter().zip(&gather.hits.direct) {
                        let weight = hit.weight * lobe(hit.id);
                        sum += weight * direct;
                        match reader.read(hit, marks) {
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
