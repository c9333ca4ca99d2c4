//! Taking in what another mesh knows.

use super::super::LightMesh;
use super::{DirectSnapshot, DirectValues, IndirectSnapshot, Snapshot};
use crate::Error;
use crate::direct::DirectField;
use crate::direct::encoding::{check_finite, check_length, refuse, values};
use crate::indirect::IndirectField;

impl LightMesh {
    /// Adds the points of another mesh of the same scene and settings that this one does not have; others are left as they are. What is
    /// rendered with it afterwards is bit for bit what it would have been: absorbed points are not evaluated again.
    ///
    /// That the scene and the settings are the same cannot be seen in contents: compare [`Fingerprint`](crate::Fingerprint)s.
    ///
    /// # Errors
    /// [`Error::InvalidContents`] for contents of a mesh of another kind, lattice or number of bounces, and for such that cannot be true;
    /// [`Error::OutOfMemory`] if its points would not fit into the memory that the mesh was allowed when it was made. The mesh has not
    /// changed then.
    pub fn merge(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        // Check everything, then change.
        self.direct.check(&snapshot.direct)?;
        match (&self.indirect, &snapshot.indirect) {
            (Some(field), Some(contents)) => field.check(contents)?,
            (Some(_), None) => return refuse("indirect", "is missing; the mesh has indirect light"),
            (None, Some(_)) => return refuse("indirect", "is given; the mesh has no indirect light"),
            (None, None) => {}
        }
        self.direct.merge(&snapshot.direct);
        if let (Some(field), Some(contents)) = (&mut self.indirect, &snapshot.indirect) {
            field.merge(contents);
        }
        Ok(())
    }
}

impl DirectField {
    fn check(&self, snapshot: &DirectSnapshot) -> Result<(), Error> {
        let DirectSnapshot { points, values } = snapshot;
        self.points.check(points, "direct")?;
        self.encoding.check(values, points.addresses.len())?;
        let (new, bricks) = self.points.count_new(points);
        self.points.check_memory(new, bricks, self.costs(), self.max_memory())?;
        match values {
            DirectValues::Runs { ends, runs } => self.check_memory_of_runs(ends.len(), runs.len()),
            _ => Ok(()),
        }
    }

    /// Adds the points that are new; the snapshot has been checked.
    fn merge(&mut self, snapshot: &DirectSnapshot) {
        let Self { points, encoding, .. } = self;
        points.merge(&snapshot.points, |i| encoding.push_snapshot(&snapshot.values, i));
    }
}

impl IndirectField {
    fn check(&self, snapshot: &IndirectSnapshot) -> Result<(), Error> {
        let (sides, bounces) = (self.faces.count(), self.bounce_values.len() - 1);
        if snapshot.faces as usize != sides {
            let what = format!("have {} sides; this mesh keeps {sides}: it is of another method", snapshot.faces);
            return refuse("indirect values", what);
        }
        if snapshot.bounces as usize != bounces {
            let what = format!("go up to {} bounces; this mesh was made for {bounces}", snapshot.bounces);
            return refuse("indirect values", what);
        }
        self.points.check(&snapshot.points, "indirect")?;
        let shape = [self.bounce_values.len(), snapshot.points.addresses.len(), sides, 3];
        check_length("indirect values", snapshot.values.len(), &shape)?;
        check_finite("indirect values", &snapshot.values)?;
        if !(snapshot.hit_irradiance.is_finite() && snapshot.hit_irradiance >= 0.0) {
            return refuse("indirect", format!("the sum at gather hits is {}", snapshot.hit_irradiance));
        }
        let (new, bricks) = self.points.count_new(&snapshot.points);
        self.points.check_memory(new, bricks, self.costs(), self.max_memory)
    }

    /// Adds what is not known; it has been checked.
    fn merge(&mut self, snapshot: &IndirectSnapshot) {
        let (count, one) = (snapshot.points.addresses.len(), 3 * self.faces.count());
        let Self { points, bounce_values: levels, .. } = self;
        let before = points.len();
        points.merge(&snapshot.points, |i| {
            for (k, level) in levels.iter_mut().enumerate() {
                level.extend(values(&snapshot.values[(k * count + i) * one..][..one]));
            }
        });
        // Of all that was gathered, the part of the points that are new: enough for an estimate.
        let part = (self.points.len() - before) as f64 / count.max(1) as f64;
        self.gather_hit_irradiance.0 += part * snapshot.hit_irradiance;
        self.gather_hit_irradiance.1 =
            self.gather_hit_irradiance.1.saturating_add((part * snapshot.hit_count as f64) as u64);
    }
}
