//! What a node knows of its lights: means and mean deviations.

use glam::{DVec3, Vec3};

use super::super::sample::{LightEmission, SampledLight};
use super::build::Leaf;
use super::{ConeStatistics, Kind, Node, Orientation};

/// Sums over leaves, in order, in double precision.
fn sum<T: std::iter::Sum>(leaves: &[Leaf], of: impl Fn(&Leaf) -> T) -> T {
    leaves.iter().map(of).sum()
}

fn place(leaf: &Leaf) -> DVec3 {
    leaf.luminaire.position.as_dvec3()
}

/// By channel: its intensity of a leaf.
const CHANNELS: [fn(&Leaf) -> f64; 3] = [
    |leaf| f64::from(leaf.luminaire.intensity.x),
    |leaf| f64::from(leaf.luminaire.intensity.y),
    |leaf| f64::from(leaf.luminaire.intensity.z),
];

/// A rounded up root or sum: bounds stay bounds.
fn up(x: f64) -> f32 {
    (x * (1.0 + 1e-6)) as f32
}

impl Node {
    /// The node of some leaves, and what stands for them as far as place and intensity go.
    pub(crate) fn new(kind: Kind, leaves: &[Leaf], first: u32) -> (Self, SampledLight) {
        let strength = sum(leaves, |leaf| f64::from(leaf.strength()));
        let mean = sum(leaves, |leaf| place(leaf) * f64::from(leaf.strength())) / strength;
        let extremes = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (min, max) = leaves
            .iter()
            .fold(extremes, |(min, max), leaf| (min.min(leaf.luminaire.position), max.max(leaf.luminaire.position)));
        let mut node = Self {
            min,
            max,
            place: mean.as_vec3(),
            strength: strength as f32,
            variance: 0.0,
            colour: 0.0,
            child: 0,
            first,
            count: leaves.len() as u32,
            kind,
        };
        let mut luminaire = leaves[0].luminaire;
        if leaves.len() == 1 {
            node.place = luminaire.position;
            return (node, luminaire);
        }
        if kind == Kind::Direction {
            // Along one direction a cluster is exact; what is lost is what channels bring across it, and where lights face a
            // surface of which the cluster sees the back: 1 − |mean| (`bound.rs`).
            let axis = mean.normalize_or(place(&leaves[0]));
            let sums = CHANNELS.map(|channel| sum(leaves, |leaf| place(leaf) * channel(leaf)));
            let lost = CHANNELS.iter().zip(sums).map(|(channel, across)| {
                sum(leaves, channel) - across.length() + (across - axis * across.dot(axis).max(0.0)).length()
            });
            node.colour = up(lost.sum());
            luminaire.position = axis.as_vec3();
            luminaire.intensity = DVec3::from_array(sums.map(|across| across.dot(axis).max(0.0))).as_vec3();
            node.place = luminaire.position;
            return (node, luminaire);
        }
        let mean = node.place.as_dvec3();
        node.variance =
            up(sum(leaves, |leaf| place(leaf).distance_squared(mean) * f64::from(leaf.strength())) / strength);
        let off = |channel: fn(&Leaf) -> f64| sum(leaves, |leaf| (place(leaf) - mean) * channel(leaf)).length();
        node.colour = up(CHANNELS.map(off).iter().sum());
        luminaire.position = node.place;
        luminaire.intensity = DVec3::from_array(CHANNELS.map(|channel| sum(leaves, channel))).as_vec3();
        (node, luminaire)
    }
}

/// Which way leaves of a kind shine, and the light for them all; `None` where the kind has no axes.
pub(super) fn orientation(
    kind: Kind,
    leaves: &[Leaf],
    luminaire: &SampledLight,
) -> Option<(Orientation, SampledLight)> {
    if matches!(kind, Kind::Even | Kind::Direction) {
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
    let mut luminaire = *luminaire;
    let mut shines = unit;
    let (shape, about, colour) = match (luminaire.emission, leaves.len()) {
        (LightEmission::Patch { back, .. }, _) => {
            let spread = |leaf: &Leaf| match leaf.luminaire.emission {
                LightEmission::Patch { spread, .. } => spread,
                _ => 0.0,
            };
            let extremes = leaves.iter().map(spread).fold((f32::INFINITY, 0.0_f32), |(a, b), s| (a.min(s), b.max(s)));
            if leaves.len() > 1 {
                // Light that a patch sends somewhere is linear in its intensity times its normal.
                let intensity = sums.map(|along| along.dot(unit).max(0.0));
                luminaire.intensity = DVec3::from_array(intensity).as_vec3();
                let spread = sum(leaves, |leaf| f64::from(spread(leaf)) * f64::from(leaf.strength())) / strength;
                luminaire.emission = LightEmission::Patch { axis: unit.as_vec3(), back, spread: spread as f32 };
            }
            let lost = sums.map(|along| (along - unit * along.dot(unit).max(0.0)).length());
            (ConeStatistics::Patch { least: extremes.0, most: extremes.1 }, mean, lost.iter().sum())
        }
        (_, count) => {
            let spots = leaves.iter().map(|leaf| spot(&leaf.luminaire.emission));
            let (least, most) = spots.fold(([f32::INFINITY; 5], [f32::NEG_INFINITY; 5]), |(least, most), s| {
                (std::array::from_fn(|i| s[i].min(least[i])), std::array::from_fn(|i| s[i].max(most[i])))
            });
            let [inner, outer, scale, offset, inv_range2] = std::array::from_fn(|i| (least[i], most[i]));
            if count > 1 {
                let mean = |i: usize| {
                    let of = |leaf: &Leaf| f64::from(spot(&leaf.luminaire.emission)[i]) * f64::from(leaf.strength());
                    (sum(leaves, of) / strength) as f32
                };
                let (scale, offset, inv_range2) = (mean(2), mean(3), mean(4));
                luminaire.emission = LightEmission::Spot { w: 1.0, axis: unit.as_vec3(), scale, offset, inv_range2 };
            }
            shines = -unit;
            let difference = (scale.1 - scale.0) + (offset.1 - offset.0);
            let off = |channel: fn(&Leaf) -> f64| sum(leaves, |leaf| (axis(leaf) - unit) * channel(leaf)).length();
            let shape = ConeStatistics::Spot { inner, outer: outer.0, scale: scale.1, difference, inv_range2 };
            (shape, unit, CHANNELS.map(off).iter().sum())
        }
    };
    let square = sum(leaves, |leaf| axis(leaf).distance_squared(about) * f64::from(leaf.strength())) / strength;
    let orientation =
        Orientation { axis: shines.as_vec3(), cone, deviation: up(square.sqrt()), colour: up(colour), shape };
    Some((orientation, luminaire))
}

/// Cosines of a cone's inner and outer edge, below −1 without one, scale, offset, 1 / R².
fn spot(emission: &LightEmission) -> [f32; 5] {
    match *emission {
        LightEmission::Spot { scale, offset, inv_range2, .. } if scale > 0.0 => {
            [(1.0 - offset) / scale, -offset / scale, scale, offset, inv_range2]
        }
        LightEmission::Spot { inv_range2, .. } => [-2.0, -2.0, 0.0, 1.0, inv_range2],
        _ => [-2.0, -2.0, 0.0, 1.0, 0.0],
    }
}
