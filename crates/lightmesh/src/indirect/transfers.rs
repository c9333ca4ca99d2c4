//! Transfers: how light goes from the ends of a point's gather rays to the point, by way of the mesh points that are read
//! there.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::field::IndirectField;
use super::gather::GatherRays;
use super::probing::Marked;
use crate::mesh::{CornerVisibility, Marks, ReadResult, Slot, choose};
use crate::sampling::seed_of_position;
use crate::{Error, Scene};

/// How light reaches a point along one gather ray: from the surface that the ray hit, which reads one point of the
/// mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transfer {
    /// The point that the surface reads: one of its corners, chosen in proportion to their weights. The mean over the
    /// rays is the mean over the corners, at an eighth of the reads. [`Transfer::NO_POINT`] where none can serve, as
    /// in a narrow gap: such surfaces get the mean of the others' irradiance, for they must not swallow light.
    pub from: u32,
    /// The surface's normal.
    pub n: Vec3,
    /// Radiance along the ray per unit of irradiance at the surface.
    pub weight: Vec3,
    /// Irradiance on the cube faces per unit of radiance (see [`GatherRays::sphere`]).
    pub lobe: Vec3,
}

impl Transfer {
    pub(super) const NO_POINT: u32 = u32::MAX;
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
    pub(super) emission: Vec<Vec4>,
    pub(super) first: Vec<Vec4>,
    /// By point.
    pub(super) transfers: Vec<Vec<Transfer>>,
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
    /// Memory of a point's transfers while it is being filled, bytes.
    pub(super) fn transfer_bytes(&self) -> u64 {
        if self.reflects_light() { u64::from(self.gather_rays) * size_of::<Transfer>() as u64 } else { 0 }
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
            // Choose a point for every hit, and mark it if it has no values; lists with empty points are made again.
            let field = &*self;
            batch.par_iter().zip(&mut lists).filter(|(_, list)| !list.complete).for_each(|(gather, list)| {
                field.choose_points(scene, marks, gather, list);
            });
            let is_complete = lists.iter().all(|list| list.complete);
            // Add the points that are missing.
            rays += self.probe(scene, marks, Marked::ToRead, first)?;
            if is_complete {
                break;
            }
        }
        rays += lists.iter().map(|list| list.visibility_rays).sum::<u64>();

        // All have their index now.
        let points = &self.points;
        lists.par_iter_mut().flat_map_iter(|list| &mut list.transfers).for_each(|transfer| {
            if let Slot::Probed(index) = Slot::unpack(transfer.from)
                && let Slot::Filled(filled) = points.slot(points.probed_address(index))
            {
                transfer.from = filled;
            }
        });
        pending.transfers.extend(lists.into_iter().map(|list| list.transfers));
        Ok(rays)
    }

    /// Chooses a point for every hit of a point's rays. Those without values are marked.
    fn choose_points(&self, scene: &Scene, marks: &Marks, gather: &GatherRays, list: &mut TransferList) {
        let mut reader = self.points.corner_reader(scene, CornerVisibility::Stochastic);
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
            if let Slot::Probed(index) = Slot::unpack(from) {
                self.points.mark(self.points.probed_address(index), marks);
            }
            let lobe = gather.lobes[hit.id as usize];
            list.transfers.push(Transfer { from, n: hit.n, weight: hit.weight, lobe });
        }
        // Those without a point first. Stable: the sums keep the order of the rays.
        list.transfers.sort_by_key(|t| t.from != Transfer::NO_POINT);
        list.visibility_rays += reader.visibility_rays();
    }
}
