//! The primitives of area lights, triangles and spheres, and their pieces: area, emission, and points on them.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::subdivision;
use crate::geometry::Sphere;
use crate::scene::{ColorEncoding, Material, SceneData};

/// The surface that an area light is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source {
    /// A placed mesh.
    Instance(u32),
    /// A sphere; its pieces are `rows` bands of equal height, each of 2 `rows` parts.
    Sphere { index: u32, rows: u32 },
}

/// A triangle in world space, or a sphere.
#[derive(Clone, Copy, Debug)]
pub(super) enum Primitive<'a> {
    Triangle {
        corners: [Vec3; 3],
        /// Unit; the front, whatever the instance mirrors.
        normal: Vec3,
        uvs: [[Vec2; 3]; 2],
    },
    Sphere {
        sphere: &'a Sphere,
        rows: u32,
    },
}

/// A point of a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimitivePoint {
    /// Metres.
    pub position: Vec3,
    /// Unit; the front.
    pub normal: Vec3,
    pub uvs: [Vec2; 2],
}

impl<'a> Primitive<'a> {
    /// Returns a primitive of a surface: a triangle by its index, or the sphere.
    pub(super) fn of(data: &'a SceneData, source: Source, index: u32) -> Self {
        match source {
            Source::Instance(i) => {
                let instance = &data.instances[i as usize];
                let mesh = &data.meshes[instance.mesh];
                let indices = mesh.triangles[index as usize];
                let world_from_object = instance.world_from_object;
                let corners = indices.map(|v| world_from_object.transform_point3(mesh.positions[v as usize]));
                let [a, b, c] = corners;
                let handedness = world_from_object.matrix3.determinant().signum();
                let uvs = [0, 1].map(|set| {
                    let uvs = &mesh.uvs[set];
                    if uvs.is_empty() { [Vec2::ZERO; 3] } else { indices.map(|v| uvs[v as usize]) }
                });
                Self::Triangle { corners, normal: ((b - a).cross(c - a) * handedness).normalize_or(Vec3::Y), uvs }
            }
            Source::Sphere { index, rows } => Self::Sphere { sphere: &data.spheres[index as usize], rows },
        }
    }

    /// Square metres.
    pub(super) fn area(&self) -> f32 {
        match self {
            Self::Triangle { corners: [a, b, c], .. } => 0.5 * (*b - *a).cross(*c - *a).length(),
            Self::Sphere { sphere, .. } => 4.0 * PI * sphere.radius.powi(2),
        }
    }

    /// Returns the part of the area that a piece has.
    pub(super) fn part(&self, cell: u32) -> f32 {
        match self {
            Self::Triangle { .. } => 1.0 / (1_u32 << (2 * subdivision::level(cell))) as f32,
            Self::Sphere { rows, .. } => 1.0 / (2 * rows * rows) as f32,
        }
    }

    /// Returns the point of a piece by u in [0, 1)², uniform over its area.
    pub(super) fn point(&self, cell: u32, u: Vec2) -> PrimitivePoint {
        match self {
            Self::Triangle { .. } => {
                let ([a, b, c], w) = (subdivision::corners(cell), sample_triangle(u));
                self.at(a * w.x + b * w.y + c * w.z)
            }
            Self::Sphere { sphere, rows } => {
                let corner = Vec2::new((cell / (2 * rows)) as f32, (cell % (2 * rows)) as f32);
                let normal = sample_sphere((corner + u) / Vec2::new(*rows as f32, (2 * rows) as f32));
                let position = sphere.center + normal * sphere.radius;
                PrimitivePoint { position, normal, uvs: [sphere.uv(position); 2] }
            }
        }
    }

    /// Returns the middle of a piece.
    pub(super) fn middle(&self, cell: u32) -> PrimitivePoint {
        match self {
            Self::Triangle { .. } => {
                let [a, b, c] = subdivision::corners(cell);
                self.at((a + b + c) / 3.0)
            }
            Self::Sphere { .. } => self.point(cell, Vec2::splat(0.5)),
        }
    }

    /// Returns the point of a triangle with these barycentric coordinates.
    pub(super) fn at(&self, w: Vec3) -> PrimitivePoint {
        let Self::Triangle { corners: [a, b, c], normal, uvs } = *self else {
            return PrimitivePoint { position: Vec3::ZERO, normal: Vec3::Y, uvs: [Vec2::ZERO; 2] };
        };
        let uv = |[p, q, r]: [Vec2; 3]| p * w.x + q * w.y + r * w.z;
        PrimitivePoint { position: a * w.x + b * w.y + c * w.z, normal, uvs: [uv(uvs[0]), uv(uvs[1])] }
    }

    /// Returns the mean emission of a piece, cd/m², from sixteen points; exact where there is no texture.
    pub(super) fn mean_emission(&self, data: &SceneData, material: &Material, cell: u32) -> Vec3 {
        if material.emission_texture.is_none() {
            return material.emission;
        }
        let emission = |point: PrimitivePoint| emission_of(data, material, point.uvs);
        let sum: Vec3 = match self {
            Self::Triangle { .. } => {
                let corners = subdivision::corners(cell);
                let quarters = |corners: [Vec3; 3]| (0..4).map(move |k| subdivision::child_corners(corners, k));
                let parts = quarters(corners).flat_map(quarters);
                parts.map(|[a, b, c]| emission(self.at((a + b + c) / 3.0))).sum()
            }
            Self::Sphere { .. } => {
                let at = |i: u32| Vec2::new((i % 4) as f32 + 0.5, (i / 4) as f32 + 0.5) * 0.25;
                (0..16).map(|i| emission(self.point(cell, at(i)))).sum()
            }
        };
        sum / 16.0
    }
}

/// Returns the luminance that a material emits, cd/m² per channel.
pub(super) fn emission_of(data: &SceneData, material: &Material, uvs: [Vec2; 2]) -> Vec3 {
    let Some(r) = material.emission_texture else { return material.emission };
    let texture = &data.textures[r.texture];
    let texel = texture.sample(&data.images[texture.image], r.transform.apply(uvs[r.uv_set]), ColorEncoding::Srgb);
    material.emission * texel.truncate()
}

/// Returns which piece of a sphere is in this direction from its middle.
pub(super) fn piece_of_sphere(direction: Vec3, rows: u32) -> u32 {
    let row = ((0.5 * (1.0 - direction.z) * rows as f32) as u32).min(rows - 1);
    let turn = libm::atan2f(direction.y, direction.x) / TAU;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    row * 2 * rows + ((turn * (2 * rows) as f32) as u32).min(2 * rows - 1)
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
