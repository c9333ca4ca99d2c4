//! The primitives of area lights, triangles and spheres: their area, their emission, and points on them.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::scene::{ColorEncoding, Material, SceneData};

/// A primitive of an emissive surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum EmissivePrimitive {
    Triangle {
        /// World space.
        corners: [Vec3; 3],
        /// Indices into the mesh's attributes.
        indices: [u32; 3],
        mesh: u32,
        /// −1 where the instance mirrors: the front is the other side of the corners' order.
        handedness: f32,
    },
    Sphere(u32),
}

/// A point of a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimitivePoint {
    pub position: Vec3,
    /// Unit; the front.
    pub normal: Vec3,
    pub uvs: [Vec2; 2],
}

impl EmissivePrimitive {
    /// Square metres.
    pub(super) fn area(&self, data: &SceneData) -> f32 {
        match *self {
            Self::Triangle { corners: [a, b, c], .. } => 0.5 * (b - a).cross(c - a).length(),
            Self::Sphere(i) => 4.0 * PI * data.spheres[i as usize].radius.powi(2),
        }
    }

    /// Samples a point by u in [0, 1)², uniformly over the area.
    pub(super) fn point(&self, data: &SceneData, u: Vec2) -> PrimitivePoint {
        match *self {
            Self::Triangle { corners: [a, b, c], indices, mesh, handedness } => {
                let w = sample_triangle(u);
                let uvs = &data.meshes[mesh as usize].uvs;
                let uv = |set: &[Vec2]| match set.is_empty() {
                    true => Vec2::ZERO,
                    false => {
                        set[indices[0] as usize] * w.x + set[indices[1] as usize] * w.y + set[indices[2] as usize] * w.z
                    }
                };
                let normal = ((b - a).cross(c - a) * handedness).normalize_or(Vec3::Y);
                PrimitivePoint { position: a * w.x + b * w.y + c * w.z, normal, uvs: [uv(&uvs[0]), uv(&uvs[1])] }
            }
            Self::Sphere(i) => {
                let sphere = &data.spheres[i as usize];
                let normal = sample_sphere(u);
                let position = sphere.center + normal * sphere.radius;
                PrimitivePoint { position, normal, uvs: [sphere.uv(position); 2] }
            }
        }
    }

    /// Returns the mean emission, from a few points; exact where there is no texture.
    pub(super) fn mean_emission(&self, data: &SceneData, material: &Material) -> Vec3 {
        if material.emission_texture.is_none() {
            return material.emission;
        }
        const SIDE: u32 = 4;
        let at = |i: u32| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32;
        let sum: Vec3 = (0..SIDE * SIDE).map(|i| emission_of(data, material, self.point(data, at(i)).uvs)).sum();
        sum / (SIDE * SIDE) as f32
    }
}

/// Returns the luminance that a material emits, cd/m² per channel.
pub(super) fn emission_of(data: &SceneData, material: &Material, uvs: [Vec2; 2]) -> Vec3 {
    let Some(r) = material.emission_texture else { return material.emission };
    let texture = &data.textures[r.texture];
    let texel = texture.sample(&data.images[texture.image], r.transform.apply(uvs[r.uv_set]), ColorEncoding::Srgb);
    material.emission * texel.truncate()
}

/// Samples barycentric coordinates, uniform over a triangle: (1 − √u, (1 − v) √u, v √u).
pub(super) fn sample_triangle(u: Vec2) -> Vec3 {
    let s = u.x.sqrt();
    Vec3::new(1.0 - s, (1.0 - u.y) * s, u.y * s)
}

/// Samples a uniform direction.
pub(super) fn sample_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let phi = TAU * u.y;
    Vec3::new(r * libm::cosf(phi), r * libm::sinf(phi), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::assert_uniform;
    use crate::sampling::{hash, unit_f32};

    fn invert_triangle(w: Vec3) -> Vec2 {
        let s = 1.0 - w.x;
        Vec2::new(s * s, w.z / s)
    }

    fn invert_sphere(d: Vec3) -> Vec2 {
        let phi = libm::atan2f(d.y, d.x) / TAU;
        Vec2::new(0.5 * (1.0 - d.z), if phi < 0.0 { phi + 1.0 } else { phi })
    }

    #[test]
    fn inverting_a_thousand_points_gives_their_numbers_back() {
        for i in 0..1000 {
            let u = Vec2::new(sobol_burley::sample(i, 0, 3), sobol_burley::sample(i, 1, 3)) * 0.998 + 0.001;
            assert!((invert_triangle(sample_triangle(u)) - u).length() < 1e-3, "{u}");
            assert!((invert_sphere(sample_sphere(u)) - u).length() < 1e-3, "{u}");
        }
    }

    /// Uniform: in the unit right triangle x² and y² have the mean 1/6, xy 1/12; on the sphere z² has 1/3.
    #[test]
    fn moments_are_those_of_the_uniform_distribution() {
        let n = 4096;
        let (mut xx, mut xy, mut zz) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let u = Vec2::new(sobol_burley::sample(i, 0, 9), sobol_burley::sample(i, 1, 9));
            let w = sample_triangle(u);
            (xx, xy) = (xx + w.y * w.y / n as f32, xy + w.y * w.z / n as f32);
            zz += sample_sphere(u).z.powi(2) / n as f32;
        }
        assert!((xx - 1.0 / 6.0).abs() < 1e-3 && (xy - 1.0 / 12.0).abs() < 1e-3 && (zz - 1.0 / 3.0).abs() < 1e-3);
    }

    /// Points of an independent sampler (folded squares, rejected cubes), inverted, fill 64 cells of equal area evenly.
    #[test]
    fn inverted_points_of_other_samplers_are_uniform() {
        let unit = |k: u32| unit_f32(hash(k));
        let assert_even = |points: &mut dyn Iterator<Item = Vec2>| {
            let mut cells = [0; 64];
            for u in points {
                cells[((u.x * 8.0) as usize).min(7) * 8 + ((u.y * 8.0) as usize).min(7)] += 1;
            }
            assert_uniform(&cells);
        };
        assert_even(&mut (0..20_000).map(|i| {
            let (x, y) = (unit(2 * i), unit(2 * i + 1));
            let (y, z) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            invert_triangle(Vec3::new(1.0 - y - z, y, z))
        }));
        assert_even(&mut (0..40_000).filter_map(|i| {
            let p = Vec3::from_array([0, 1, 2].map(|d| 2.0 * unit(100_000 + 3 * i + d) - 1.0));
            (p.length() < 1.0).then(|| invert_sphere(p.normalize()))
        }));
    }
}
