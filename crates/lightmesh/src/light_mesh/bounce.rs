//! Filling the indirect field: gather rays from every point that is asked for, and from every point that their hits ask for,
//! until none is missing; then bounce after bounce over all of them.

use std::time::Instant;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::direct::Axes;
use super::gather::{Gather, seed_of_point, sphere_directions};
use super::indirect::{IndirectField, Sides};
use super::marks::Marks;
use super::points::{Address, Points};
use super::probe::{PROBE_RAYS, probe};
use super::reader::choose;
use super::seen::{Outcome, Sight};
use crate::integrator::{DirectLighting, seed_of_place};
use crate::{Error, Scene};

/// Points whose gather rays are alive at a time: work for many threads, in a bounded memory (some 200 B a ray).
const POINTS_AT_ONCE: usize = 256;

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
    /// Irradiance on the sides per unit of radiance (see [`Gather::sphere`]).
    lobe: Vec3,
}

impl Transfer {
    const NOWHERE: u32 = u32::MAX;
}

/// The transfers of one point, as far as they are known.
#[derive(Debug, Default)]
struct Linked {
    transfers: Vec<Transfer>,
    complete: bool,
    sight_rays: u64,
}

/// What the points that are being filled gather.
#[derive(Debug, Default)]
struct Gathered {
    /// T_0, and T_1 without the reflection of T_0.
    emission: Vec<Vec4>,
    first: Vec<Vec4>,
    /// By point.
    transfers: Vec<Vec<Transfer>>,
}

impl IndirectField {
    /// Evaluates the marked points and all that they depend on, and clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`]. The points that are there then are those of before.
    pub(crate) fn fill(&mut self, direct: &mut DirectLighting<'_, '_>, marks: &mut Marks) -> Result<(), Error> {
        let (started, direct_before) = (Instant::now(), direct.stats.seconds.fill_direct);
        let (first, hit_irradiance) = (self.points.len(), self.hit_irradiance);
        let gathered = self.gather_all(direct, marks).inspect_err(|_| {
            // Points without levels cannot be read.
            self.points.forget(first);
            self.hit_irradiance = hit_irradiance;
        })?;
        self.bounce(direct.scene, first, gathered);
        let seconds = &mut direct.stats.seconds;
        seconds.fill_indirect += started.elapsed().as_secs_f64() - (seconds.fill_direct - direct_before);
        Ok(())
    }

    /// What the marked points gather, and those that their hits ask for, until they are all there.
    fn gather_all(&mut self, direct: &mut DirectLighting<'_, '_>, marks: &mut Marks) -> Result<Gathered, Error> {
        let directions = sphere_directions(self.gather_rays);
        let mut gathers: Vec<Gather> = Vec::new();
        let mut gathered = Gathered::default();
        let mut next = self.points.len();
        self.probe(direct, marks)?;
        while next < self.points.len() {
            let end = (next + POINTS_AT_ONCE).min(self.points.len());
            gathers.resize_with(gathers.len().max(end - next), Gather::default);
            let batch = &mut gathers[..end - next];
            self.gather(direct, next, &directions, batch, &mut gathered)?;
            self.link(direct, marks, batch, &mut gathered)?;
            next = end;
            if direct.reporter.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        Ok(gathered)
    }

    /// Finds out which of the marked points are inside solids, and gives the others their index.
    fn probe(&mut self, direct: &mut DirectLighting<'_, '_>, marks: &mut Marks) -> Result<(), Error> {
        let wanted = self.points.take(marks, self.value_bytes(), self.max_memory)?;
        let (points, scene) = (&self.points, direct.scene);
        let probed: Vec<_> = match self.sides {
            Sides::Six => {
                direct.stats.rays.secondary += PROBE_RAYS * wanted.len() as u64;
                let look = |&at: &Address| {
                    let spacing = points.level(at.level).lattice.spacing();
                    (at, probe(scene, points.place(at), spacing))
                };
                wanted.par_iter().map(look).collect()
            }
            // The paper's mesh knows no geometry: every point counts.
            Sides::One => wanted.iter().map(|&c| (c, Some(super::clearance::Clearance::ALL_FREE))).collect(),
        };
        probed.into_iter().for_each(|point| self.points.insert(point));
        Ok(())
    }

    /// Memory of a point.
    pub(crate) fn bytes_per_point(&self) -> u64 {
        self.value_bytes() + Points::BYTES_PER_POINT
    }

    /// Memory of a point's levels and of its transfers while it is being filled.
    fn value_bytes(&self) -> u64 {
        let levels = self.levels.len() * self.sides.count() * size_of::<Vec4>();
        let transfers = if self.links() { self.gather_rays as usize * size_of::<Transfer>() } else { 0 };
        (levels + transfers) as u64
    }

    /// Whether any level reads the one below through surfaces: not for direct light that is reflected once.
    fn links(&self) -> bool {
        self.levels.len() > 1
    }

    /// Shoots the gather rays of the points from `first` on, one [`Gather`] each, and sums the light that they meet.
    fn gather(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        first: usize,
        directions: &[Vec3],
        batch: &mut [Gather],
        gathered: &mut Gathered,
    ) -> Result<(), Error> {
        let (scene, options, batch_len) = (direct.scene, direct.options, batch.len());
        batch.par_iter_mut().zip(first..first + batch_len).for_each(|(gather, index)| {
            let seed = seed_of_point(self.seed, self.points.address(index));
            gather.sphere(scene, options, self.points.position(index), seed, directions);
        });

        // Light at the hits: the direct mesh, one wave deeper.
        if self.levels.len() > 1 {
            let mut lists: Vec<_> = batch.iter_mut().map(|gather| &mut gather.lit).collect();
            let seconds = direct.light(Sight::One, &mut lists)?;
            direct.stats.seconds.fill_direct += seconds.fill;
        }
        for gather in batch {
            let (mut emission, mut first) = ([Vec4::ZERO; 6], [Vec4::ZERO; 6]);
            for &(ray, radiance) in &gather.emitted {
                self.splat(&mut emission, gather.lobes[ray as usize], radiance);
            }
            if self.levels.len() > 1 {
                for (vertex, &irradiance) in gather.lit.vertices.iter().zip(&gather.lit.direct) {
                    self.splat(&mut first, gather.lobes[vertex.pixel as usize], vertex.weight * irradiance);
                    self.hit_irradiance.0 += f64::from(irradiance.element_sum() / 3.0);
                }
                self.hit_irradiance.1 += gather.lit.vertices.len() as u64;
            }
            let sides = self.sides.count();
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
        match self.sides {
            Sides::Six => {
                for axis in 0..3 {
                    sides[2 * axis + usize::from(lobe[axis] < 0.0)] += radiance * lobe[axis].abs();
                }
            }
            Sides::One => sides[0] += radiance * (4.0 * std::f32::consts::PI / self.gather_rays as f32),
        }
    }

    /// Finds the points that the hits read; those that are missing join the mesh.
    fn link(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        batch: &mut [Gather],
        gathered: &mut Gathered,
    ) -> Result<(), Error> {
        // Reflected once, direct light needs no points; only emission that is gathered does.
        if !self.links() || (self.levels.len() == 2 && !direct.scene.has_gathered_emitters()) {
            gathered.transfers.resize_with(gathered.transfers.len() + batch.len(), Vec::new);
            return Ok(());
        }
        let mut links: Vec<Linked> = batch.iter().map(|_| Linked::default()).collect();
        loop {
            let field = &*self;
            batch.par_iter().zip(&mut links).filter(|(_, linked)| !linked.complete).for_each(|(gather, linked)| {
                let mut reader = field.points.reader(direct.scene, Sight::One);
                let mut corners = Vec::with_capacity(8);
                linked.transfers.clear();
                linked.transfers.reserve(gather.lit.vertices.len());
                linked.complete = true;
                for vertex in &gather.lit.vertices {
                    corners.clear();
                    let from = match reader.read(vertex, marks, |index, weight| corners.push((index, weight))) {
                        Outcome::Read => choose(corners.iter().copied(), seed_of_place(vertex.position)),
                        Outcome::Nothing => Transfer::NOWHERE,
                        Outcome::Empty => {
                            linked.complete = false;
                            continue;
                        }
                    };
                    let lobe = gather.lobes[vertex.pixel as usize];
                    linked.transfers.push(Transfer { from, n: vertex.n, weight: vertex.weight, lobe });
                }
                // Stable: the sums keep the order of the rays.
                linked.transfers.sort_by_key(|t| t.from != Transfer::NOWHERE);
                linked.sight_rays += reader.sight_rays();
            });
            if links.iter().all(|linked| linked.complete) {
                direct.stats.rays.secondary += links.iter().map(|linked| linked.sight_rays).sum::<u64>();
                gathered.transfers.extend(links.into_iter().map(|linked| linked.transfers));
                return Ok(());
            }
            self.probe(direct, marks)?;
        }
    }

    /// The levels of all points from `first` on.
    fn bounce(&mut self, scene: &Scene, first: usize, gathered: Gathered) {
        let sides = self.sides.count();
        let Gathered { emission, first: once, transfers } = gathered;
        let levels = self.levels.len();
        self.levels[0].extend(emission);
        for k in 1..levels {
            if k == 1 && !scene.has_gathered_emitters() {
                self.levels[1].extend_from_slice(&once);
                continue;
            }
            let (field, below) = (&*self, &self.levels[k - 1]);
            let level: Vec<[Vec4; 6]> = transfers
                .par_iter()
                .zip(once.par_chunks_exact(sides))
                .map(|(transfers, once)| {
                    let mut values = [Vec4::ZERO; 6];
                    values[..sides].copy_from_slice(once);
                    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                    let (nowhere, read) =
                        transfers.split_at(transfers.partition_point(|t| t.from == Transfer::NOWHERE));
                    for t in read {
                        let irradiance = field.irradiance(below, t.from, &Axes::facing(t.n)).truncate();
                        field.splat(&mut values, t.lobe, t.weight * irradiance);
                        (sum, count) = (sum + irradiance, count + 1.0);
                    }
                    for t in nowhere {
                        field.splat(&mut values, t.lobe, t.weight * sum / f32::max(count, 1.0));
                    }
                    values
                })
                .collect();
            self.levels[k].extend(level.iter().flat_map(|values| &values[..sides]));
        }
        debug_assert!(self.levels.iter().all(|level| level.len() == self.points.len() * sides), "{first}");
    }
}
