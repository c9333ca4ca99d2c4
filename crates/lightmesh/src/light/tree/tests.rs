use fearless_simd::Level;
use glam::Vec3;
use proptest::prelude::*;

use super::super::emitters::{LightSample, Patch};
use super::super::samples::Directions;
use super::bound::{Bound, Receivers};
use super::cut::{Refinement, Tolerance};
use super::*;
use crate::Falloff;
use crate::sampling::chi_square::assert_follows;
use crate::sampling::{hash, unit_f32};
use crate::scene::Light;

/// Numbers from a seed.
struct Dice(u32);

impl Dice {
    fn unit(&mut self) -> f32 {
        self.0 = hash(self.0);
        unit_f32(self.0)
    }

    fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if v.length() > 0.1 && v.length() <= 1.0 {
                return v.normalize();
            }
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Set {
    Points,
    Patches { two_sided: bool },
    Spots,
    Directions,
}

const SETS: [Set; 5] =
    [Set::Points, Set::Patches { two_sided: false }, Set::Patches { two_sided: true }, Set::Spots, Set::Directions];

/// `count` lights about the origin: places within `size`, axes that differ by `width`, colours of all sorts.
fn lights(set: Set, count: usize, size: f32, width: f32, dice: &mut Dice) -> Vec<LightSample> {
    let axis = dice.direction();
    let shapes = [dice.unit(), dice.unit(), dice.unit()];
    (0..count)
        .map(|_| {
            let position = dice.cube() * size;
            let direction = (axis + dice.cube() * width).normalize_or(axis);
            let intensity_cd = Vec3::new(dice.unit(), dice.unit(), dice.unit()) * (0.1 + dice.unit());
            match set {
                Set::Points => LightSample::Punctual(Light::Point { position, intensity_cd, range: None }),
                Set::Patches { two_sided } => {
                    let area = 0.1 * size * size * (0.5 + dice.unit());
                    LightSample::Patch(Patch { position, normal: direction, intensity_cd, area, two_sided })
                }
                // Every other one of another make.
                Set::Spots => {
                    let other = if dice.unit() < 0.5 { width * dice.unit() } else { 0.0 };
                    let outer = (0.2 + 1.3 * shapes[0] + 0.1 * other).min(1.57);
                    LightSample::Punctual(Light::Spot {
                        position,
                        direction,
                        intensity_cd,
                        range: (shapes[2] > 0.3).then_some(1.0 + 4.0 * shapes[2] + other),
                        inner_cone_angle: outer * shapes[1],
                        outer_cone_angle: outer,
                    })
                }
                Set::Directions => {
                    LightSample::Punctual(Light::Directional { direction, illuminance_lux: intensity_cd })
                }
            }
        })
        .collect()
}

/// The vectors along which the lanes' light arrives at a point, by channel, and the sums of their lengths.
fn arriving(lights: &LightSamples, falloff: Falloff, p: Vec3) -> ([Vec3; 3], [f32; 3]) {
    let mut d = Directions::default();
    lights.directions(Level::new(), falloff, p, &mut d);
    let (mut vectors, mut lengths) = ([Vec3::ZERO; 3], [0.0; 3]);
    for lane in 0..lights.lanes() {
        let f = Vec3::new(d.dx[lane], d.dy[lane], d.dz[lane]) * d.f[lane];
        for (k, i) in lights.intensity(lane).to_array().into_iter().enumerate() {
            vectors[k] += f * i;
            lengths[k] += f.length() * i;
        }
    }
    (vectors, lengths)
}

fn packed(tree: &LightTree, cut: &[u32]) -> LightSamples {
    let mut lights = LightSamples::default();
    tree.pack(cut, &mut lights, &mut Vec::new());
    lights
}

/// The leaves under a node.
fn leaves(tree: &LightTree, node: u32) -> Vec<u32> {
    let (mut open, mut found) = (vec![node], Vec::new());
    while let Some(node) = open.pop() {
        match tree.nodes[node as usize].child {
            0 => found.push(node),
            child => open.extend([child + 1, child]),
        }
    }
    found
}

fn falloffs() -> [Falloff; 2] {
    [Falloff::InverseSquare, Falloff::ConstantPlusDistance { constant: 0.3 }]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// The claim of `bound.rs`, node by node: Σ |F_i| − |Σ F_i| + |Σ F_i − F|, summed over the channels, is at most the
    /// bound for every receiver in the box, and nothing arrives where there is none.
    #[test]
    fn no_node_is_further_wrong_than_its_bound(
        seed: u32, kind in 0..5_usize, count in 2..40_usize, size in 0.003_f32..1.0, width in 0.0_f32..1.5,
        distance in 0.0_f32..6.0, extent in 0.0_f32..1.0,
    ) {
        let mut dice = Dice(seed);
        let width = if dice.unit() < 0.3 { 0.0 } else { width * width };
        let samples = LightSamples::new(&lights(SETS[kind], count, size, width, &mut dice));
        let tree = LightTree::new(&samples);
        let centre = dice.direction() * distance;
        let half = (dice.cube() + 1.0) * 0.5 * extent * extent;
        let receivers = Receivers::within(centre - half, centre + half);
        for falloff in falloffs() {
            for node in 0..tree.nodes.len() as u32 {
                let bound = tree.bound(node, &receivers, falloff);
                let (all, one) = (packed(&tree, &leaves(&tree, node)), packed(&tree, &[node]));
                for _ in 0..4 {
                    let p = centre + half * dice.cube();
                    let ((vectors, lengths), (cluster, _)) = (arriving(&all, falloff, p), arriving(&one, falloff, p));
                    let sum: f32 = lengths.iter().sum();
                    if bound == Bound::NOTHING {
                        prop_assert!(sum <= 0.0, "{sum} from {node} of {:?}", SETS[kind]);
                        continue;
                    }
                    let error: f32 =
                        (0..3).map(|k| lengths[k] - vectors[k].length() + (vectors[k] - cluster[k]).length()).sum();
                    let roundings = 1e-5 * sum;
                    prop_assert!(error <= bound.error + roundings, "{error} {bound:?} {sum} {:?} {falloff:?}", SETS[kind]);
                }
            }
        }
    }
}

/// Lights in the room of 10 × 4 × 8 m about the origin, and a cut for a box of receivers in it.
fn room(set: Set, dice: &mut Dice) -> Vec<LightSample> {
    const HALF: Vec3 = Vec3::new(5.0, 2.0, 4.0);
    let mut all = lights(set, 3000, 1.0, 1.0, dice);
    for light in &mut all {
        match light {
            LightSample::Punctual(light) => *light = light.moved(dice.cube() * HALF),
            LightSample::Patch(patch) => {
                patch.position = dice.cube() * HALF;
                patch.area = 1e-3;
            }
        }
    }
    all
}

/// The claim of `cut.rs`, for lights of a kind and for all kinds together: the error of the unshadowed irradiance,
/// averaged over normals, is at random places, as the root of its mean square, below `error` times the mean irradiance
/// over all normals, Σ |F_i| / 4. Single readings are held to four times as much: the worst were 3.6 (patches that look
/// everywhere, 0.1), at 0.01 0.5 to 1.7.
#[test]
fn sums_over_cuts_are_as_near_as_they_say() {
    let mut dice = Dice(7);
    let mut sets: Vec<Vec<LightSample>> = SETS.iter().map(|&set| room(set, &mut dice)).collect();
    sets.push(sets.concat());
    for (samples, falloff) in sets.iter().flat_map(|set| falloffs().map(|falloff| (LightSamples::new(set), falloff))) {
        let tree = LightTree::new(&samples);
        for error in [0.1, 0.03, 0.01] {
            let (mut squares, mut largest, mut n) = (0.0, 0.0_f32, 0.0);
            for _ in 0..24 {
                let centre = dice.cube() * Vec3::new(5.0, 2.0, 4.0);
                let receivers = Receivers::within(centre - 0.125, centre + 0.125);
                let mut cut = Vec::new();
                tree.cut(&receivers, falloff, Tolerance { error, shadows: 0.0 }, &mut Refinement::default(), &mut cut);
                let lights = packed(&tree, &cut);
                let place = centre + dice.cube() * 0.125;
                let points: Vec<_> = (0..32).map(|_| (place, dice.direction())).collect();
                let (mut near, mut exact) = (Vec::new(), Vec::new());
                lights.irradiance(Level::new(), falloff, points.iter().copied(), &mut near);
                samples.irradiance(Level::new(), falloff, points.iter().copied(), &mut exact);
                let mean = arriving(&samples, falloff, place).1.iter().sum::<f32>() / 4.0;
                let errors: Vec<_> = near.iter().zip(&exact).map(|(a, b)| (a - b).abs().element_sum() / mean).collect();
                let over_normals = errors.iter().sum::<f32>() / 32.0;
                (squares, n) = (squares + over_normals * over_normals, n + 1.0);
                largest = errors.into_iter().fold(largest, f32::max);
            }
            let rms = (squares / n).sqrt();
            assert!(rms <= error, "{rms} {error}");
            assert!(largest <= 4.0 * error, "{largest} {error}");
        }
    }
}

/// With no error allowed a cut is every light that arrives, once.
#[test]
fn a_cut_without_error_is_every_light() {
    let mut dice = Dice(3);
    for set in SETS {
        let samples = LightSamples::new(&room(set, &mut dice));
        let tree = LightTree::new(&samples);
        let x = dice.cube();
        let mut cut = Vec::new();
        tree.cut(
            &Receivers::at(x),
            Falloff::InverseSquare,
            Tolerance { error: 0.0, shadows: 0.2 },
            &mut Refinement::default(),
            &mut cut,
        );
        let lanes: Vec<_> = cut.iter().map(|&node| tree.representative(node, 0.5)).collect();
        assert!(cut.iter().all(|&node| tree.nodes[node as usize].count == 1));
        assert_eq!(lanes.iter().collect::<std::collections::HashSet<_>>().len(), lanes.len());
        let mut d = Directions::default();
        samples.directions(Level::new(), Falloff::InverseSquare, x, &mut d);
        let lit = (0..samples.lanes()).filter(|&lane| d.f[lane] > 0.0 && samples.sample(lane).is_some());
        assert!(lit.into_iter().all(|lane| lanes.contains(&lane)));
    }
}

/// A bound that is never reached would refine for nothing: the largest error of 10,000 clusters of points is over a
/// fifth of its.
#[test]
fn bounds_are_not_far_off() {
    let (mut dice, mut closest) = (Dice(11), 0.0_f32);
    for _ in 0..10_000 {
        let samples = LightSamples::new(&lights(Set::Points, 2, 0.1, 0.0, &mut dice));
        let tree = LightTree::new(&samples);
        let p = dice.direction() * 2.0;
        let bound = tree.bound(0, &Receivers::at(p), Falloff::InverseSquare).error;
        let (vectors, lengths) = arriving(&samples, Falloff::InverseSquare, p);
        let cluster = arriving(&packed(&tree, &[0]), Falloff::InverseSquare, p).0;
        let error: f32 = (0..3).map(|k| lengths[k] - vectors[k].length() + (vectors[k] - cluster[k]).length()).sum();
        closest = closest.max(error / bound);
    }
    assert!(closest > 0.2, "{closest}");
}

#[test]
fn representatives_come_in_proportion_to_strength() {
    let mut dice = Dice(5);
    let samples = LightSamples::new(&lights(Set::Points, 30, 1.0, 0.0, &mut dice));
    let tree = LightTree::new(&samples);
    let mut counts = vec![0; samples.lanes()];
    for i in 0..20_000 {
        counts[tree.representative(0, unit_f32(hash(i)))] += 1;
    }
    let strengths: Vec<f64> = (0..samples.lanes()).map(|lane| samples.intensity(lane).element_sum().into()).collect();
    assert_follows(&counts, &strengths);
}
