//! Which points of the indirect mesh are inside solids, what is near the others, and which of them are to have values.

use rayon::prelude::*;

use super::field::{CubeFaces, IndirectField};
use crate::mesh::{Address, Clearance, Costs, Marks, PROBE_RAYS, Slot, probe};
use crate::{Error, Scene};

/// What becomes of marked points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Marked {
    /// Surfaces are about to read them: those that are empty are only probed, as their clearances may tell that no
    /// surface sees them. What is seen is marked again and then gets its values. Gather rays are not shot at points
    /// behind a wall.
    ToRead,
    /// All get their values.
    Needed,
}

impl IndirectField {
    /// Probes the marked points that are empty: finds out which are inside solids, and the clearance of the others. Those
    /// that need values get their index; from `first` on they are being filled. Returns how many rays that took.
    pub(crate) fn probe(
        &mut self,
        scene: &Scene,
        marks: &mut Marks,
        marked: Marked,
        first: usize,
    ) -> Result<u64, Error> {
        let addresses = self.points.take_marked(marks, self.costs(), &self.memory)?;
        let points = &self.points;
        let (empty, known): (Vec<Address>, Vec<Address>) =
            addresses.iter().partition(|&&address| points.slot(address) == Slot::Empty);
        // The paper's mesh knows no geometry: every point counts.
        let (probed, rays): (Vec<Option<Clearance>>, _) = match self.faces {
            CubeFaces::Six => {
                let probe_point = |&address: &Address| {
                    let spacing = points.level(address.level).lattice.spacing();
                    probe(scene, points.position_of(address), spacing)
                };
                (empty.par_iter().map(probe_point).collect(), PROBE_RAYS * empty.len() as u64)
            }
            CubeFaces::One => (vec![Some(Clearance::ALL_FREE); empty.len()], 0),
        };
        for (&address, clearance) in empty.iter().zip(probed) {
            self.points.insert_probed(address, clearance);
        }

        // Choose those that are to have values.
        let needed = if marked == Marked::Needed || self.faces == CubeFaces::One { addresses } else { known };
        let costs = Costs { temporary: self.transfer_bytes(), pending: self.points.len() - first, ..self.costs() };
        self.points.reserve_memory(needed.len(), 0, costs, &self.memory)?;
        needed.into_iter().for_each(|address| self.points.promote(address));
        Ok(rays)
    }
}
