//! Filling the indirect field: gather rays from every marked point, and from every point that their hits read, until
//! none is missing; then bounce after bounce over all of them.

use std::time::Instant;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::field::{CubeFaces, IndirectField};
use super::gather::{GatherRays, seed_of_point, sphere_directions};
use super::guided::GuidedRays;
use super::probing::Marked;
use super::transfers::{PendingLight, Transfer};
use crate::direct::{DirectLighting, PlacedVertices};
use crate::mesh::{AmbientCube, CornerVisibility, Costs, Marks, Points};
use crate::{Error, RenderOptions, Scene};

/// Points whose gather rays are alive at a time: work for many threads.
pub(crate) const POINTS_AT_ONCE: usize = 512;

/// Gather rays that are alive at a time, at most: a bounded memory, some 200 B a ray.
const RAYS_AT_ONCE: usize = POINTS_AT_ONCE * 256;

impl IndirectField {
    /// Probes the marked points, evaluates those that need values and all that they depend on, and clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(crate) fn fill(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        marked: Marked,
    ) -> Result<(), Error> {
        let (started, direct_before) = (Instant::now(), direct.stats.seconds.fill_direct);
        let (first, hit_irradiance) = (self.points.len(), self.gather_hit_irradiance);
        match self.gather_marked(direct, marks, marked, first) {
            Ok(pending) => {
                self.add_bounces(direct.scene, pending);
                self.memory.hold(self.stats().bytes);
            }
            Err(error) => {
                // Points without values must not stay.
                self.points.truncate(first);
                self.gather_hit_irradiance = hit_irradiance;
                return Err(error);
            }
        }
        let seconds = &mut direct.stats.seconds;
        seconds.fill_indirect += started.elapsed().as_secs_f64() - (seconds.fill_direct - direct_before);
        Ok(())
    }

    /// Gathers for the marked points and all that they depend on; they get indices from `first` on.
    fn gather_marked(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        marked: Marked,
        first: usize,
    ) -> Result<PendingLight, Error> {
        let scene = direct.scene;
        let directions = sphere_directions(self.gather_rays);
        let mut gathers: Vec<GatherRays> = Vec::new();
        let mut pending = PendingLight::default();

        // Hits of new points read further points, which are gathered for in their turn.
        let together = (RAYS_AT_ONCE / self.gather_rays as usize).clamp(1, POINTS_AT_ONCE);
        direct.stats.rays.secondary += self.probe(scene, marks, marked, first)?;
        let mut next = first;
        while next < self.points.len() {
            let end = (next + together).min(self.points.len());
            gathers.resize_with(gathers.len().max(end - next), GatherRays::default);
            let batch = &mut gathers[..end - next];
            self.shoot_rays(scene, direct.options, next, &directions, batch);
            let mut hits = self.place_hits(batch, |p| direct.field.place(p));
            self.sum_hits(direct, batch, &mut hits, &mut pending)?;
            direct.stats.rays.secondary += self.find_transfers(scene, marks, (batch, &hits), first, &mut pending)?;
            next = end;
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(pending)
    }

    /// Memory of a point, bytes, with its transfers while it is being filled.
    pub(crate) fn bytes_per_point(&self) -> u64 {
        self.costs().kept + self.transfer_bytes() + Points::BYTES_PER_POINT
    }

    /// Memory of a point's values.
    pub(crate) fn costs(&self) -> Costs {
        Costs::kept((self.bounce_values.len() * self.faces.count() * size_of::<Vec4>()) as u64)
    }

    /// Whether rays bring reflected light of the surfaces where they end.
    pub(crate) fn reflects_light(&self) -> bool {
        self.bounce_values.len() > 1
    }

    /// Shoots the gather rays of the points from `first` on, one [`GatherRays`] each.
    pub(crate) fn shoot_rays(
        &self,
        scene: &Scene,
        options: &RenderOptions,
        first: usize,
        directions: &[Vec3],
        batch: &mut [GatherRays],
    ) {
        batch.par_iter_mut().enumerate().for_each(|(i, gather)| {
            let seed = seed_of_point(self.seed, self.points.address(first + i));
            let x = self.points.position(first + i);
            gather.sphere(scene, options, (x, self.behind_faces(first + i)), seed, directions);
        });
    }

    /// How far the surfaces are that read each face of a point's cube, metres: they are behind the face. 0 where there
    /// are none.
    fn behind_faces(&self, index: usize) -> [f32; 6] {
        // The paper's mesh knows no geometry.
        if self.faces == CubeFaces::One {
            return [0.0; 6];
        }
        let spacing = self.points.level(self.points.address(index).level).lattice.spacing();
        let parts = self.points.clearance(index as u32).parts();
        std::array::from_fn(|face| parts[face ^ 1].map_or(0.0, |part| part * spacing))
    }

    /// Sorts the hits whose light rays bring; `place` is a number that those at one place share.
    pub(crate) fn place_hits(&self, batch: &[GatherRays], place: impl Fn(Vec3) -> u64 + Sync) -> PlacedVertices {
        if !self.reflects_light() {
            return PlacedVertices::default();
        }
        PlacedVertices::sort(batch.iter().map(|gather| gather.hits.vertices.as_slice()), place)
    }

    /// Sums the emission that gather rays meet, and the direct light that is reflected where they end.
    pub(crate) fn sum_hits(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        batch: &mut [GatherRays],
        hits: &mut PlacedVertices,
        pending: &mut PendingLight,
    ) -> Result<(), Error> {
        // Light the hits from the direct mesh.
        if self.reflects_light() {
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.hits).collect();
            let seconds = direct.shade_placed(CornerVisibility::Stochastic, hits, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
        }
        let guided = self.guide(direct, batch)?;
        // Sum what arrives at each point.
        let arriving = |(i, gather): (usize, &GatherRays)| {
            let guided = guided.get(i);
            let (mut emission, mut first, mut hit_irradiance) = ([Vec4::ZERO; 6], [Vec4::ZERO; 6], 0.0);
            for &(ray, radiance) in &gather.emitted {
                let weight = guided.map_or(1.0, |guided| guided.weight(ray));
                self.splat(&mut emission, gather.lobes[ray as usize], radiance * weight);
            }
            if self.reflects_light() {
                for (hit, &irradiance) in gather.hits.vertices.iter().zip(&gather.hits.direct) {
                    let weight = guided.map_or(1.0, |guided| guided.weight(hit.id));
                    self.splat(&mut first, gather.lobes[hit.id as usize], hit.weight * irradiance * weight);
                    hit_irradiance += f64::from(irradiance.element_sum() / 3.0);
                }
            }
            if let Some(GuidedRays { rays, .. }) = guided {
                for &(ray, radiance) in &rays.emitted {
                    self.splat(&mut emission, rays.lobes[ray as usize], radiance);
                }
                for (hit, &irradiance) in rays.hits.vertices.iter().zip(&rays.hits.direct) {
                    self.splat(&mut first, rays.lobes[hit.id as usize], hit.weight * irradiance);
                }
            }
            (emission, first, hit_irradiance)
        };
        let sums: Vec<_> = batch.par_iter().enumerate().map(arriving).collect();
        let faces = self.faces.count();
        for (gather, (emission, first, hit_irradiance)) in batch.iter_mut().zip(sums) {
            pending.emission.extend_from_slice(&emission[..faces]);
            pending.first.extend(first[..faces].iter().zip(&emission).map(|(f, e)| f + e));
            if self.reflects_light() {
                self.gather_hit_irradiance.0 += hit_irradiance;
                self.gather_hit_irradiance.1 += gather.hits.vertices.len() as u64;
            }
            gather.take_counts(direct);
        }
        Ok(())
    }

    /// Shoots the rays to bright spots of some points, whose even rays have their light, and lights them.
    fn guide(&self, direct: &mut DirectLighting<'_, '_>, batch: &[GatherRays]) -> Result<Vec<GuidedRays>, Error> {
        if self.spots.is_empty() {
            return Ok(Vec::new());
        }
        let (scene, options) = (direct.scene, direct.options);
        let shoot = |even: &GatherRays| GuidedRays::shoot(scene, options, &self.spots, even);
        let mut guided: Vec<GuidedRays> = batch.par_iter().map(shoot).collect();
        if !self.reflects_light() {
            guided.iter_mut().for_each(|guided| guided.rays.hits.vertices.clear());
        }
        let mut lists: Vec<_> = guided.iter_mut().map(|guided| &mut guided.rays.hits).collect();
        let seconds = direct.shade(CornerVisibility::Stochastic, &mut lists)?;
        direct.stats.seconds.fill_direct += seconds.fill;
        guided.iter_mut().for_each(|guided| guided.rays.take_counts(direct));
        Ok(guided)
    }

    /// Adds radiance that arrives along a ray to the cube faces that it reaches.
    #[inline(always)]
    fn splat(&self, values: &mut [Vec4; 6], lobe: Vec3, radiance: Vec3) {
        let radiance = radiance.extend(0.0);
        match self.faces {
            CubeFaces::Six => {
                for axis in 0..3 {
                    values[2 * axis + usize::from(lobe[axis] < 0.0)] += radiance * lobe[axis].abs();
                }
            }
            CubeFaces::One => values[0] += radiance * (4.0 * std::f32::consts::PI / self.gather_rays as f32),
        }
    }

    /// Computes every bounce of the points that have been gathered for, which follow those that have their values.
    fn add_bounces(&mut self, scene: &Scene, pending: PendingLight) {
        for k in 0..self.bounce_values.len() {
            let values = self.bounce(scene, k, &pending);
            self.bounce_values[k].extend(values);
        }
        debug_assert!(self.bounce_values.iter().all(|values| values.len() == self.points.len() * self.faces.count()));
    }

    /// Computes T_k of points that have been gathered for, from T_{k−1} of all points.
    pub(crate) fn bounce(&self, scene: &Scene, k: usize, pending: &PendingLight) -> Vec<Vec4> {
        if k == 0 {
            return pending.emission.clone();
        }
        if k == 1 && !scene.rays_find_emission() {
            return pending.first.clone();
        }
        let (faces, below) = (self.faces.count(), &self.bounce_values[k - 1]);
        let values: Vec<[Vec4; 6]> = pending
            .transfers
            .par_iter()
            .zip(pending.first.par_chunks_exact(faces))
            .map(|(transfers, first)| {
                let mut values = [Vec4::ZERO; 6];
                values[..faces].copy_from_slice(first);
                let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                let (without, with) = transfers.split_at(transfers.partition_point(|t| t.from == Transfer::NO_POINT));

                // Light that comes from surfaces that read a point.
                for t in with {
                    let irradiance = self.irradiance(below, t.from, &AmbientCube::facing(t.n)).truncate();
                    self.splat(&mut values, t.lobe, t.weight * irradiance);
                    (sum, count) = (sum + irradiance, count + 1.0);
                }

                // The others get the mean.
                for t in without {
                    self.splat(&mut values, t.lobe, t.weight * sum / f32::max(count, 1.0));
                }
                values
            })
            .collect();
        values.iter().flat_map(|values| &values[..faces]).copied().collect()
    }
}
