//! Filling the indirect field: gather rays from every marked point, and from every point that their hits read, until
//! none is missing; then bounce after bounce over all of them.

use std::time::Instant;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::field::{CubeFaces, IndirectField};
use super::gather::{GatherRays, seed_of_point, sphere_directions};
use super::guided::GuidedRays;
use crate::direct::DirectLighting;
use crate::mesh::{
    Address, AmbientCube, CornerVisibility, Costs, Marks, PROBE_RAYS, Points, ReadResult, choose, probe,
};
use crate::sampling::seed_of_position;
use crate::{Error, RenderOptions, Scene};

/// Points whose gather rays are alive at a time: work for many threads, in a bounded memory (some 200 B a ray).
pub(crate) const POINTS_AT_ONCE: usize = 256;

/// How light reaches a point along one gather ray: from the surface that the ray hit, which reads one point of the
/// mesh.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    /// The point that the surface reads: one of its corners, chosen in proportion to their weights. The mean over the
    /// rays is the mean over the corners, at an eighth of the reads. [`Transfer::NO_POINT`] where none can serve, as
    /// in a narrow gap: such surfaces get the mean of the others' irradiance, for they must not swallow light.
    from: u32,
    /// The surface's normal.
    n: Vec3,
    /// Radiance along the ray per unit of irradiance at the surface.
    weight: Vec3,
    /// Irradiance on the cube faces per unit of radiance (see [`GatherRays::sphere`]).
    lobe: Vec3,
}

impl Transfer {
    const NO_POINT: u32 = u32::MAX;
}

/// The transfers of one point.
#[derive(Debug, Default)]
struct TransferList {
    transfers: Vec<Transfer>,
    /// Whether every hit could read its point.
    complete: bool,
    visibility_rays: u64,
}

/// The light of the points that are being filled, before it is summed bounce by bounce.
#[derive(Debug, Default)]
pub(crate) struct PendingLight {
    /// T_0, and T_1 without the reflection of T_0.
    emission: Vec<Vec4>,
    first: Vec<Vec4>,
    /// By point.
    transfers: Vec<Vec<Transfer>>,
}

impl PendingLight {
    /// Whether any bounce needs the one below of points that hits read.
    pub(crate) fn reads_points(&self) -> bool {
        self.transfers.iter().any(|transfers| !transfers.is_empty())
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let transfers: usize = self.transfers.iter().map(|transfers| size_of_val(transfers.as_slice())).sum();
        (transfers + size_of_val(self.emission.as_slice()) + size_of_val(self.first.as_slice())) as u64
    }
}

impl IndirectField {
    /// Evaluates the marked points and all that they depend on, and clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`].
    pub(crate) fn fill(&mut self, direct: &mut DirectLighting<'_, '_>, marks: &mut Marks) -> Result<(), Error> {
        let (started, direct_before) = (Instant::now(), direct.stats.seconds.fill_direct);
        let (first, hit_irradiance) = (self.points.len(), self.gather_hit_irradiance);
        match self.gather_marked(direct, marks, first) {
            Ok(pending) => self.add_bounces(direct.scene, pending),
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
        first: usize,
    ) -> Result<PendingLight, Error> {
        let scene = direct.scene;
        let directions = sphere_directions(self.gather_rays);
        let mut gathers: Vec<GatherRays> = Vec::new();
        let mut pending = PendingLight::default();

        // Hits of new points read further points, which are gathered for in their turn.
        direct.stats.rays.secondary += self.probe(scene, marks, first)?;
        let mut next = first;
        while next < self.points.len() {
            let end = (next + POINTS_AT_ONCE).min(self.points.len());
            gathers.resize_with(gathers.len().max(end - next), GatherRays::default);
            let batch = &mut gathers[..end - next];
            self.shoot_rays(scene, direct.options, next, &directions, batch);
            self.sum_hits(direct, batch, &mut pending)?;
            direct.stats.rays.secondary += self.find_transfers(scene, marks, batch, first, &mut pending)?;
            next = end;
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(pending)
    }

    /// Finds out which of the marked points are inside solids, and gives the others their index; those from `first` on
    /// are being filled. Returns how many rays that took.
    pub(crate) fn probe(&mut self, scene: &Scene, marks: &mut Marks, first: usize) -> Result<u64, Error> {
        let costs = Costs { temporary: self.transfer_bytes(), pending: self.points.len() - first, ..self.costs() };
        let marked = self.points.take_marked(marks, costs, self.max_memory)?;
        let points = &self.points;
        let (probed, rays): (Vec<_>, _) = match self.faces {
            CubeFaces::Six => {
                let probe_point = |&address: &Address| {
                    let spacing = points.level(address.level).lattice.spacing();
                    (address, probe(scene, points.position_of(address), spacing))
                };
                (marked.par_iter().map(probe_point).collect(), PROBE_RAYS * marked.len() as u64)
            }
            // The paper's mesh knows no geometry: every point counts.
            CubeFaces::One => (marked.iter().map(|&c| (c, Some(crate::mesh::Clearance::ALL_FREE))).collect(), 0),
        };
        probed.into_iter().for_each(|(address, clearance)| self.points.insert(address, clearance));
        Ok(rays)
    }

    /// Memory of a point, bytes, with its transfers while it is being filled.
    pub(crate) fn bytes_per_point(&self) -> u64 {
        self.costs().kept + self.transfer_bytes() + Points::BYTES_PER_POINT
    }

    /// Memory of a point's transfers while it is being filled, bytes.
    fn transfer_bytes(&self) -> u64 {
        if self.reflects_light() { u64::from(self.gather_rays) * size_of::<Transfer>() as u64 } else { 0 }
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
            gather.sphere(scene, options, self.points.position(first + i), seed, directions);
        });
    }

    /// Sums the emission that gather rays meet, and the direct light that is reflected where they end.
    pub(crate) fn sum_hits(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        batch: &mut [GatherRays],
        pending: &mut PendingLight,
    ) -> Result<(), Error> {
        // Light the hits from the direct mesh.
        if self.reflects_light() {
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.hits).collect();
            let seconds = direct.shade(CornerVisibility::Stochastic, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
        }
        let guided = self.guide(direct, batch)?;
        // Sum what arrives at each point.
        for (i, gather) in batch.iter_mut().enumerate() {
            let guided = guided.get(i);
            let (mut emission, mut first) = ([Vec4::ZERO; 6], [Vec4::ZERO; 6]);
            for &(ray, radiance) in &gather.emitted {
                let weight = guided.map_or(1.0, |guided| guided.weight(ray));
                self.splat(&mut emission, gather.lobes[ray as usize], radiance * weight);
            }
            if self.reflects_light() {
                for (hit, &irradiance) in gather.hits.vertices.iter().zip(&gather.hits.direct) {
                    let weight = guided.map_or(1.0, |guided| guided.weight(hit.id));
                    self.splat(&mut first, gather.lobes[hit.id as usize], hit.weight * irradiance * weight);
                    self.gather_hit_irradiance.0 += f64::from(irradiance.element_sum() / 3.0);
                }
                self.gather_hit_irradiance.1 += gather.hits.vertices.len() as u64;
            }
            if let Some(GuidedRays { rays, .. }) = guided {
                for &(ray, radiance) in &rays.emitted {
                    self.splat(&mut emission, rays.lobes[ray as usize], radiance);
                }
                for (hit, &irradiance) in rays.hits.vertices.iter().zip(&rays.hits.direct) {
                    self.splat(&mut first, rays.lobes[hit.id as usize], hit.weight * irradiance);
                }
            }
            let faces = self.faces.count();
            pending.emission.extend_from_slice(&emission[..faces]);
            pending.first.extend(first[..faces].iter().zip(&emission).map(|(f, e)| f + e));
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

    /// Finds the points that the hits read; those that are missing join the mesh. Returns how many rays that took.
    pub(crate) fn find_transfers(
        &mut self,
        scene: &Scene,
        marks: &mut Marks,
        batch: &mut [GatherRays],
        first: usize,
        pending: &mut PendingLight,
    ) -> Result<u64, Error> {
        // Direct light that is reflected once needs no points, only emission that gather rays find does.
        if !self.reflects_light() || (self.bounce_values.len() == 2 && !scene.rays_find_emission()) {
            pending.transfers.resize_with(pending.transfers.len() + batch.len(), Vec::new);
            return Ok(0);
        }
        let mut rays = 0;
        let mut lists: Vec<TransferList> = batch.iter().map(|_| TransferList::default()).collect();
        loop {
            // Choose a point for every hit; lists with missing points are made again.
            let field = &*self;
            batch.par_iter().zip(&mut lists).filter(|(_, list)| !list.complete).for_each(|(gather, list)| {
                let mut reader = field.points.reader(scene, CornerVisibility::Stochastic);
                let mut corners = Vec::with_capacity(8);
                list.transfers.clear();
                list.transfers.reserve(gather.hits.vertices.len());
                list.complete = true;
                for hit in &gather.hits.vertices {
                    corners.clear();
                    let from = match reader.read(hit, marks, |index, weight| corners.push((index, weight))) {
                        ReadResult::Value => choose(corners.iter().copied(), seed_of_position(hit.position)),
                        ReadResult::Unavailable => Transfer::NO_POINT,
                        ReadResult::Pending => {
                            list.complete = false;
                            continue;
                        }
                    };
                    let lobe = gather.lobes[hit.id as usize];
                    list.transfers.push(Transfer { from, n: hit.n, weight: hit.weight, lobe });
                }
                // Those without a point first. Stable: the sums keep the order of the rays.
                list.transfers.sort_by_key(|t| t.from != Transfer::NO_POINT);
                list.visibility_rays += reader.visibility_rays();
            });
            if lists.iter().all(|list| list.complete) {
                rays += lists.iter().map(|list| list.visibility_rays).sum::<u64>();
                pending.transfers.extend(lists.into_iter().map(|list| list.transfers));
                return Ok(rays);
            }

            // Add the points that are missing.
            rays += self.probe(scene, marks, first)?;
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
