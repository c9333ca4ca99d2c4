//! Evaluating the points of the direct field that were asked for.

use rayon::prelude::*;

use super::evaluate::Evaluator;
use super::field::{DirectEncoding, DirectField};
use crate::mesh::{Address, Clearance, Marks, PROBE_RAYS, probe};
use crate::{Error, PaperScale, RayCounts, Scene};

/// Points with runs that are evaluated before their memory is checked: some 10 KiB each while they wait.
const POINTS_WITH_RUNS: usize = 1 << 13;

impl DirectField {
    /// Evaluates the marked points in parallel, in brick order, and clears the marks.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated.
    pub(crate) fn fill(&mut self, scene: &Scene, marks: &mut Marks) -> Result<RayCounts, Error> {
        let wanted = self.points.take(marks, self.costs(), self.max_memory)?;
        let mut rays = RayCounts::default();
        if !matches!(self.encoding, DirectEncoding::Scalar { scale: PaperScale::Constant, .. }) {
            rays.secondary = PROBE_RAYS * wanted.len() as u64;
        }
        // How many runs points have is known when they have been evaluated.
        let together = if self.runs.is_some() { POINTS_WITH_RUNS } else { wanted.len().max(1) };
        for wanted in wanted.chunks(together) {
            rays.shadow += self.evaluate(scene, wanted)?;
        }
        Ok(rays)
    }

    /// Evaluates some points that were wanted, and stores them; how many shadow rays it took.
    fn evaluate(&mut self, scene: &Scene, wanted: &[Address]) -> Result<u64, Error> {
        let stride = self.encoding.stride();
        // Evaluate: the only expensive step. Chunks are large enough to share a worker's buffers.
        let (grid, field, constant, lights) = (&self.points, self.encoding, self.constant, &self.lights);
        let (bits, runs, padding) = (self.bits.as_ref(), self.runs.as_ref(), self.padding.as_slice());
        let evaluated: Vec<_> = wanted
            .par_chunks(64)
            .map(|chunk| {
                let mut evaluator = Evaluator::new(scene, lights.at(scene), field, constant);
                let points: Vec<_> = chunk
                    .iter()
                    .map(|&address| {
                        let x = grid.position_of(address);
                        let clearance = match field {
                            // The paper's mesh knows no geometry: as printed, every point counts.
                            DirectEncoding::Scalar { scale: PaperScale::Constant, .. } => Some(Clearance::ALL_FREE),
                            _ => probe(scene, x, grid.level(address.level).lattice.spacing()),
                        };
                        let values = clearance.map(|_| {
                            let values = evaluator.evaluate(x);
                            let packed = bits.map(|bits| evaluator.pack(bits, padding));
                            (values, packed, runs.map(|_| evaluator.runs()))
                        });
                        ((address, clearance), values)
                    })
                    .collect();
                (points, evaluator.shadow_rays())
            })
            .collect();

        if let Some(runs) = runs {
            let new =
                evaluated.iter().flat_map(|(points, _)| points).filter_map(|(_, values)| values.as_ref()?.2.as_deref());
            // A growing vector may hold twice its contents for a moment.
            let needed_bytes = grid.stats(2 * runs.bytes_with(new) + lights.bytes()).bytes;
            if needed_bytes > self.max_memory {
                return Err(Error::OutOfMemory {
                    what: "the light mesh",
                    needed_bytes,
                    limit_bytes: self.max_memory,
                    advice: "choose a larger --spacing or --light-error",
                });
            }
        }

        // Store, in the order of the list: slots do not depend on the number of threads.
        let mut rays = 0;
        for (points, shadow_rays) in evaluated {
            rays += shadow_rays;
            for (probed, values) in points {
                self.points.insert(probed);
                let Some((values, packed, new)) = values else { continue };
                self.values.extend_from_slice(&values[..stride]);
                if let (Some(runs), Some(new)) = (&mut self.runs, new) {
                    runs.push(&new);
                }
                if let (Some(bits), Some(packed)) = (&mut self.bits, packed) {
                    bits.push(&packed);
                }
            }
        }
        Ok(rays)
    }
}
