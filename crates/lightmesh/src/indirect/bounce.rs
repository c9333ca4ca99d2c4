//! Filling the indirect field: gather rays from every point that is asked for, and from every point that their hits ask for,
//! until none is missing; then bounce after bounce over all of them.

use std::time::Instant;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::field::{CubeFaces, IndirectField};
use super::gather::{GatherRays, seed_of_point, sphere_directions};
use crate::direct::DirectLighting;
use crate::mesh::{
    Address, AmbientCube, CornerVisibility, Costs, Marks, PROBE_RAYS, Points, ReadResult, choose, probe,
};
use crate::sampling::seed_of_position;
use crate::{Error, RenderOptions, Scene};

/// Points whose gather rays are alive at a time: work for many threads, in a bounded memory (some 200 B a ray).
pub(crate) const POINTS_AT_ONCE: usize = 256;

/// How light reaches a point along one gather ray: from the surface that the ray hit, which reads one point of the mesh.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    /// The point that the surface reads: one of its corners, chosen in proportion to their weights. The mean over the rays
    /// is the mean over the corners, at an eighth of the reads. [`Transfer::NOWHERE`] where there is none to read, as in a
    /// narrow gap: such surfaces get the mean of what the others do, for they must not swallow light.
    from: u32,
    /// The surface's normal.
    n: Vec3,
    /// Radiance along the ray per unit of irradiance at the surface.
    weight: Vec3,
    /// Irradiance on the sides per unit of radiance (see [`GatherRays::sphere`]).
    lobe: Vec3,
}

impl Transfer {
    const NOWHERE: u32 = u32::MAX;
}

/// The transfers of one point, as far as they are known.
#[derive(Debug, Default)]
struct TransferList {
    transfers: Vec<Transfer>,
    complete: bool,
    sight_rays: u64,
}

/// What the points that are being filled gather.
#[derive(Debug, Default)]
pub(crate) struct GatheredLight {
    /// T_0, and T_1 without the reflection of T_0.
    emission: Vec<Vec4>,
    first: Vec<Vec4>,
    /// By point.
    transfers: Vec<Vec<Transfer>>,
}

impl GatheredLight {
    /// Whether any level needs the one below of points that hits read.
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
        match self.gather_all(direct, marks, first) {
            Ok(gathered) => self.bounce(direct.scene, gathered),
            Err(error) => {
                // Points whose levels nobody knows must not stay.
                self.points.forget(first);
                self.gather_hit_irradiance = hit_irradiance;
                return Err(error);
            }
        }
        let seconds = &mut direct.stats.seconds;
        seconds.fill_indirect += started.elapsed().as_secs_f64() - (seconds.fill_direct - direct_before);
        Ok(())
    }

    /// What the marked points and all that they depend on gather; they are those from `first` on.
    fn gather_all(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        first: usize,
    ) -> Result<GatheredLight, Error> {
        let scene = direct.scene;
        let directions = sphere_directions(self.gather_rays);
        let mut gathers: Vec<GatherRays> = Vec::new();
        let mut gathered = GatheredLight::default();

        // Hits of new points ask for further points, until they are all there.
        direct.stats.rays.secondary += self.probe(scene, marks, first)?;
        let mut next = first;
        while next < self.points.len() {
            let end = (next + POINTS_AT_ONCE).min(self.points.len());
            gathers.resize_with(gathers.len().max(end - next), GatherRays::default);
            let batch = &mut gathers[..end - next];
            self.shoot((scene, direct.options), next, &directions, batch);
            self.light(direct, batch, &mut gathered)?;
            direct.stats.rays.secondary += self.link(scene, marks, batch, first, &mut gathered)?;
            next = end;
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(gathered)
    }

    /// Finds out which of the marked points are inside solids, and gives the others their index; those from `first` on are being filled.
    /// How many rays it took.
    pub(crate) fn probe(&mut self, scene: &Scene, marks: &mut Marks, first: usize) -> Result<u64, Error> {
        let costs = Costs { passing: self.transfer_bytes(), pending: self.points.len() - first, ..self.costs() };
        let wanted = self.points.take(marks, costs, self.max_memory)?;
        let points = &self.points;
        let (probed, rays): (Vec<_>, _) = match self.faces {
            CubeFaces::Six => {
                let look = |&at: &Address| {
                    let spacing = points.level(at.level).lattice.spacing();
                    (at, probe(scene, points.position_of(at), spacing))
                };
                (wanted.par_iter().map(look).collect(), PROBE_RAYS * wanted.len() as u64)
            }
            // The paper's mesh knows no geometry: every point counts.
            CubeFaces::One => (wanted.iter().map(|&c| (c, Some(crate::mesh::Clearance::ALL_FREE))).collect(), 0),
        };
        probed.into_iter().for_each(|point| self.points.insert(point));
        Ok(rays)
    }

    /// Memory of a point, with what it takes while it is being filled.
    pub(crate) fn bytes_per_point(&self) -> u64 {
        self.costs().kept + self.transfer_bytes() + Points::BYTES_PER_POINT
    }

    /// Memory of a point's transfers while it is being filled.
    fn transfer_bytes(&self) -> u64 {
        if self.links() { u64::from(self.gather_rays) * size_of::<Transfer>() as u64 } else { 0 }
    }

    /// What a point's levels take.
    pub(crate) fn costs(&self) -> Costs {
        Costs::kept((self.bounce_values.len() * self.faces.count() * size_of::<Vec4>()) as u64)
    }

    /// Whether light is reflected: rays then bring that of the surfaces where they end.
    pub(crate) fn links(&self) -> bool {
        self.bounce_values.len() > 1
    }

    /// Shoots the gather rays of the points from `first` on, one [`GatherRays`] each.
    pub(crate) fn shoot(
        &self,
        (scene, options): (&Scene, &RenderOptions),
        first: usize,
        directions: &[Vec3],
        batch: &mut [GatherRays],
    ) {
        batch.par_iter_mut().enumerate().for_each(|(i, gather)| {
            let seed = seed_of_point(self.seed, self.points.address(first + i));
            gather.sphere(scene, options, self.points.position(first + i), seed, directions);
        });
    }

    /// Sums the light that gather rays meet.
    pub(crate) fn light(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        batch: &mut [GatherRays],
        gathered: &mut GatheredLight,
    ) -> Result<(), Error> {
        // Light at the hits: the direct mesh, one wave deeper.
        if self.links() {
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.lit).collect();
            let seconds = direct.light(CornerVisibility::Stochastic, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
        }
        for gather in batch {
            let (mut emission, mut first) = ([Vec4::ZERO; 6], [Vec4::ZERO; 6]);
            for &(ray, radiance) in &gather.emitted {
                self.splat(&mut emission, gather.lobes[ray as usize], radiance);
            }
            if self.links() {
                for (vertex, &irradiance) in gather.lit.vertices.iter().zip(&gather.lit.direct) {
                    self.splat(&mut first, gather.lobes[vertex.pixel as usize], vertex.weight * irradiance);
                    self.gather_hit_irradiance.0 += f64::from(irradiance.element_sum() / 3.0);
                }
                self.gather_hit_irradiance.1 += gather.lit.vertices.len() as u64;
            }
            let sides = self.faces.count();
            gathered.emission.extend_from_slice(&emission[..sides]);
            gathered.first.extend(first[..sides].iter().zip(&emission).map(|(f, e)| f + e));
            gather.lit.take_counts(direct.stats);
            let rays = std::mem::take(&mut gather.rays);
            direct.stats.rays.gather += rays;
            direct.reporter.add(0, rays);
        }
        Ok(())
    }

    /// Adds radiance that arrives along a ray to the sides that it reaches.
    #[inline(always)]
    fn splat(&self, sides: &mut [Vec4; 6], lobe: Vec3, radiance: Vec3) {
        let radiance = radiance.extend(0.0);
        match self.faces {
            CubeFaces::Six => {
                for axis in 0..3 {
                    sides[2 * axis + usize::from(lobe[axis] < 0.0)] += radiance * lobe[axis].abs();
                }
            }
            CubeFaces::One => sides[0] += radiance * (4.0 * std::f32::consts::PI / self.gather_rays as f32),
        }
    }

    /// Finds the points that the hits read; those that are missing join the mesh. How many rays it took.
    pub(crate) fn link(
        &mut self,
        scene: &Scene,
        marks: &mut Marks,
        batch: &mut [GatherRays],
        first: usize,
        gathered: &mut GatheredLight,
    ) -> Result<u64, Error> {
        // Reflected once, direct light needs no points; only emission that is gathered does.
        if !self.links() || (self.bounce_values.len() == 2 && !scene.has_gathered_emitters()) {
            gathered.transfers.resize_with(gathered.transfers.len() + batch.len(), Vec::new);
            return Ok(0);
        }
        let mut rays = 0;
        let mut links: Vec<TransferList> = batch.iter().map(|_| TransferList::default()).collect();
        loop {
            let field = &*self;
            batch.par_iter().zip(&mut links).filter(|(_, linked)| !linked.complete).for_each(|(gather, linked)| {
                let mut reader = field.points.reader(scene, CornerVisibility::Stochastic);
                let mut corners = Vec::with_capacity(8);
                linked.transfers.clear();
                linked.transfers.reserve(gather.lit.vertices.len());
                linked.complete = true;
                for vertex in &gather.lit.vertices {
                    corners.clear();
                    let from = match reader.read(vertex, marks, |index, weight| corners.push((index, weight))) {
                        ReadResult::Value => choose(corners.iter().copied(), seed_of_position(vertex.position)),
                        ReadResult::Unavailable => Transfer::NOWHERE,
                        ReadResult::Pending => {
                            linked.complete = false;
                            continue;
                        }
                    };
                    let lobe = gather.lobes[vertex.pixel as usize];
                    linked.transfers.push(Transfer { from, n: vertex.n, weight: vertex.weight, lobe });
                }
                // Stable: the sums keep the order of the rays.
                linked.transfers.sort_by_key(|t| t.from != Transfer::NOWHERE);
                linked.sight_rays += reader.visibility_rays();
            });
            if links.iter().all(|linked| linked.complete) {
                rays += links.iter().map(|linked| linked.sight_rays).sum::<u64>();
                gathered.transfers.extend(links.into_iter().map(|linked| linked.transfers));
                return Ok(rays);
            }
            rays += self.probe(scene, marks, first)?;
        }
    }

    /// The levels of the points that have been gathered for, which follow those that have theirs.
    fn bounce(&mut self, scene: &Scene, gathered: GatheredLight) {
        for k in 0..self.bounce_values.len() {
            let level = self.level(scene, k, &gathered);
            self.bounce_values[k].extend(level);
        }
        debug_assert!(self.bounce_values.iter().all(|level| level.len() == self.points.len() * self.faces.count()));
    }

    /// T_k of points that have been gathered for, from T_{k−1} of all points.
    pub(crate) fn level(&self, scene: &Scene, k: usize, gathered: &GatheredLight) -> Vec<Vec4> {
        if k == 0 {
            return gathered.emission.clone();
        }
        if k == 1 && !scene.has_gathered_emitters() {
            return gathered.first.clone();
        }
        let (sides, below) = (self.faces.count(), &self.bounce_values[k - 1]);
        let level: Vec<[Vec4; 6]> = gathered
            .transfers
            .par_iter()
            .zip(gathered.first.par_chunks_exact(sides))
            .map(|(transfers, once)| {
                let mut values = [Vec4::ZERO; 6];
                values[..sides].copy_from_slice(once);
                let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                let (nowhere, read) = transfers.split_at(transfers.partition_point(|t| t.from == Transfer::NOWHERE));
                for t in read {
                    let irradiance = self.irradiance(below, t.from, &AmbientCube::facing(t.n)).truncate();
                    self.splat(&mut values, t.lobe, t.weight * irradiance);
                    (sum, count) = (sum + irradiance, count + 1.0);
                }
                for t in nowhere {
                    self.splat(&mut values, t.lobe, t.weight * sum / f32::max(count, 1.0));
                }
                values
            })
            .collect();
        level.iter().flat_map(|values| &values[..sides]).copied().collect()
    }
}
