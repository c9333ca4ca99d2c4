//! Bounds on the error of representing the lights of a node by one light.
//!
//! Let F_i be the vector along which light i arrives at a receiver: its irradiance on a plane of normal n is max(0, n ·
//! F_i). For lights of a node and F of the light that stands for them, over all n the mean of
//!
//! > | Σ max(0, n · F_i) − max(0, n · F) |  ≤  ¼ (Σ |F_i| − |Σ F_i| + |Σ F_i − F|),
//!
//! because max(0, x) is (x + |x|) / 2 and the mean of |n · v| is |v| / 2. Σ |F_i| / 4 is the mean irradiance itself:
//! the bracket over Σ |F_i| is the relative error. With σ² the mean squared distance of the lights from their mean
//! position, r the least distance between node and receivers, and g = 1 / r² (or 1 / (Const + r)), the first two terms
//! are at most ½ g σ² / r² times the strength, and the last is at most, by Taylor's theorem about the mean position,
//!
//! > ½ · 6 g σ² / r² + 2 g / r |mean position of a channel − mean position|.
//!
//! 2 and 6 are the largest first and second derivatives of d / r³ at r = 1, along any line; for d / r² they are 1
//! and 2. Those of patches are below the same numbers while A / π ≤ r² / 8 (1.98 and 5.9, largest of 30,000 random
//! places). Normals and cones add terms of their own at the lines below. Kinks, where a patch turns its back or a cone
//! ends, give errors of first order, ½ of the mean deviation times the change of slope.

use glam::Vec3;

use super::super::sample::LightEmission;
use super::{ConeStatistics, Extremes, HalfAngle, Kind, LightTree, Node, Orientation};
use crate::Falloff;

/// A box in which light is received.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receivers {
    min: Vec3,
    max: Vec3,
    centre: Vec3,
    radius: f32,
}

/// The light of a node at receivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bound {
    /// The largest value of the bracket above, summed over the channels.
    pub error: f32,
    /// Σ |F_i|, approximately, where the receivers are furthest from the node.
    pub arriving: f32,
}

impl Bound {
    /// No light at all.
    pub(super) const NOTHING: Self = Self { error: 0.0, arriving: 0.0 };
}

impl Receivers {
    /// All points of a box.
    pub(crate) fn within(min: Vec3, max: Vec3) -> Self {
        Self { min, max, centre: 0.5 * (min + max), radius: 0.5 * (max - min).length() }
    }

    /// One point.
    pub(crate) fn at(x: Vec3) -> Self {
        Self::within(x, x)
    }
}

/// [`Falloff::attenuation`] at a distance.
fn attenuation(falloff: Falloff, r: f32) -> f32 {
    falloff.attenuation(r * r, r)
}

impl LightTree {
    /// Returns the distance of a node's mean position from `x`, metres, and the illuminance, R + G + B in lux, that
    /// would arrive at `x` if all its lights shone towards it from there. The distance of directional lights is 1.
    pub(crate) fn distance_and_illuminance(&self, node: u32, falloff: Falloff, x: Vec3) -> (f32, f32) {
        let node = &self.nodes[node as usize];
        if node.kind == Kind::Directional {
            return (1.0, node.strength);
        }
        let r = (node.mean - x).length().max(1e-6);
        (r, node.strength * attenuation(falloff, r))
    }

    /// Bounds a node's error at receivers if its representative stands for it.
    pub(super) fn bound(&self, index: u32, receivers: &Receivers, falloff: Falloff) -> Bound {
        let node = &self.nodes[index as usize];
        if node.kind == Kind::Directional {
            return Bound { error: node.chromatic_error, arriving: node.strength };
        }
        // Bound the distances between node and receivers.
        let gap = (node.min - receivers.max).max(receivers.min - node.max).max(Vec3::ZERO);
        let near = gap.length();
        let far = (node.mean - receivers.centre).length() + receivers.radius;
        let arriving = node.strength * attenuation(falloff, far.max(1e-6));
        if node.kind == Kind::Isotropic {
            let error = if node.child == 0 { 0.0 } else { isotropic_error(node, near, attenuation(falloff, near)) };
            return Bound { error, arriving };
        }
        // Bound the angles under which the lights shine at the receivers, then the error of the kind.
        let orientation = &self.orientations[index as usize - self.first_oriented];
        let cosines = cosines(node, orientation, receivers, near);
        let g = attenuation(falloff, near);
        match orientation.statistics {
            ConeStatistics::Patch { area_over_pi } => {
                let two_sided = node.kind == Kind::TwoSided;
                if cosines.most <= 0.0 && !two_sided {
                    return Bound::NOTHING;
                }
                let across = cosines.least < 0.0 && cosines.most > 0.0;
                let cos = if two_sided { cosines.most.max(-cosines.least) } else { cosines.most };
                let error = if node.child == 0 {
                    0.0
                } else {
                    let slope = if !across {
                        0.0
                    } else if two_sided {
                        2.0
                    } else {
                        1.0
                    };
                    patch_error(node, orientation, area_over_pi, &PatchView { slope, near, g })
                };
                Bound { error, arriving: arriving * cos.min(1.0) }
            }
            ConeStatistics::Spot { inner, outer, scale, difference, inv_range2 } => {
                let beyond = near * near * inv_range2.least;
                if cosines.most <= outer || beyond >= 1.0 {
                    return Bound::NOTHING;
                }
                let furthest = near + (node.max - node.min).length() + 2.0 * receivers.radius;
                let window = (1.0 - beyond * beyond).max(0.0);
                let error = if node.child == 0 {
                    0.0
                } else {
                    let full = cosines.least >= inner.most;
                    let edge = Edge {
                        scale: if full { 0.0 } else { scale },
                        kink: !full && cosines.most > inner.least,
                        difference: if full { 0.0 } else { difference },
                    };
                    spot_error(node, orientation, inv_range2, &SpotView { edge, near, furthest, g })
                };
                let ramp = match self.representatives[index as usize].emission {
                    LightEmission::Spot { cone, .. } => cone.ramp(cosines.most),
                    _ => 1.0,
                };
                Bound { error, arriving: arriving * window * ramp * ramp }
            }
        }
    }
}

/// Caps an error at twice the light, which it cannot pass. Not a number becomes the cap.
fn capped(error: f32, node: &Node, g: f32) -> f32 {
    let most = 2.0 * node.strength * g;
    if error < most { error } else { most }
}

/// The error of isotropic lights: ½ + ½ · 6, and 2.
fn isotropic_error(node: &Node, near: f32, g: f32) -> f32 {
    if near <= 0.0 {
        return f32::INFINITY;
    }
    let u2 = node.variance / (near * near);
    capped(g * (3.5 * u2 * node.strength + 2.0 * node.chromatic_error / near), node, g)
}

/// How receivers see the patches of a node.
struct PatchView {
    /// How much the cosine's slope jumps inside the node: 0 where all patches face the receivers.
    slope: f32,
    /// The least distance, metres.
    near: f32,
    /// The attenuation at that distance.
    g: f32,
}

/// The error of patches. u: deviation of positions over distance, v: of normals. Light is linear
/// in a patch's normal: u v has the first derivative for its factor, v² none; 1 of each for the correction by areas,
/// s (3cos² − 2) / r² with s ≤ r² / 8, which is not. Areas themselves differ by t: t² and t times both first orders.
fn patch_error(node: &Node, orientation: &Orientation, area_over_pi: Extremes, view: &PatchView) -> f32 {
    let PatchView { slope, near, g } = *view;
    if near <= 0.0 || near * near < 8.0 * area_over_pi.most {
        return f32::INFINITY;
    }
    let (u, v, t) = (node.variance.sqrt() / near, orientation.deviation, 2.0 * area_over_pi.width() / (near * near));
    let smooth = 4.5 * u * u + 3.0 * u * v + v * v + t * (1.5 * t + 2.0 * u + v);
    let error = node.strength * (smooth + 0.5 * slope * (u + v))
        + 2.0 * node.chromatic_error / near
        + orientation.chromatic_error;
    capped(g * error, node, g)
}

/// The edge of the cones as receivers see it: scale 0 where they are inside all cones.
struct Edge {
    scale: f32,
    /// Whether the inner edge is in sight, where the slope jumps.
    kink: bool,
    difference: f32,
}

/// How receivers see the spots of a node.
struct SpotView {
    edge: Edge,
    /// The least and the largest distance, metres.
    near: f32,
    furthest: f32,
    /// The attenuation at the least distance.
    g: f32,
}

/// The error of spots and ranges. First derivatives along a line, over r: of d / r³ 2, of the window 4, of the cone 2s
/// with s its scale; second ones 6, 12 and 2s² + 6s, and twice the products of the first.
fn spot_error(node: &Node, orientation: &Orientation, inv_range2: Extremes, view: &SpotView) -> f32 {
    let SpotView { ref edge, near, furthest, g } = *view;
    if near <= 0.0 {
        return f32::INFINITY;
    }
    let (u, v, s) = (node.variance.sqrt() / near, orientation.deviation, edge.scale);
    let windowed = if inv_range2.most > 0.0 { 1.0 } else { 0.0 };
    let first = 2.0 + 4.0 * windowed + 2.0 * s;
    let second = 6.0 + 28.0 * windowed + (14.0 + 16.0 * windowed) * s + 2.0 * s * s;
    let mut relative = (0.5 + 0.5 * second) * u * u + 2.0 * s * (first + 1.0) * u * v + (s * s + s) * v * v;
    // Lights that differ in cone or range: at first order.
    relative += 2.0 * edge.difference + 2.0 * furthest * furthest * inv_range2.width();
    if edge.kink {
        relative += s * (u + v);
    }
    // The window's end, of slope 4 / R.
    if furthest * furthest * inv_range2.most >= 1.0 {
        relative += 2.0 * u;
    }
    let error = node.strength * relative + first * node.chromatic_error / near + 2.0 * s * orientation.chromatic_error;
    capped(g * error, node, g)
}

/// Bounds the cosines between any axis of a node and any direction from its lights to the receivers: by spheres around
/// both boxes, and by the boxes along the axis, whichever is tighter. Of the boxes it follows that a ceiling is behind
/// the emitters that hang below it.
fn cosines(node: &Node, orientation: &Orientation, receivers: &Receivers, near: f32) -> Extremes {
    let spheres = cosines_of_spheres(node, orientation, receivers);
    // Distances along the axis; an axis of the cone is at most a chord away from it.
    let (low, high) = (receivers.min - node.max, receivers.max - node.min);
    let (a, b) = (orientation.axis * low, orientation.axis * high);
    let furthest = low.abs().max(high.abs()).length();
    let slack = ((2.0 - 2.0 * orientation.cone.cos).max(0.0).sqrt() + 1e-6) * furthest;
    let (behind, ahead) = (a.min(b).element_sum() - slack, a.max(b).element_sum() + slack);
    let most = ahead / if ahead > 0.0 { near } else { furthest };
    let least = behind / if behind < 0.0 { near } else { furthest };
    // 0 / 0 is not a number: `min` and `max` return the other bound.
    Extremes { least: least.max(spheres.least), most: most.min(spheres.most) }
}

fn cosines_of_spheres(node: &Node, orientation: &Orientation, receivers: &Receivers) -> Extremes {
    const ANY: Extremes = Extremes { least: -1.0, most: 1.0 };
    let towards = receivers.centre - 0.5 * (node.min + node.max);
    let distance = towards.length();
    let radius = receivers.radius + 0.5 * (node.max - node.min).length();
    if distance <= radius {
        return ANY;
    }
    // φ = the cone's half angle + that under which the spheres see each other.
    let sin_u = radius / distance;
    let cos_u = (1.0 - sin_u * sin_u).max(0.0).sqrt();
    let HalfAngle { cos: cos_o, sin: sin_o } = orientation.cone;
    let (cos_phi, sin_phi) = (cos_o * cos_u - sin_o * sin_u, sin_o * cos_u + cos_o * sin_u);
    // Beyond a half turn.
    if sin_phi < 0.0 {
        return ANY;
    }
    let cos = (orientation.axis.dot(towards) / distance).clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    // cos(θ ± φ), and ±1 where the sum passes a turn; a few roundings to be on the safe side.
    let most = if cos >= cos_phi { 1.0 } else { cos * cos_phi + sin * sin_phi + 1e-6 };
    let least = if -cos >= cos_phi { -1.0 } else { cos * cos_phi - sin * sin_phi - 1e-6 };
    Extremes { least, most }
}
