//! Evaluating the points of the direct field that were requested.

use rayon::prelude::*;

use super::encoding::PointValues;
use super::field::DirectField;
use super::point_lights::PointLights;
use crate::mesh::{Address, Clearance, Marks, PROBE_RAYS, probe};
use crate::progress::Reporter;
use crate::{Error, RayCounts, Scene};

/// Points that are evaluated before they are stored and memory is checked: some 600 B each while they wait, 10 KiB if they
/// have runs; and each may be in a block of the sky of its own.
const POINTS_AT_ONCE: usize = 1 << 13;

/// A point that has been evaluated.
struct EvaluatedPoint {
    address: Address,
    /// `None`: it is inside a solid, and has no values.
    clearance: Option<Clearance>,
    values: Option<PointValues>,
}

impl DirectField {
    /// Evaluates the marked points in parallel, in brick order, and clears the marks; counts the rays for `reporter`.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] before anything is allocated, [`Error::Cancelled`] soon after it: with many lights, a
    /// fill takes long.
    pub(crate) fn fill(
        &mut self,
        scene: &Scene,
        marks: &mut Marks,
        reporter: &Reporter<'_>,
    ) -> Result<RayCounts, Error> {
        let requested = self.points.take_marked(marks, self.costs(), &self.memory)?;
        let mut rays = RayCounts::default();
        if self.encoding.needs_probes() {
            rays.secondary = PROBE_RAYS * requested.len() as u64;
        }
        // The number of runs shows only when points have been evaluated.
        for requested in requested.chunks(POINTS_AT_ONCE) {
            rays.shadow += self.evaluate(scene, requested, reporter)?;
        }
        self.memory.hold(self.stats().bytes);
        Ok(rays)
    }

    /// Evaluates some requested points and stores them; returns the number of shadow rays.
    fn evaluate(&mut self, scene: &Scene, requested: &[Address], reporter: &Reporter<'_>) -> Result<u64, Error> {
        // Look at the sky from where the points are.
        let (points, encoding, lights) = (&self.points, &self.encoding, &self.lights);
        let spacing = |address: Address| points.level(address.level).lattice.spacing();
        let mut rays = match lights.has_clusters() {
            true => 0,
            false => self.sky.look_from(scene, requested.iter().map(|&a| (points.position_of(a), spacing(a)))),
        };
        reporter.add(0, rays);

        // Evaluate: the only expensive step. Chunks are large enough to share a worker's buffers.
        let sky = &self.sky;
        let summed = encoding.sums_lights();
        let evaluated: Vec<_> = requested
            .par_chunks(64)
            .map(|chunk| {
                if reporter.cancelled() {
                    return Err(Error::Cancelled);
                }
                let mut sky = if lights.has_clusters() { None } else { sky.reader(scene) };
                let mut lights = PointLights::new(scene, lights.at(scene), encoding.falloff());
                let mut evaluate = |&address: &Address| {
                    let x = points.position_of(address);
                    let spacing = spacing(address);
                    let clearance = match encoding.needs_probes() {
                        true => probe(scene, x, spacing),
                        false => Some(Clearance::ALL_FREE),
                    };
                    let values = clearance.map(|_| {
                        lights.trace(x, sky.as_mut().map(|sky| sky.around(x, spacing)), summed);
                        encoding.evaluate(&lights)
                    });
                    EvaluatedPoint { address, clearance, values }
                };
                let evaluated: Vec<_> = chunk.iter().map(&mut evaluate).collect();
                let rays = lights.shadow_rays() + sky.map_or(0, |sky| sky.rays());
                let probes = if encoding.needs_probes() { PROBE_RAYS * chunk.len() as u64 } else { 0 };
                reporter.add(0, rays + probes);
                Ok((evaluated, rays))
            })
            .collect::<Result<_, Error>>()?;

        // Refuse runs that do not fit.
        let values = evaluated.iter().flat_map(|(points, _)| points).filter_map(|point| point.values.as_ref());
        let runs: Vec<usize> = values.filter_map(PointValues::run_count).collect();
        self.check_memory_of_runs(runs.len(), runs.iter().sum())?;

        // Store, in the order of the list: slots do not depend on the number of threads.
        for (points, shadow_rays) in evaluated {
            rays += shadow_rays;
            for EvaluatedPoint { address, clearance, values } in points {
                self.points.insert(address, clearance);
                if let Some(values) = values {
                    self.encoding.push(&values);
                }
            }
        }
        Ok(rays)
    }
}
