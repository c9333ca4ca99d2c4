use fearless_simd::Level;
use glam::Vec3;
use proptest::prelude::*;

use super::bound::Bound;
use super::*;
use crate::Falloff;
use crate::integrator::hash;
use crate::scene::emitters::{LightSample, Patch};
use crate::scene::{Directions, Light};

/// Numbers from a seed.
struct Dice(u32);

impl Dice {
    fn unit(&mut self) -> f32 {
        self.0 = hash(self.0);
        (self.0 >> 8) as f32 / 16_777_216.0
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

    /// The claim of `bound.rs`, node by node: Σ |F_i| − |Σ F_i| + |Σ F_i − F|, summed over the channels, is at most the bound for
    /// every receiver in the box, and nothing arrives where there is none.
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
