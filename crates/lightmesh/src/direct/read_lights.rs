//! Reading the direct field light by light: what the points around a surface know of single lights, or of clusters.

use super::read::DirectReader;
use super::region_visibility::LightCutVisibility;
use crate::interaction::ShadingPoint;
use crate::mesh::{Marks, ReadResult, set_bits as corners_of};

/// What a vertex finds in the direct mesh about single lights. [`DirectReader::lights`] has what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightsReading {
    /// The points of the neighbourhood know something.
    Known,
    /// No point of the neighbourhood can be used, but lights are clusters: those around the vertex, of which nothing is known.
    Unknown,
    /// No point of the neighbourhood can be used.
    Nothing,
    /// Points are missing; they have been marked.
    Pending,
}

impl DirectReader<'_> {
    /// What the points of D_y know of each light; points that are still empty are marked. The field must have been made for a method
    /// that asks.
    #[inline(always)]
    pub(crate) fn read_lights(&mut self, vertex: &ShadingPoint, marks: &Marks) -> LightsReading {
        if !self.reader.reads_cells() {
            return self.read_points_by_light(vertex, marks);
        }
        let seen = match self.reader.corners(vertex, marks) {
            Ok(seen) => seen,
            Err(ReadResult::Pending) => return LightsReading::Pending,
            Err(_) => return self.unknown(vertex),
        };
        if seen.refined > 0.0 {
            return self.read_points_by_light(vertex, marks);
        }
        self.enter_region(vertex);
        let Self { field, reader, estimate: agreement, near, rows, .. } = self;
        // Lights beyond corners that are missing are beyond what hides these.
        (agreement.occluder_direction, agreement.near_occluder) =
            (reader.towards_missing(vertex), reader.has_near_occluder());
        let voters = (reader.visits(), seen.mask);
        match (&field.bits, &field.runs, near) {
            (Some(bits), ..) => agreement.set_corners(bits, voters, &seen.weights, |k| reader.index(k)),
            (None, Some(runs), Some(near)) => {
                if !agreement.knows(voters) {
                    for k in corners_of(seen.mask) {
                        rows[k] = near.row(runs, reader.index(k));
                    }
                }
                agreement.set_corners(near.bits(), voters, &seen.weights, |k| rows[k]);
            }
            _ => return LightsReading::Nothing,
        }
        LightsReading::Known
    }

    #[cold]
    fn read_points_by_light(&mut self, vertex: &ShadingPoint, marks: &Marks) -> LightsReading {
        let mut points = Vec::new();
        match self.reader.read(vertex, marks, |index, weight| points.push((index, weight))) {
            ReadResult::Value => {}
            ReadResult::Unavailable => return self.unknown(vertex),
            ReadResult::Pending => return LightsReading::Pending,
        }
        self.enter_region(vertex);
        let Self { field, reader, estimate: agreement, near, .. } = self;
        (agreement.occluder_direction, agreement.near_occluder) =
            (reader.towards_missing(vertex), reader.has_near_occluder());
        match (&field.bits, &field.runs, near) {
            (Some(bits), ..) => agreement.set_points(bits, &points),
            (None, Some(runs), Some(near)) => {
                for (point, _) in &mut points {
                    *point = near.row(runs, *point);
                }
                agreement.set_points(near.bits(), &points);
            }
            _ => return LightsReading::Nothing,
        }
        LightsReading::Known
    }

    /// Makes the lights of the vertex' region those that are asked about, where they are clusters.
    #[inline(always)]
    fn enter_region(&mut self, vertex: &ShadingPoint) {
        if let Some(lanes) = self.near.as_mut().and_then(|near| near.enter(vertex.position)) {
            self.estimate.restart(lanes);
        }
    }

    #[cold]
    fn unknown(&mut self, vertex: &ShadingPoint) -> LightsReading {
        if self.near.is_none() {
            return LightsReading::Nothing;
        }
        self.enter_region(vertex);
        self.estimate.clear();
        LightsReading::Unknown
    }

    /// The lights that the last reading was about, and what is known of them.
    #[inline(always)]
    pub(crate) fn lights(&self) -> LightCutVisibility<'_> {
        match &self.near {
            Some(near) => near.visibility(&self.estimate),
            None => LightCutVisibility { lights: self.samples, clusters: None, estimate: &self.estimate },
        }
    }
}
