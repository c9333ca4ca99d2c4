//! Reading the direct field: formula (3g).

use glam::{Vec3, Vec4};

use super::field::{DirectEncoding, DirectField};
use super::read_lights::LightsReading;
use super::region_visibility::RegionVisibility;
use super::visibility_estimate::VisibilityEstimate;
use crate::interaction::ShadingPoint;
use crate::light::LightSamples;
use crate::mesh::{
    CornerValues, CornerVisibility, Interpolator, Marks, ReadResult, Reader, set_bits as corners_of, usable_fraction,
};
use crate::{MissingCorners, Scene};

/// What a vertex finds in the direct mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// The fraction of the unshadowed irradiance that arrives, per channel.
    Visibility(Vec3),
    /// No point of the neighbourhood can be used, or none knows of any light.
    Unavailable,
    /// Points are missing; they have been marked.
    Pending,
}

/// Reads the field vertex by vertex. Neighbouring vertices mostly share cell and normal: what the corners know about surfaces of
/// that normal is kept.
pub(crate) struct DirectReader<'a> {
    pub(super) field: &'a DirectField,
    pub(super) reader: Reader<'a>,
    pub(super) known: CornerValues,
    /// By corner, summed over the axes that the normal faces; 0 where it is not known.
    pub(super) visible: [Vec4; 8],
    pub(super) all: [Vec4; 8],
    /// What the points that were read last know of each light.
    pub(super) estimate: VisibilityEstimate,
    pub(super) samples: &'a LightSamples,
    /// Where lights are clusters.
    pub(super) near: Option<RegionVisibility<'a>>,
    /// By corner: where `near` has what it says.
    pub(super) rows: [u32; 8],
}

impl DirectField {
    /// A reader for one thread.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, sight: CornerVisibility) -> DirectReader<'a> {
        DirectReader {
            field: self,
            reader: self.points.reader(scene, sight),
            known: CornerValues::default(),
            visible: [Vec4::ZERO; 8],
            all: [Vec4::ZERO; 8],
            estimate: VisibilityEstimate::new(if self.runs.is_some() { 0 } else { scene.lights().lanes() }),
            samples: scene.lights(),
            near: match self.encoding {
                DirectEncoding::PerLight { falloff } => RegionVisibility::new(&self.lights, falloff),
                DirectEncoding::SixAxis { .. } | DirectEncoding::Scalar { .. } => None,
            },
            rows: [0; 8],
        }
    }
}

impl DirectReader<'_> {
    /// Ĩ(y), formula (3g); points that are still empty are marked.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &ShadingPoint, marks: &Marks) -> Reading {
        let (mut visible, mut all) = (Vec4::ZERO, Vec4::ZERO);
        if !self.reader.reads_cells() {
            return self.read_points(vertex, marks);
        }
        let seen = match self.reader.corners(vertex, marks) {
            Ok(seen) => seen,
            Err(ReadResult::Pending) => return Reading::Pending,
            Err(_) => return Reading::Unavailable,
        };
        if seen.refined > 0.0 {
            return self.read_points(vertex, marks);
        }
        if !self.known.continues(vertex.n, self.reader.visits()) {
            // A curved surface: the next vertex has another normal.
            for k in corners_of(seen.mask) {
                let (v, a) = self.field.project(self.reader.index(k), vertex.n);
                let weight = seen.weights[k / 4][k % 4];
                visible += v * weight;
                all += a * weight;
            }
            return ratio(visible.truncate(), all.truncate());
        }
        self.know(seen.mask, vertex.n);
        // All eight: a corner that is not seen has no weight.
        for (z, weights) in seen.weights.iter().enumerate() {
            let corners = self.visible[4 * z..].iter().zip(&self.all[4 * z..]);
            for ((v, a), weight) in corners.zip(weights.to_array()) {
                visible += v * weight;
                all += a * weight;
            }
        }
        ratio(visible.truncate(), all.truncate())
    }

    /// The same, point by point.
    fn read_points(&mut self, vertex: &ShadingPoint, marks: &Marks) -> Reading {
        let (mut visible, mut all, mut total) = (Vec4::ZERO, Vec4::ZERO, 0.0);
        let outcome = self.reader.read(vertex, marks, |index, weight| {
            let point = self.field.project(index, vertex.n);
            visible += point.0 * weight;
            all += point.1 * weight;
            total += weight;
        });
        let reading = match outcome {
            ReadResult::Value => ratio(visible.truncate(), all.truncate()),
            ReadResult::Unavailable => Reading::Unavailable,
            ReadResult::Pending => Reading::Pending,
        };
        match self.field.points.neighbourhood {
            Interpolator::TrilinearWith(rule) => with_missing(rule, total, reading),
            _ => reading,
        }
    }

    /// The part, by weight, of the points of D_y that the vertex can use, in [0, 1]; all of them have been evaluated. 0
    /// where [`DirectReader::read`] finds nothing.
    pub(crate) fn usable_fraction(&mut self, vertex: &ShadingPoint, marks: &Marks) -> f32 {
        let reads = match self.field.encoding {
            DirectEncoding::PerLight { .. } => self.read_lights(vertex, marks) == LightsReading::Known,
            _ => matches!(self.read(vertex, marks), Reading::Visibility(_)),
        };
        if reads { usable_fraction(&mut self.reader, &self.field.points, vertex, marks) } else { 0.0 }
    }

    /// Sums up the corners of `mask` for the normal, those that are not known yet.
    #[inline(always)]
    fn know(&mut self, mask: u8, n: Vec3) {
        if self.known.is_empty() {
            (self.visible, self.all) = ([Vec4::ZERO; 8], [Vec4::ZERO; 8]);
        }
        for k in self.known.add(mask) {
            (self.visible[k], self.all[k]) = self.field.project(self.reader.index(k), n);
        }
    }

    /// Rays shot so far to find out which points vertices see.
    pub(crate) fn visibility_rays(&self) -> u64 {
        self.reader.visibility_rays()
    }
}

/// What a rule makes of a reading of corners whose weights have the sum `share`: missing ones count as visibility 0 or 1, or their
/// weight is among the others' already.
fn with_missing(rule: MissingCorners, share: f32, reading: Reading) -> Reading {
    let missing = match rule {
        MissingCorners::Zero => Vec3::ZERO,
        MissingCorners::One => Vec3::ONE,
        MissingCorners::Nearest | MissingCorners::Mirror => return reading,
    };
    match reading {
        Reading::Visibility(seen) => Reading::Visibility(missing.lerp(seen, share)),
        Reading::Unavailable if share == 0.0 => Reading::Visibility(missing),
        // Corners are there, but no light reaches them; or points are to be filled first.
        Reading::Unavailable | Reading::Pending => reading,
    }
}

/// The part of the light that arrives.
fn ratio(visible: Vec3, all: Vec3) -> Reading {
    let sum = all.element_sum();
    if sum <= 0.0 {
        return Reading::Unavailable;
    }
    // A channel without light takes what the others say.
    let otherwise = Vec3::splat(visible.element_sum() / sum);
    let ratio = visible / all.max(Vec3::splat(f32::MIN_POSITIVE));
    Reading::Visibility(Vec3::select(all.cmpgt(Vec3::ZERO), ratio, otherwise))
}
