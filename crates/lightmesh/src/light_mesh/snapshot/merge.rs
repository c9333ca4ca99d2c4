//! Merging a snapshot into a mesh.

use super::super::LightMesh;
use super::{DirectSnapshot, DirectValues, IndirectSnapshot, Snapshot};
use crate::Error;
use crate::direct::DirectField;
use crate::direct::encoding::{check_finite, check_length, refuse, values};
use crate::indirect::IndirectField;

impl LightMesh {
    /// Adds the points of a snapshot, made of another mesh of the same scene and settings, that this mesh does not
    /// have; its own points stay as they are. Pictures do not change by it, bit for bit: merged points only need not be
    /// evaluated again.
    ///
    /// A snapshot does not tell whether its scene and settings are the same: compare
    /// [`Fingerprint`](crate::Fingerprint)s.
    ///
    /// # Errors
    /// [`Error::InvalidContents`] for a snapshot of another method, lattice or number of bounces, and for invalid
    /// values; [`Error::OutOfMemory`] if its points would not fit into the memory that the mesh was allowed when it was
    /// made. The mesh has not changed then.
    pub fn merge(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        // Check everything, then change.
        self.direct.check(&snapshot.direct)?;
        match (&self.indirect, &snapshot.indirect) {
            (Some(field), Some(indirect)) => field.check(indirect)?,
            (Some(_), None) => return refuse("indirect", "is missing; the mesh has indirect light"),
            (None, Some(_)) => return refuse("indirect", "is given; the mesh has no indirect light"),
            (None, None) => {}
        }
        self.direct.merge(&snapshot.direct);
        if let (Some(field), Some(indirect)) = (&mut self.indirect, &snapshot.indirect) {
            field.merge(indirect);
        }
        Ok(())
    }
}

impl DirectField {
    /// Refuses a snapshot of another kind of mesh.
    fn check(&self, snapshot: &DirectSnapshot) -> Result<(), Error> {
        let DirectSnapshot { points, values } = snapshot;
        self.points.check(points, "direct")?;
        self.encoding.check(values, points.addresses.len())?;

        // Refuse more than fits into memory.
        let (new, bricks) = self.points.count_new(points);
        self.points.reserve_memory(new, bricks, self.costs(), &self.memory)?;
        match values {
            DirectValues::Runs { ends, runs } => self.check_memory_of_runs(ends.len(), runs.len()),
            _ => Ok(()),
        }
    }

    /// Adds the new points of a snapshot that has been checked.
    fn merge(&mut self, snapshot: &DirectSnapshot) {
        let Self { points, encoding, .. } = self;
        points.merge(&snapshot.points, |i| encoding.push_snapshot(&snapshot.values, i));
    }
}

impl IndirectField {
    /// Refuses a snapshot of another kind of mesh.
    fn check(&self, snapshot: &IndirectSnapshot) -> Result<(), Error> {
        // Refuse values of another shape, and values that light cannot have.
        let (faces, bounces) = (self.faces.count(), self.bounce_values.len() - 1);
        if snapshot.faces as usize != faces {
            let what = format!("have {} sides; this mesh keeps {faces}: it is of another method", snapshot.faces);
            return refuse("indirect values", what);
        }
        if snapshot.bounces as usize != bounces {
            let what = format!("go up to {} bounces; this mesh was made for {bounces}", snapshot.bounces);
            return refuse("indirect values", what);
        }
        self.points.check(&snapshot.points, "indirect")?;
        let shape = [self.bounce_values.len(), snapshot.points.addresses.len(), faces, 3];
        check_length("indirect values", snapshot.values.len(), &shape)?;
        check_finite("indirect values", &snapshot.values)?;
        if !(snapshot.hit_irradiance.is_finite() && snapshot.hit_irradiance >= 0.0) {
            return refuse("indirect", format!("the sum at gather hits is {}", snapshot.hit_irradiance));
        }

        // Refuse more than fits into memory.
        let (new, bricks) = self.points.count_new(&snapshot.points);
        self.points.reserve_memory(new, bricks, self.costs(), &self.memory)
    }

    /// Adds the new points of a snapshot that has been checked.
    fn merge(&mut self, snapshot: &IndirectSnapshot) {
        let (count, stride) = (snapshot.points.addresses.len(), 3 * self.faces.count());
        let Self { points, bounce_values: levels, .. } = self;
        let before = points.len();
        points.merge(&snapshot.points, |i| {
            for (k, level) in levels.iter_mut().enumerate() {
                level.extend(values(&snapshot.values[(k * count + i) * stride..][..stride]));
            }
        });
        // Take the part of the sum that new points have of all points: enough for an estimate.
        let part = (self.points.len() - before) as f64 / count.max(1) as f64;
        self.gather_hit_irradiance.0 += part * snapshot.hit_irradiance;
        self.gather_hit_irradiance.1 =
            self.gather_hit_irradiance.1.saturating_add((part * snapshot.hit_count as f64) as u64);
    }
}
