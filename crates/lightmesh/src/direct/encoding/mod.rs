//! What a point of the direct mesh keeps of its light: one file per representation.
//!
//! Each file has the layout of its values, how a point is evaluated, what a surface reads from it, and its memory, and
//! how values become plain arrays and back. A new representation is one more file, a variant of each of the three enums
//! here, and the arms that the compiler then misses.

mod per_light;
mod plain_arrays;
mod scalar;
mod six_axis;

use glam::{Vec3, Vec4};
use per_light::PointStates;
pub(crate) use per_light::{BitRows, LightBits, LightRuns, LightStates, MOST_LEAVES, PerLight};
pub(crate) use plain_arrays::{check_finite, check_length, refuse, values};
use scalar::Scalar;
use six_axis::{SixAxis, SixAxisValues};

use super::point_lights::PointLights;
use crate::light::PARTS;
use crate::options::PointKind;
use crate::{Error, Falloff, MeshKey, RenderOptions, Scene};

/// The values of all points of a direct mesh, in the representation that its method reads.
#[derive(Debug)]
pub(crate) enum DirectEncoding {
    /// Visible and unshadowed light on each face of an ambient cube.
    SixAxis(SixAxis),
    /// The paper's DirectLight(x), and what it is divided by.
    Scalar(Scalar),
    /// The state of every single light.
    PerLight(PerLight),
}

/// The values of one point that has been evaluated and not yet stored.
#[derive(Debug)]
pub(super) enum PointValues {
    SixAxis(Box<SixAxisValues>),
    Scalar([Vec4; 2]),
    PerLight(PointStates),
}

impl PointValues {
    /// Returns the number of the point's runs, where points keep runs.
    pub(super) fn run_count(&self) -> Option<usize> {
        match self {
            Self::PerLight(PointStates::Runs(runs)) => Some(runs.len()),
            Self::SixAxis(_) | Self::Scalar(_) | Self::PerLight(PointStates::Bits(_)) => None,
        }
    }
}

/// The direct light values of some mesh points as plain arrays; N is the number of points. The variant depends on the
/// render method.
#[derive(Clone, Debug, PartialEq)]
pub enum DirectValues {
    /// [`Method::Mesh`](crate::options::Method::Mesh): shape (N, 6, 2, 3), lux. For each point and each plane that
    /// faces +x, −x, +y, −y, +z, −z: the irradiance that arrives, and the irradiance without occlusion, RGB. (With a
    /// falloff other than r², in its units.)
    SixAxis(Vec<f32>),
    /// The same where there are suns, or lamps and a sky: shape (N, 3, 6, 2, 3), lights at finite distances, the sky, and
    /// suns.
    SixAxisParts(Vec<f32>),
    /// [`Method::Paper`](crate::options::Method::Paper): shape (N, 2, 3). For each point DirectLight of formula (1),
    /// and the value that it is divided by, RGB.
    Scalar(Vec<f32>),
    /// The visibility of each single light, one bit per light in two rows, the lowest bit first. Both bits set: all of
    /// the light arrives. Neither: none of it. Only the bit of the second row: some of it, or the visibility is unknown
    /// because the light does not shine on the point.
    Lights {
        /// W, the number of words in a row.
        words: u32,
        /// Shape (N, 2, W).
        bits: Vec<u64>,
    },
    /// The visibility of lights in clusters. Each point has a list of runs over the leaves of the light tree. A run is
    /// the number `leaf · 4 + state`; its state holds from that leaf to the next run, and the first run starts at leaf
    /// 0. State 0: unknown, 1: none of the light arrives, 2: all of it.
    Runs {
        /// For each point, the end of its runs in `runs`.
        ends: Vec<u64>,
        /// All runs, point after point.
        runs: Vec<u32>,
    },
}

/// What reaches a surface from a mesh point, or from several: RGB, and the weight of the points or 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ArrivingLight {
    pub visible: Vec4,
    /// What would arrive if nothing were in the way.
    pub unshadowed: Vec4,
}

impl ArrivingLight {
    /// Returns the sum with `weight` times another point's light.
    #[inline(always)]
    pub(super) fn plus(self, other: Self, weight: f32) -> Self {
        Self { visible: self.visible + other.visible * weight, unshadowed: self.unshadowed + other.unshadowed * weight }
    }
}

impl DirectEncoding {
    /// Returns the encoding that a method reads, without points. Where lights are clusters, `cluster_leaves` is the
    /// number of leaves of their tree.
    pub(super) fn new(scene: &Scene, cluster_leaves: Option<u32>, options: &RenderOptions) -> Self {
        let falloff = options.transport.falloff;
        match MeshKey::of(options).kind {
            PointKind::ByLight => Self::PerLight(PerLight::new(scene, cluster_leaves, falloff)),
            PointKind::Scalar { field_falloff, scale } => Self::Scalar(Scalar::new(scene, field_falloff, scale)),
            PointKind::SixAxis => {
                let has_parts = cluster_leaves.is_none() && scene.lights().has_parts();
                Self::SixAxis(SixAxis::new(falloff, has_parts))
            }
        }
    }

    /// Returns the falloff by which lights shine on a point.
    pub(super) fn falloff(&self) -> Falloff {
        match self {
            Self::SixAxis(own) => own.falloff,
            Self::Scalar(own) => own.falloff,
            Self::PerLight(own) => own.falloff,
        }
    }

    /// Returns whether points inside solids are to be found and left out.
    pub(super) fn needs_probes(&self) -> bool {
        match self {
            Self::Scalar(own) => own.needs_probes(),
            Self::SixAxis(_) | Self::PerLight(_) => true,
        }
    }

    /// Whether points keep sums over the lights.
    pub(super) fn sums_lights(&self) -> bool {
        matches!(self, Self::SixAxis(_) | Self::Scalar(_))
    }

    /// Returns the values of the point whose lights have been traced.
    pub(super) fn evaluate(&self, lights: &PointLights<'_>) -> PointValues {
        match self {
            Self::SixAxis(own) => PointValues::SixAxis(Box::new(own.evaluate(lights))),
            Self::Scalar(own) => PointValues::Scalar(own.evaluate(lights)),
            Self::PerLight(own) => PointValues::PerLight(own.evaluate(lights)),
        }
    }

    /// Stores the values of the next point.
    pub(super) fn push(&mut self, values: &PointValues) {
        match (self, values) {
            (Self::SixAxis(own), PointValues::SixAxis(values)) => own.push(values),
            (Self::Scalar(own), PointValues::Scalar(values)) => own.push(values),
            (Self::PerLight(own), PointValues::PerLight(states)) => own.push(states),
            _ => unreachable!("points are evaluated and stored by one encoding"),
        }
    }

    /// Returns the light of a point on a surface of normal `n`; none where lights are kept one by one.
    #[inline(always)]
    pub(super) fn project(&self, index: u32, n: Vec3) -> ArrivingLight {
        match self {
            Self::SixAxis(own) => own.project(index, n),
            Self::Scalar(own) => own.project(index),
            Self::PerLight(_) => ArrivingLight::default(),
        }
    }

    /// [`Self::project`] of each part of the lights, where parts are kept for themselves.
    #[inline(always)]
    pub(super) fn project_parts(&self, index: u32, n: Vec3) -> [ArrivingLight; PARTS] {
        match self {
            Self::SixAxis(own) => own.project_parts(index, n),
            Self::Scalar(_) | Self::PerLight(_) => [ArrivingLight::default(); PARTS],
        }
    }

    /// Whether parts of the lights are kept for themselves.
    pub(super) fn has_parts(&self) -> bool {
        matches!(self, Self::SixAxis(own) if own.has_parts())
    }

    /// Returns the memory of a point, bytes, as far as it is the same for all points.
    pub(super) fn bytes_per_point(&self) -> u64 {
        match self {
            Self::SixAxis(own) => own.bytes_per_point(),
            Self::Scalar(_) => Scalar::BYTES_PER_POINT,
            Self::PerLight(own) => own.bytes_per_point(),
        }
    }

    /// Returns the memory of all points, bytes.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::SixAxis(own) => own.bytes(),
            Self::Scalar(own) => own.bytes(),
            Self::PerLight(own) => own.bytes(),
        }
    }

    /// Returns the runs, where points keep runs: how many a point has shows only when it has been evaluated.
    pub(super) fn runs(&self) -> Option<&LightRuns> {
        match self {
            Self::PerLight(PerLight { states: LightStates::Runs(runs), .. }) => Some(runs),
            Self::SixAxis(_) | Self::Scalar(_) | Self::PerLight(_) => None,
        }
    }

    /// Copies the values of some points.
    pub(crate) fn snapshot(&self, indices: impl Iterator<Item = u32>) -> DirectValues {
        match self {
            Self::SixAxis(own) => own.snapshot(indices),
            Self::Scalar(own) => own.snapshot(indices),
            Self::PerLight(own) => own.snapshot(indices),
        }
    }

    /// Refuses what cannot be the values of this number of points of this mesh.
    ///
    /// # Errors
    /// [`Error::InvalidContents`].
    pub(crate) fn check(&self, values: &DirectValues, points: usize) -> Result<(), Error> {
        let name = match (self, values) {
            (Self::SixAxis(own), DirectValues::SixAxis(numbers)) if !own.has_parts() => {
                return own.check(numbers, points);
            }
            (Self::SixAxis(own), DirectValues::SixAxisParts(numbers)) if own.has_parts() => {
                return own.check(numbers, points);
            }
            (Self::Scalar(_), DirectValues::Scalar(numbers)) => return Scalar::check(numbers, points),
            (Self::PerLight(own), _) => return own.check(values, points),
            (Self::SixAxis(_), _) => SixAxis::NAME,
            (Self::Scalar(_), _) => Scalar::NAME,
        };
        refuse("direct values", format!("are of another method; this mesh keeps {name}"))
    }

    /// Stores point i of a snapshot, which has been checked, as the next one.
    pub(crate) fn push_snapshot(&mut self, values: &DirectValues, i: usize) {
        match (self, values) {
            (Self::SixAxis(own), DirectValues::SixAxis(numbers) | DirectValues::SixAxisParts(numbers)) => {
                own.push_snapshot(numbers, i);
            }
            (Self::Scalar(own), DirectValues::Scalar(numbers)) => own.push_snapshot(numbers, i),
            (Self::PerLight(own), _) => own.push_snapshot(values, i),
            _ => unreachable!("snapshots are checked before"),
        }
    }
}
