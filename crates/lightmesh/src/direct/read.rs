//! Reading the direct field: formula (3g).

use glam::Vec3;

use super::encoding::{ArrivingLight, DirectEncoding};
use super::field::DirectField;
use super::region_visibility::RegionVisibility;
use super::visibility_estimate::VisibilityEstimate;
use crate::interaction::ShadingPoint;
use crate::light::{LightSamples, PARTS};
use crate::mesh::{CachedReader, CornerVisibility, Interpolator, Marks, ReadResult};
use crate::{MissingCorners, Scene};

/// The result of reading the direct mesh at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// The fraction of the unshadowed irradiance that arrives, per channel.
    Visibility(Vec3),
    /// No point of D_y can be used, or no light shines on any of them.
    Unavailable,
    /// Points are missing; they have been marked.
    Pending,
}

/// Reads the field vertex by vertex.
pub(crate) struct DirectReader<'a> {
    pub(super) field: &'a DirectField,
    pub(super) cached: CachedReader<'a, ArrivingLight>,
    /// Where parts of the lights are kept for themselves.
    parts: Option<CachedReader<'a, [ArrivingLight; PARTS]>>,
    /// The visibility of each light, by the points that were read last.
    pub(super) estimate: VisibilityEstimate,
    pub(super) samples: &'a LightSamples,
    /// Where lights are clusters.
    pub(super) region: Option<RegionVisibility<'a>>,
    /// By corner: the row that it has in `region`.
    pub(super) rows: [u32; 8],
}

impl DirectField {
    /// Returns a reader for one thread.
    pub(crate) fn reader<'a>(&'a self, scene: &'a Scene, visibility: CornerVisibility) -> DirectReader<'a> {
        let has_runs = self.encoding.runs().is_some();
        DirectReader {
            field: self,
            cached: CachedReader::new(self.points.reader(scene, visibility)),
            parts: self.has_parts().then(|| CachedReader::new(self.points.reader(scene, visibility))),
            estimate: VisibilityEstimate::new(if has_runs { 0 } else { scene.lights().lanes() }),
            samples: scene.lights(),
            region: match &self.encoding {
                DirectEncoding::PerLight(own) => RegionVisibility::new(scene.lights(), &self.lights, own.falloff),
                DirectEncoding::SixAxis(_) | DirectEncoding::Scalar(_) => None,
            },
            rows: [0; 8],
        }
    }
}

impl DirectReader<'_> {
    /// Returns Ĩ(y), formula (3g), over the `unshadowed` irradiance at y; points that are still empty are marked.
    #[inline(always)]
    pub(crate) fn read(&mut self, vertex: &ShadingPoint, unshadowed: Vec3, marks: &Marks) -> Reading {
        if let Interpolator::TrilinearWith(rule) = self.field.points.interpolator {
            return self.read_with(rule, vertex, marks);
        }
        let encoding = &self.field.encoding;
        let light = self.cached.fold(
            vertex,
            marks,
            ArrivingLight::default(),
            |index| encoding.project(index, vertex.n),
            ArrivingLight::plus,
        );
        match light {
            Ok(light) if matches!(encoding, DirectEncoding::SixAxis(_)) => moderate(light, unshadowed),
            Ok(light) => ratio(light),
            Err(ReadResult::Pending) => Reading::Pending,
            Err(_) => Reading::Unavailable,
        }
    }

    /// [`Self::read`] where parts of the lights are kept for themselves; `unshadowed` by each of them.
    pub(crate) fn read_parts(&mut self, vertex: &ShadingPoint, unshadowed: [Vec3; PARTS], marks: &Marks) -> Reading {
        let (Some(parts), encoding) = (&mut self.parts, &self.field.encoding) else { return Reading::Unavailable };
        let light = parts.fold(
            vertex,
            marks,
            [ArrivingLight::default(); PARTS],
            |index| encoding.project_parts(index, vertex.n),
            |sums, lights, weight| std::array::from_fn(|part| sums[part].plus(lights[part], weight)),
        );
        match light {
            Ok(light) => moderate_parts(light, unshadowed),
            Err(ReadResult::Pending) => Reading::Pending,
            Err(_) => Reading::Unavailable,
        }
    }

    /// [`Self::read`] with a rule for missing corners.
    fn read_with(&mut self, rule: MissingCorners, vertex: &ShadingPoint, marks: &Marks) -> Reading {
        let (mut light, mut share) = (ArrivingLight::default(), 0.0);
        let encoding = &self.field.encoding;
        let result = self.cached.reader.read(vertex, marks, |index, weight| {
            light = light.plus(encoding.project(index, vertex.n), weight);
            share += weight;
        });
        let reading = match result {
            ReadResult::Value => ratio(light),
            ReadResult::Unavailable => Reading::Unavailable,
            ReadResult::Pending => Reading::Pending,
        };
        with_missing(rule, share, reading)
    }

    /// Returns how many rays have been traced so far to find out which points vertices see.
    pub(crate) fn visibility_rays(&self) -> u64 {
        let parts = self.parts.as_ref().map_or(0, |parts| parts.reader.visibility_rays());
        self.cached.reader.visibility_rays() + parts
    }
}

/// Adds the missing corners to a reading of corners whose weights have the sum `share`: by the rule they count as
/// visibility 0 or 1, or their weight is among the others' already.
fn with_missing(rule: MissingCorners, share: f32, reading: Reading) -> Reading {
    let missing = match rule {
        MissingCorners::Zero => Vec3::ZERO,
        MissingCorners::One => Vec3::ONE,
        MissingCorners::Nearest | MissingCorners::Mirror => return reading,
    };
    match reading {
        Reading::Visibility(visibility) => Reading::Visibility(missing.lerp(visibility, share)),
        Reading::Unavailable if share == 0.0 => Reading::Visibility(missing),
        // There are corners, but no light reaches them; or points are to be filled first.
        Reading::Unavailable | Reading::Pending => reading,
    }
}

/// Returns the part of the `unshadowed` light at a surface that arrives, from the light V that arrives at mesh points and
/// their unshadowed light U: [`ratio`] V / U where most of it arrives.
///
/// That is V + r (unshadowed − U), r = V / U: V, corrected by how much more light there would be at the surface than at
/// the points. Where most light is blocked, the correction is that of light that does not arrive: sunlight outside darkened
/// a slanted roof to a sixth inside. If the two parts are independent, r² / (r² + (1 − r)²) in place of r is right; it is
/// less than r where r is below 1/2, and there it is taken.
fn moderate(light: ArrivingLight, unshadowed: Vec3) -> Reading {
    let whole = ratio(light);
    let Reading::Visibility(r) = whole else { return whole };
    if r.min_element() >= 0.5 {
        return whole;
    }
    let weight = light.visible.w.max(f32::MIN_POSITIVE);
    let (v, u) = (light.visible.truncate() / weight, light.unshadowed.truncate() / weight);
    let moderated = v + r * r / (r * r + (1.0 - r) * (1.0 - r)) * (unshadowed - u);
    let part = moderated / unshadowed.max(Vec3::splat(f32::MIN_POSITIVE));
    Reading::Visibility(Vec3::select(r.cmplt(Vec3::splat(0.5)) & unshadowed.cmpgt(Vec3::ZERO), part, r))
}

/// Returns the part of the light that arrives, from each part of the lights by itself.
fn moderate_parts(light: [ArrivingLight; PARTS], unshadowed: [Vec3; PARTS]) -> Reading {
    let mut arriving = Vec3::ZERO;
    for (light, unshadowed) in light.into_iter().zip(unshadowed) {
        match moderate(light, unshadowed) {
            Reading::Visibility(visibility) => arriving += visibility * unshadowed,
            // Such light must have come to the points.
            Reading::Unavailable if unshadowed != Vec3::ZERO => return Reading::Unavailable,
            Reading::Unavailable | Reading::Pending => {}
        }
    }
    let all: Vec3 = unshadowed.into_iter().sum();
    Reading::Visibility(arriving / all.max(Vec3::splat(f32::MIN_POSITIVE)))
}

/// Returns the part of the light that arrives.
fn ratio(light: ArrivingLight) -> Reading {
    let (visible, unshadowed) = (light.visible.truncate(), light.unshadowed.truncate());
    let sum = unshadowed.element_sum();
    if sum <= 0.0 {
        return Reading::Unavailable;
    }
    // A channel without light gets the mean of the others.
    let otherwise = Vec3::splat(visible.element_sum() / sum);
    let ratio = visible / unshadowed.max(Vec3::splat(f32::MIN_POSITIVE));
    Reading::Visibility(Vec3::select(unshadowed.cmpgt(Vec3::ZERO), ratio, otherwise))
}
