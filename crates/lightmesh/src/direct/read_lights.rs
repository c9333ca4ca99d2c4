//! Reading the direct field light by light: the visibility of single lights, or of clusters, at the points around a
//! surface.

use glam::Vec3;

use super::encoding::{DirectEncoding, LightStates, PerLight};
use super::read::{DirectReader, Reading};
use super::region_visibility::LightCutVisibility;
use super::visibility_estimate::CellCorners;
use crate::interaction::ShadingPoint;
use crate::mesh::{Marks, ReadResult, corners_of, usable_fraction};

/// The result of reading single lights at a vertex; [`DirectReader::lights`] has the lights themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightsReading {
    /// There is a visibility estimate.
    Known,
    /// No point of D_y can be used, but lights are clusters: those around the vertex, without an estimate.
    Unknown,
    /// No point of D_y can be used.
    Nothing,
    /// Points are missing; they have been marked.
    Pending,
}

impl DirectReader<'_> {
    /// Returns the part, by weight, of the points of D_y that the vertex can use, in [0, 1]; all of them have been
    /// evaluated. 0 where [`DirectReader::read`] finds nothing.
    pub(crate) fn usable_fraction(&mut self, vertex: &ShadingPoint, marks: &Marks) -> f32 {
        let reads = match self.field.encoding {
            DirectEncoding::PerLight(_) => self.read_lights(vertex, marks) == LightsReading::Known,
            _ => matches!(self.read(vertex, Vec3::ONE, marks), Reading::Visibility(_)),
        };
        if reads { usable_fraction(&mut self.cached.reader, &self.field.points, vertex, marks) } else { 0.0 }
    }

    /// Estimates the visibility of each light from the points of D_y; points that are still empty are marked. The field
    /// must have been made for a method that keeps lights one by one.
    #[inline(always)]
    pub(crate) fn read_lights(&mut self, vertex: &ShadingPoint, marks: &Marks) -> LightsReading {
        // Find the corners.
        if !self.cached.reader.reads_cells() {
            return self.read_points_by_light(vertex, marks);
        }
        let visible = match self.cached.reader.corners(vertex, marks) {
            Ok(visible) => visible,
            Err(ReadResult::Pending) => return LightsReading::Pending,
            Err(_) => return self.unknown(vertex),
        };
        if visible.refined > 0.0 {
            return self.read_points_by_light(vertex, marks);
        }
        self.enter_region(vertex);
        let Self { field, cached, estimate, region, rows, .. } = self;
        let reader = &cached.reader;

        // Lights beyond corners that are missing are beyond what hides these.
        (estimate.occluder_direction, estimate.near_occluder) =
            (reader.towards_missing(vertex), reader.has_near_occluder());

        // Estimate from the corners' states.
        let DirectEncoding::PerLight(PerLight { states, .. }) = &field.encoding else { return LightsReading::Nothing };
        let corners = CellCorners { visit: reader.visits(), mask: visible.mask };
        match (states, region) {
            (LightStates::Bits(bits), _) => {
                estimate.set_corners(bits, corners, &visible.weights, |k| reader.index(k));
            }
            (LightStates::Runs(runs), Some(region)) => {
                if !estimate.is_from(corners) {
                    for k in corners_of(visible.mask) {
                        rows[k] = region.row(runs, reader.index(k));
                    }
                }
                estimate.set_corners(region.bits(), corners, &visible.weights, |k| rows[k]);
            }
            (LightStates::Runs(_), None) => return LightsReading::Nothing,
        }
        LightsReading::Known
    }

    /// [`Self::read_lights`] point by point.
    #[cold]
    fn read_points_by_light(&mut self, vertex: &ShadingPoint, marks: &Marks) -> LightsReading {
        // List the points.
        let mut points = Vec::new();
        match self.cached.reader.read(vertex, marks, |index, weight| points.push((index, weight))) {
            ReadResult::Value => {}
            ReadResult::Unavailable => return self.unknown(vertex),
            ReadResult::Pending => return LightsReading::Pending,
        }

        // Estimate from their states.
        self.enter_region(vertex);
        let Self { field, cached, estimate, region, .. } = self;
        let reader = &cached.reader;
        (estimate.occluder_direction, estimate.near_occluder) =
            (reader.towards_missing(vertex), reader.has_near_occluder());
        let DirectEncoding::PerLight(PerLight { states, .. }) = &field.encoding else { return LightsReading::Nothing };
        match (states, region) {
            (LightStates::Bits(bits), _) => estimate.set_points(bits, &points),
            (LightStates::Runs(runs), Some(region)) => {
                for (point, _) in &mut points {
                    *point = region.row(runs, *point);
                }
                estimate.set_points(region.bits(), &points);
            }
            (LightStates::Runs(_), None) => return LightsReading::Nothing,
        }
        LightsReading::Known
    }

    /// Makes the estimate one of the lights of the vertex' region, where lights are clusters.
    #[inline(always)]
    fn enter_region(&mut self, vertex: &ShadingPoint) {
        if let Some(lanes) = self.region.as_mut().and_then(|region| region.enter(vertex.position)) {
            self.estimate.restart(lanes);
        }
    }

    /// Returns the reading of a vertex without a usable point.
    #[cold]
    fn unknown(&mut self, vertex: &ShadingPoint) -> LightsReading {
        if self.region.is_none() {
            return LightsReading::Nothing;
        }
        self.enter_region(vertex);
        self.estimate.clear();
        LightsReading::Unknown
    }

    /// Returns the lights that were read last, with their visibility estimate.
    #[inline(always)]
    pub(crate) fn lights(&self) -> LightCutVisibility<'_> {
        match &self.region {
            Some(region) => region.visibility(&self.estimate),
            None => LightCutVisibility { lights: self.samples, clusters: None, estimate: &self.estimate },
        }
    }
}
