//! What a node knows of its lights: means and mean deviations.

use glam::{DVec3, Vec3};

use super::super::sample::{LightEmission, RangeWindow, SampledLight, SpotCone};
use super::build::Leaf;
use super::{ConeStatistics, Kind, Node, Orientation};

/// Sums over leaves, in order, in double precision.
fn sum<T: std::iter::Sum>(leaves: &[Leaf], of: impl Fn(&Leaf) -> T) -> T {
    leaves.iter().map(of).sum()
}

fn position(leaf: &Leaf) -> DVec3 {
    leaf.light.position.as_dvec3()
}

/// By channel: its intensity of a leaf.
const CHANNELS: [fn(&Leaf) -> f64; 3] = [
    |leaf| f64::from(leaf.light.intensity.x),
    |leaf| f64::from(leaf.light.intensity.y),
    |leaf| f64::from(leaf.light.intensity.z),
];

/// A rounded up root or sum: bounds stay bounds.
fn up(x: f64) -> f32 {
    (x * (1.0 + 1e-6)) as f32
}

impl Node {
    /// The node of some leaves, and what stands for them as far as place and intensity go.
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
            // Along one direction a cluster is exact; what is lost is what channels bring across it, and where lights face a
            // surface of which the cluster sees the back: 1 − |mean| (`bound.rs`).
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

/// Which way leaves of a kind shine, and the light for them all; `None` where the kind has no axes.
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
    let mean = sum(leaves, |leaf| axis(leaf) * f64::from(leaf.strength())) / strength;
    let unit = mean.normalize_or(axis(&leaves[0]));
    let cos = leaves.iter().map(|leaf| axis(leaf).dot(unit)).fold(1.0, f64::min);
    // A range alone has no axis: anything goes.
    let sin = up((1.0 - cos * cos).max(0.0).sqrt()).min(1.0);
    let cone = if unit == DVec3::ZERO { (-1.0, 0.0) } else { (cos as f32, sin) };
    let sums = CHANNELS.map(|channel| sum(leaves, |leaf| axis(leaf) * channel(leaf)));
    let mut representative = *representative;
    let mut shines = unit;
    let (shape, about, colour) = match (representative.emission, leaves.len()) {
        (LightEmission::Patch { back, .. }, _) => {
            let area_over_pi = |leaf: &Leaf| match leaf.light.emission {
                LightEmission::Patch { area_over_pi, .. } => area_over_pi,
                _ => 0.0,
            };
            let extremes =
                leaves.iter().map(area_over_pi).fold((f32::INFINITY, 0.0_f32), |(a, b), s| (a.min(s), b.max(s)));
            if leaves.len() > 1 {
                // Light that a patch sends somewhere is linear in its intensity times its normal.
                let intensity = sums.map(|along| along.dot(unit).max(0.0));
                representative.intensity = DVec3::from_array(intensity).as_vec3();
                let mean = sum(leaves, |leaf| f64::from(area_over_pi(leaf)) * f64::from(leaf.strength())) / strength;
                representative.emission =
                    LightEmission::Patch { normal: unit.as_vec3(), back, area_over_pi: mean as f32 };
            }
            let lost = sums.map(|along| (along - unit * along.dot(unit).max(0.0)).length());
            (ConeStatistics::Patch { least: extremes.0, most: extremes.1 }, mean, lost.iter().sum())
        }
        (_, count) => {
            let spots = leaves.iter().map(|leaf| spot(&leaf.light.emission));
            let (least, most) = spots.fold(([f32::INFINITY; 5], [f32::NEG_INFINITY; 5]), |(least, most), s| {
                (std::array::from_fn(|i| s[i].min(least[i])), std::array::from_fn(|i| s[i].max(most[i])))
            });
            let [inner, outer, scale, offset, inv_range2] = std::array::from_fn(|i| (least[i], most[i]));
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
            let difference = (scale.1 - scale.0) + (offset.1 - offset.0);
            let off = |channel: fn(&Leaf) -> f64| sum(leaves, |leaf| (axis(leaf) - unit) * channel(leaf)).length();
            let shape = ConeStatistics::Spot { inner, outer: outer.0, scale: scale.1, difference, inv_range2 };
            (shape, unit, CHANNELS.map(off).iter().sum())
        }
    };
    let square = sum(leaves, |leaf| axis(leaf).distance_squared(about) * f64::from(leaf.strength())) / strength;
    let orientation = Orientation {
        axis: shines.as_vec3(),
        cone,
        deviation: up(square.sqrt()),
        chromatic_error: up(colour),
        statistics: shape,
    };
    Some((orientation, representative))
}

/// Cosines of a cone's inner and outer edge, below −1 without one, scale, offset, 1 / R².
fn spot(emission: &LightEmission) -> [f32; 5] {
    match *emission {
        LightEmission::Spot { cone: SpotCone { scale, offset, .. }, window } if scale > 0.0 => {
            [(1.0 - offset) / scale, -offset / scale, scale, offset, window.inv_range2]
        }
        LightEmission::Spot { window, .. } => [-2.0, -2.0, 0.0, 1.0, window.inv_range2],
        _ => [-2.0, -2.0, 0.0, 1.0, 0.0],
    }
}
