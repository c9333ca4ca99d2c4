//! The state of every single light at a mesh point: all of it arrives, none of it, or something else.
//!
//! Few lights are kept as [`bits`], two per light; where lights are clusters of a tree, as [`runs`] of its leaves.
//! Readers turn the states of the points around a surface into a visibility estimate for each light.

mod bits;
mod runs;

pub(crate) use bits::{BitRows, LightBits};
use glam::Vec3;
pub(crate) use runs::{LightRuns, MOST_LEAVES};

use super::super::point_lights::PointLights;
use super::super::region_cuts::RegionCuts;
use super::DirectValues;
use super::plain_arrays::refuse;
use crate::{Error, Falloff, Scene};

/// The state of a light at a mesh point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightState {
    /// Some of it arrives, or the light does not shine on the point.
    Unknown = 0,
    /// Nothing arrives.
    Occluded = 1,
    /// All of it arrives.
    Visible = 2,
}

impl LightState {
    /// Returns the state of a light of which the part `v` arrives, per channel.
    fn of_visibility(v: Vec3) -> Self {
        if v == Vec3::ONE {
            Self::Visible
        } else if v == Vec3::ZERO {
            Self::Occluded
        } else {
            Self::Unknown
        }
    }
}

/// The states of the lights at all points.
#[derive(Debug)]
pub(crate) struct PerLight {
    /// φ3: which lights shine on a point at all.
    pub(crate) falloff: Falloff,
    pub(crate) states: LightStates,
}

/// The two layouts of the states.
#[derive(Debug)]
pub(crate) enum LightStates {
    /// Of single lights.
    Bits(LightBits),
    /// Of clusters.
    Runs(LightRuns),
}

/// The states at one point.
#[derive(Debug)]
pub(crate) enum PointStates {
    Bits(Vec<u64>),
    Runs(Vec<u32>),
}

impl PerLight {
    /// No points; bits or runs by the lights that there are.
    pub(super) fn new(scene: &Scene, lights: &RegionCuts, falloff: Falloff) -> Self {
        let states = match lights.has_clusters() {
            true => LightStates::Runs(LightRuns::new(lights.leaf_count())),
            false => LightStates::Bits(LightBits::of_scene(scene.lights())),
        };
        Self { falloff, states }
    }

    /// Returns what the encoding keeps, for messages.
    pub(super) fn name(&self) -> &'static str {
        match self.states {
            LightStates::Bits(_) => "single lights",
            LightStates::Runs(_) => "clusters of lights",
        }
    }

    /// Returns the states of the lights at a point.
    pub(super) fn evaluate(&self, lights: &PointLights<'_>) -> PointStates {
        match &self.states {
            LightStates::Bits(bits) => PointStates::Bits(bits.pack(lights.lanes(), lights.visible())),
            LightStates::Runs(_) => PointStates::Runs(LightRuns::evaluate(lights)),
        }
    }

    /// Stores the states of the next point.
    pub(super) fn push(&mut self, states: &PointStates) {
        match (&mut self.states, states) {
            (LightStates::Bits(bits), PointStates::Bits(point)) => bits.push(point),
            (LightStates::Runs(runs), PointStates::Runs(point)) => runs.push(point),
            _ => unreachable!("points are evaluated and stored in one layout"),
        }
    }

    /// Returns the memory of a point, bytes, as far as it is the same for all points.
    pub(super) fn bytes_per_point(&self) -> u64 {
        match &self.states {
            LightStates::Bits(bits) => bits.bytes_per_point(),
            LightStates::Runs(_) => 0,
        }
    }

    /// Returns the memory of all points, bytes.
    pub(super) fn bytes(&self) -> u64 {
        match &self.states {
            LightStates::Bits(bits) => bits.bytes(),
            LightStates::Runs(runs) => runs.bytes(),
        }
    }

    /// Copies the states at some points.
    pub(super) fn snapshot(&self, indices: impl Iterator<Item = u32>) -> DirectValues {
        match &self.states {
            LightStates::Bits(bits) => bits.snapshot(indices),
            LightStates::Runs(runs) => runs.snapshot(indices),
        }
    }

    /// Refuses what cannot be the states at this number of points.
    pub(super) fn check(&self, values: &DirectValues, points: usize) -> Result<(), Error> {
        match (&self.states, values) {
            (LightStates::Bits(own), DirectValues::Lights { words, bits }) => own.check(*words as usize, bits, points),
            (LightStates::Runs(own), DirectValues::Runs { ends, runs }) => own.check(ends, runs, points),
            _ => refuse("direct values", format!("are of another method; this mesh keeps {}", self.name())),
        }
    }

    /// Stores point i of a snapshot, which has been checked, as the next one.
    pub(super) fn push_snapshot(&mut self, values: &DirectValues, i: usize) {
        match (&mut self.states, values) {
            (LightStates::Bits(own), DirectValues::Lights { bits, .. }) => own.push_snapshot(bits, i),
            (LightStates::Runs(own), DirectValues::Runs { ends, runs }) => own.push(runs::of_point(ends, runs, i)),
            _ => unreachable!("snapshots are checked before"),
        }
    }
}
