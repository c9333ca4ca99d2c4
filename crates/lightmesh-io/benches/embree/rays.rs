//! The three kinds of rays.

use glam::Vec3;
use lightmesh::bvh::{Hit, SceneBvh, Target};
use lightmesh::geometry::{Ray, offset_origin};

use super::scene::BenchScene;

/// One kind of rays and how to ask.
pub(crate) struct Workload {
    pub(crate) name: &'static str,
    pub(crate) rays: Vec<Ray>,
    pub(crate) any_hit: bool,
}

const WIDTH: usize = 800;
const HEIGHT: usize = 450;

/// Camera rays row by row; from each hit a cosine-distributed bounce; from each third hit a segment to every light.
pub(crate) fn workloads(scene: &BenchScene, bvh: &SceneBvh) -> Vec<Workload> {
    let primary: Vec<Ray> =
        (0..WIDTH * HEIGHT).map(|i| scene.camera_ray(i % WIDTH, i / WIDTH, WIDTH, HEIGHT)).collect();
    let mut hits = vec![None; primary.len()];
    bvh.closest_batch(&primary, &mut hits);
    let extent = bvh.bounds().size().max_element();
    let surface: Vec<(Vec3, Vec3)> =
        primary.iter().zip(&hits).filter_map(|(r, h)| Some(start(scene, r, &(*h)?, extent))).collect();

    let mut seed = 1;
    let bounce = surface.iter().map(|&(p, n)| Ray::new(p, cosine_direction(n, &mut seed))).collect();
    let shadow = |&(p, _): &(Vec3, Vec3)| scene.lights.iter().map(move |&l| Ray::segment(p, l));
    let shadow = surface.iter().step_by(9).flat_map(shadow).collect();
    vec![
        Workload { name: "primary", rays: primary, any_hit: false },
        Workload { name: "bounce", rays: bounce, any_hit: false },
        Workload { name: "shadow", rays: shadow, any_hit: true },
    ]
}

/// Where rays from a hit start, and the normal on the side the ray came from.
fn start(scene: &BenchScene, ray: &Ray, hit: &Hit, extent: f32) -> (Vec3, Vec3) {
    let Target::Triangle { instance, triangle } = hit.target else { return (ray.at(hit.t), -ray.direction) };
    let [a, b, c] = scene.triangle(instance, triangle);
    let n = (b - a).cross(c - a).normalize_or(Vec3::Y);
    let n = if n.dot(ray.direction) > 0.0 { -n } else { n };
    (offset_origin(a + (b - a) * hit.u + (c - a) * hit.v, n, extent, n), n)
}

/// A direction about `n` with density cosθ/π: `n` plus a point of the unit sphere.
fn cosine_direction(n: Vec3, seed: &mut u32) -> Vec3 {
    loop {
        let p = Vec3::new(random(seed), random(seed), random(seed)) * 2.0 - 1.0;
        let l2 = p.length_squared();
        let d = n + p / l2.sqrt();
        if l2 <= 1.0 && l2 > 1e-6 && d.length_squared() > 1e-6 {
            return d.normalize();
        }
    }
}

/// A number in [0, 1): the PCG hash of a counter (Jarzynski and Olano, JCGT 2020).
fn random(counter: &mut u32) -> f32 {
    *counter = counter.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((*counter >> ((*counter >> 28) + 4)) ^ *counter).wrapping_mul(277_803_737);
    ((word >> 22 ^ word) >> 8) as f32 / (1 << 24) as f32
}
