//! The statistics of a node's lights: means and mean deviations.

use glam::{DVec3, Vec3};

use super::super::sample::{LightEmission, RangeWindow, SampledLight, SpotCone};
use super::build::Leaf;
use super::{ConeStatistics, Extremes, HalfAngle, Kind, Node, Orientation};

/// Sums over leaves, in order, in double precision.
fn sum<T: std::iter::Sum>(leaves: &[Leaf], of: impl Fn(&Leaf) -> T) -> T {
    leaves.iter().map(of).sum()
}

fn position(leaf: &Leaf) -> DVec3 {
    leaf.light.position.as_dvec3()
}

/// The intensity of a leaf in each channel.
const CHANNELS: [fn(&Leaf) -> f64; 3] = [
    |leaf| f64::from(leaf.light.intensity.x),
    |leaf| f64::from(leaf.light.intensity.y),
    |leaf| f64::from(leaf.light.intensity.z),
];

/// Rounds a root or a sum up, so that bounds stay bounds.
fn up(x: f64) -> f32 {
    (x * (1.0 + 1e-6)) as f32
}

impl Node {
    /// Makes the node of some leaves, and the light that represents them, of which position and intensity are final.
    pub(crate) fn new(kind: Kind, leaves: &[Leaf], first: u32) -> (Self, SampledLight) {
        let strength = sum(leaves, |leaf| f64::from(leaf.strength()));
        let mean = sum(leaves, |leaf| position(leaf) * f64::from(leaf.strength())) / strength;
        let extremes = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (min, max) = leaves
            .iter()
            .fold(extremes, |(min, max), leaf| (min.min(leaf.light.position), max.max(leaf.light.position)));
        let mut node = Self {
            min,
            max,
            mean: mean.as_vec3(),
            strength: strength as f32,
            variance: 0.0,
            chromatic_error: 0.0,
            child: 0,
            first,
            count: leaves.len() as u32,
            kind,
        };
        let mut representative = leaves[0].light;
        if leaves.len() == 1 {
            node.mean = representative.position;
            return (node, representative);
        }
        if kind == Kind::Directional {
            // Along its direction a cluster is exact. The error is the light of each channel across it, and that of
            // lights which face a surface whose back the cluster faces: 1 − |mean| (`bound.rs`).
            let axis = mean.normalize_or(position(&leaves[0]));
            let sums = CHANNELS.map(|channel| sum(leaves, |leaf| position(leaf) * channel(leaf)));
            let lost = CHANNELS.iter().zip(sums).map(|(channel, across)| {
                sum(leaves, channel) - across.length() + (across - axis * across.dot(axis).max(0.0)).length()
            });
            node.chromatic_error = up(lost.sum());
            representative.position = axis.as_vec3();
            representative.intensity = DVec3::from_array(sums.map(|across| across.dot(axis).max(0.0))).as_vec3();
            node.mean = representative.position;
            return (node, representative);
        }
        // Sum the deviations from the mean: of positions, and of each channel's own mean.
        let mean = node.mean.as_dvec3();
        node.variance =
            up(sum(leaves, |leaf| position(leaf).distance_squared(mean) * f64::from(leaf.strength())) / strength);
        let off = |channel: fn(&Leaf) -> f64| sum(leaves, |leaf| (position(leaf) - mean) * channel(leaf)).length();
        node.chromatic_error = up(CHANNELS.map(off).iter().sum());
        representative.position = node.mean;
        representative.intensity = DVec3::from_array(CHANNELS.map(|channel| sum(leaves, channel))).as_vec3();
        (node, representative)
    }
}

/// Returns the orientation of some leaves, and their representative with its final emission; `None` where the kind has
/// no axes.
pub(super) fn orientation(
    kind: Kind,
    leaves: &[Leaf],
    representative: &SampledLight,
) -> Option<(Orientation, SampledLight)> {
    if matches!(kind, Kind::Isotropic | Kind::Directional) {
        return None;
    }
    let axis = |leaf: &Leaf| leaf.axis().as_dvec3();
    let strength = sum(leaves, |leaf| f64::from(leaf.strength()));
    // Bound the axes by a cone about their mean.
    let mean = sum(leaves, |leaf| axis(leaf) * f64::from(leaf.strength())) / strength;
    let unit = mean.normalize_or(axis(&leaves[0]));
    let cos = leaves.iter().map(|leaf| axis(leaf).dot(unit)).fold(1.0, f64::min);
    // A point with a range alone has no axis: its cone is the whole sphere.
    let sin = up((1.0 - cos * cos).max(0.0).sqrt()).min(1.0);
    let cone = if unit == DVec3::ZERO { HalfAngle { cos: -1.0, sin: 0.0 } } else { HalfAngle { cos: cos as f32, sin } };
    // Average the emissions, and collect their extremes.
    let sums = CHANNELS.map(|channel| sum(leaves, |leaf| axis(leaf) * channel(leaf)));
    let mut representative = *representative;
    let mut shines = unit;
    let (statistics, center, chromatic_error) = match (representative.emission, leaves.len()) {
        (LightEmission::Patch { back, .. }, _) => {
            let area_over_pi = |leaf: &Leaf| match leaf.light.emission {
                LightEmission::Patch { area_over_pi, .. } => area_over_pi,
                _ => 0.0,
            };
            let none = Extremes { least: f32::INFINITY, most: 0.0 };
            let areas = leaves
                .iter()
                .map(area_over_pi)
                .fold(none, |areas, a| Extremes { least: areas.least.min(a), most: areas.most.max(a) });
            if leaves.len() > 1 {
                // Light that a patch sends somewhere is linear in its intensity times its normal.
                let intensity = sums.map(|along| along.dot(unit).max(0.0));
                representative.intensity = DVec3::from_array(intensity).as_vec3();
                let mean = sum(leaves, |leaf| f64::from(area_over_pi(leaf)) * f64::from(leaf.strength())) / strength;
                representative.emission =
                    LightEmission::Patch { normal: unit.as_vec3(), back, area_over_pi: mean as f32 };
            }
            let lost = sums.map(|along| (along - unit * along.dot(unit).max(0.0)).length());
            (ConeStatistics::Patch { area_over_pi: areas }, mean, lost.iter().sum())
        }
        (_, count) => {
            let spots = leaves.iter().map(|leaf| spot(&leaf.light.emission));
            let (least, most) = spots.fold(([f32::INFINITY; 5], [f32::NEG_INFINITY; 5]), |(least, most), s| {
                (std::array::from_fn(|i| s[i].min(least[i])), std::array::from_fn(|i| s[i].max(most[i])))
            });
            let [inner, outer, scale, offset, inv_range2] =
                std::array::from_fn(|i| Extremes { least: least[i], most: most[i] });
            if count > 1 {
                let mean = |i: usize| {
                    let of = |leaf: &Leaf| f64::from(spot(&leaf.light.emission)[i]) * f64::from(leaf.strength());
                    (sum(leaves, of) / strength) as f32
                };
                representative.emission = LightEmission::Spot {
                    cone: SpotCone { axis: unit.as_vec3(), scale: mean(2), offset: mean(3) },
                    window: RangeWindow { inv_range2: mean(4) },
                };
            }
            shines = -unit;
            let difference = scale.width() + offset.width();
            let off = |channel: fn(&Leaf) -> f64| sum(leaves, |leaf| (axis(leaf) - unit) * channel(leaf)).length();
            let statistics =
                ConeStatistics::Spot { inner, outer: outer.least, scale: scale.most, difference, inv_range2 };
            (statistics, unit, CHANNELS.map(off).iter().sum())
        }
    };
    let square = sum(leaves, |leaf| axis(leaf).distance_squared(center) * f64::from(leaf.strength())) / strength;
    let orientation = Orientation {
        axis: shines.as_vec3(),
        cone,
        deviation: up(square.sqrt()),
        chromatic_error: up(chromatic_error),
        statistics,
    };
    Some((orientation, representative))
}

/// Returns the cosines of a cone's inner and outer edge (−2 without a cone), its scale and offset, and 1 / R².
fn spot(emission: &LightEmission) -> [f32; 5] {
    match *emission {
        LightEmission::Spot { cone: SpotCone { scale, offset, .. }, window } if scale > 0.0 => {
            [(1.0 - offset) / scale, -offset / scale, scale, offset, window.inv_range2]
        }
        LightEmission::Spot { window, .. } => [-2.0, -2.0, 0.0, 1.0, window.inv_range2],
        _ => [-2.0, -2.0, 0.0, 1.0, 0.0],
    }
}
