//! Transfers: how light goes from the ends of a point's gather rays to the point, by way of the mesh points that are read
//! there.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::field::IndirectField;
use super::gather::GatherRays;
use super::probing::Marked;
use crate::direct::PlacedVertices;
use crate::interaction::ShadingPoint;
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

/// From where the surfaces at some hits get their light, and what it took to find out.
#[derive(Debug, Default)]
struct Choices {
    /// By hit, as [`Transfer::from`], or its packed slot; [`Choices::PENDING`] where points must be probed first.
    from: Vec<u32>,
    visibility_rays: u64,
}

impl Choices {
    /// The packed slot of a point inside a solid, which no hit reads.
    const PENDING: u32 = Transfer::NO_POINT - 1;
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
        (batch, hits): (&[GatherRays], &PlacedVertices),
        first: usize,
        pending: &mut PendingLight,
    ) -> Result<u64, Error> {
        // Direct light that is reflected once needs no points, only emission that gather rays find does.
        if !self.reflects_light() || (self.bounce_values.len() == 2 && !scene.rays_find_emission()) {
            pending.transfers.resize_with(pending.transfers.len() + batch.len(), Vec::new);
            return Ok(0);
        }
        // Choose a point for every hit, and mark it if it has no values, until no hit has to wait.
        let wait = |hits: &[ShadingPoint]| Choices { from: vec![Choices::PENDING; hits.len()], visibility_rays: 0 };
        let mut choices: Vec<Choices> = hits.chunks().map(wait).collect();
        let mut rays = 0;
        loop {
            let field = &*self;
            hits.chunks().zip(&mut choices).for_each(|(hits, choices)| {
                field.choose_points(scene, marks, hits, choices);
            });
            let is_complete = !choices.iter().any(|choices| choices.from.contains(&Choices::PENDING));
            // Add the points that are missing.
            rays += self.probe(scene, marks, Marked::ToRead, first)?;
            if is_complete {
                break;
            }
        }
        rays += choices.iter().map(|choices| choices.visibility_rays).sum::<u64>();

        // All have their index now.
        let no_points = |gather: &GatherRays| vec![Transfer::NO_POINT; gather.hits.vertices.len()];
        let mut from: Vec<Vec<u32>> = batch.iter().map(no_points).collect();
        for ((list, index), &chosen) in hits.sources().zip(choices.iter().flat_map(|choices| &choices.from)) {
            from[list][index] = self.points.filled(chosen);
        }
        let lists = batch.par_iter().zip(from).map(|(gather, from)| transfers(gather, &from));
        pending.transfers.par_extend(lists);
        Ok(rays)
    }

    /// Chooses a point for each of some hits that has none yet. Those without values are marked.
    fn choose_points(&self, scene: &Scene, marks: &Marks, hits: &[ShadingPoint], choices: &mut Choices) {
        let mut reader = self.points.corner_reader(scene, CornerVisibility::Stochastic);
        let mut corners = Vec::with_capacity(8);
        for (hit, from) in hits.iter().zip(&mut choices.from).filter(|(_, from)| **from == Choices::PENDING) {
            corners.clear();
            *from = match reader.read(hit, marks, |index, weight| corners.push((index, weight))) {
                ReadResult::Value => choose(corners.iter().copied(), seed_of_position(hit.position)),
                ReadResult::Unavailable => Transfer::NO_POINT,
                ReadResult::Pending => continue,
            };
            if let Slot::Probed(index) = Slot::unpack(*from) {
                self.points.mark(self.points.probed_address(index), marks);
            }
        }
        choices.visibility_rays += reader.visibility_rays();
    }
}

/// Returns the transfers of a point, whose hits read the points `from`.
fn transfers(gather: &GatherRays, from: &[u32]) -> Vec<Transfer> {
    let hits = gather.hits.vertices.iter().zip(from);
    let transfer = |(hit, &from): (&ShadingPoint, &u32)| Transfer {
        from,
        n: hit.n,
        weight: hit.weight,
        lobe: gather.lobes[hit.id as usize],
    };
    // Those without a point first; the sums keep the order of the rays.
    let has_none = |from: u32| from == Transfer::NO_POINT;
    let mut transfers = Vec::with_capacity(from.len());
    transfers.extend(hits.clone().filter(|(_, from)| has_none(**from)).map(transfer));
    transfers.extend(hits.filter(|(_, from)| !has_none(**from)).map(transfer));
    transfers
}
