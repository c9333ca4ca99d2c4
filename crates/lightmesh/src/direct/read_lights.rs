//! Reading the direct field light by light: what the points around a surface know of single lights, or of clusters.

use super::read::DirectReader;
use super::region_visibility::KnownLights;
use crate::interaction::ShadingPoint;
use crate::mesh::{Marks, Outcome, bits as corners_of};

/// What a vertex finds in the direct mesh about single lights. [`DirectReader::known_lights`] has what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightsReading {
    /// The points of the neighbourhood know something.
    Known,
    /// No point of the neighbourhood can be used, but lights are clusters: those around the vertex, of which nothing is known.
    Unknown,
    /// No point of the neighbourhood can be used.
    Nothing,
    /// Points are missing; they have been marked.
    Empty,
}

impl DirectReader<'_> {
    /// What the points of D_y know of each light; points that are still empty are marked. The field must have been made for a method
    /// that asks.
    #[inline(always)]
    pub(crate) fn read_lights(&mut self, vertex: &ShadingPoint, marks: &Marks) -> LightsReading {
        if !self.reader.reads_cells() {
            return self.ask_points(vertex, marks);
        }
        let seen = match self.reader.corners(vertex, marks) {
            Ok(seen) => seen,
            Err(Outcome::Empty) => return LightsReading::Empty,
            Err(_) => return self.nothing_known(vertex),
        };
        if seen.refined > 0.0 {
            return self.ask_points(vertex, marks);
        }
        self.enter_region(vertex);
        let Self { field, reader, agreement, near, rows, .. } = self;
        // Lights beyond corners that are missing are beyond what hides these.
        (agreement.doubt, agreement.cluttered) = (reader.towards_missing(vertex), reader.is_cluttered());
        let voters = (reader.visits(), seen.mask);
        match (&field.bits, &field.runs, near) {
            (Some(bits), ..) => agreement.ask_corners(bits, voters, &seen.weights, |k| reader.index(k)),
            (None, Some(runs), Some(near)) => {
                if !agreement.knows(voters) {
                    for k in corners_of(seen.mask) {
                        rows[k] = near.row(runs, reader.index(k));
                    }
                }
                agreement.ask_corners(near.bits(), voters, &seen.weights, |k| rows[k]);
            }
            _ => return LightsReading::Nothing,
        }
        LightsReading::Known
    }

    #[cold]
    fn ask_points(&mut self, vertex: &ShadingPoint, marks: &Marks) -> LightsReading {
        let mut points = Vec::new();
        match self.reader.read(vertex, marks, |index, weight| points.push((index, weight))) {
            Outcome::Read => {}
            Outcome::Nothing => return self.nothing_known(vertex),
            Outcome::Empty => return LightsReading::Empty,
        }
        self.enter_region(vertex);
        let Self { field, reader, agreement, near, .. } = self;
        (agreement.doubt, agreement.cluttered) = (reader.towards_missing(vertex), reader.is_cluttered());
        match (&field.bits, &field.runs, near) {
            (Some(bits), ..) => agreement.ask(bits, &points),
            (None, Some(runs), Some(near)) => {
                for (point, _) in &mut points {
                    *point = near.row(runs, *point);
                }
                agreement.ask(near.bits(), &points);
            }
            _ => return LightsReading::Nothing,
        }
        LightsReading::Known
    }

    /// Makes the lights of the vertex' region those that are asked about, where they are clusters.
    #[inline(always)]
    fn enter_region(&mut self, vertex: &ShadingPoint) {
        if let Some(lanes) = self.near.as_mut().and_then(|near| near.enter(vertex.position)) {
            self.agreement.restart(lanes);
        }
    }

    #[cold]
    fn nothing_known(&mut self, vertex: &ShadingPoint) -> LightsReading {
        if self.near.is_none() {
            return LightsReading::Nothing;
        }
        self.enter_region(vertex);
        self.agreement.ask_nobody();
        LightsReading::Unknown
    }

    /// The lights that the last reading was about, and what is known of them.
    #[inline(always)]
    pub(crate) fn known_lights(&self) -> KnownLights<'_> {
        match &self.near {
            Some(near) => near.known(&self.agreement),
            None => KnownLights { lights: self.samples, clusters: None, agreement: &self.agreement },
        }
    }
}
