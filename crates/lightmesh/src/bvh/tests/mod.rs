//! The tree against brute force, its own SIMD levels, and what no ray may pass.

mod leaks;
mod levels;
mod numbers;
mod soups;
mod two_levels;

use glam::{Affine3A, Vec3};

use crate::geometry::{Ray, TriangleMesh};
use crate::sampling::unit_f32;
use crate::scene::{Instance, SceneData};

/// A small generator of test numbers: the PCG hash of a counter.
struct Random(u32);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        unit_f32(word >> 22 ^ word)
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }

    /// Each coordinate in [−1, 1).
    fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// A mesh of unconnected triangles.
fn mesh(triangles: &[[Vec3; 3]]) -> TriangleMesh {
    TriangleMesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Default::default()
    }
}

/// A scene of these triangles, placed once.
fn scene(triangles: &[[Vec3; 3]]) -> SceneData {
    let instance = Instance { mesh: 0, world_from_object: Affine3A::IDENTITY };
    SceneData { meshes: vec![mesh(triangles)], instances: vec![instance], ..Default::default() }
}

/// Rays of every kind about a soup of the given size: from anywhere, from a corner, at a corner, along an axis.
fn rays(triangles: &[[Vec3; 3]], scale: f32, count: usize, random: &mut Random) -> Vec<Ray> {
    (0..count)
        .map(|_| {
            let corner = |random: &mut Random| {
                triangles.get(random.below(triangles.len().max(1))).map_or(Vec3::ZERO, |t| t[random.below(3)])
            };
            let origin = match random.below(4) {
                0 => corner(random),
                1 => corner(random) + random.point() * scale,
                _ => random.point() * (2.0 * scale),
            };
            let direction = match random.below(4) {
                0 => corner(random) - origin,
                1 => Vec3::AXES[random.below(3)] * if random.unit() < 0.5 { 1.0 } else { -1.0 },
                2 => Vec3::AXES[random.below(3)] + Vec3::AXES[random.below(3)] * random.unit(),
                _ => random.point(),
            };
            let direction = if direction == Vec3::ZERO { Vec3::X } else { direction };
            let t_max = if random.unit() < 0.2 { random.unit() } else { f32::INFINITY };
            Ray { origin, direction, t_min: 0.0, t_max }
        })
        .collect()
}
