//! No ray passes between triangles that share an edge or a corner.

use glam::Vec3;

use super::super::scene_bvh::SceneBvh;
use super::{Random, scene};
use crate::geometry::Ray;

const SEGMENTS: usize = 48;
const RINGS: usize = 24;

/// A closed sphere of `SEGMENTS` by `RINGS` quads; neighbours have the same corners to the bit.
fn sphere(center: Vec3, radius: f32) -> Vec<[Vec3; 3]> {
    let point = |segment: usize, ring: usize| {
        let phi = std::f32::consts::TAU * (segment % SEGMENTS) as f32 / SEGMENTS as f32;
        let theta = std::f32::consts::PI * ring as f32 / RINGS as f32;
        let sin = if ring.is_multiple_of(RINGS) { 0.0 } else { libm::sinf(theta) };
        center + radius * Vec3::new(sin * libm::cosf(phi), libm::cosf(theta), sin * libm::sinf(phi))
    };
    let quads = (0..RINGS).flat_map(|ring| (0..SEGMENTS).map(move |segment| (segment, ring)));
    quads
        .flat_map(|(s, r)| {
            let [a, b, c, d] = [point(s, r), point(s + 1, r), point(s + 1, r + 1), point(s, r + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// 420,000 rays from inside at points of edges and at corners, for radii of 5e-5, 1 and 1000 metres, at the origin and
/// 1000 radii from it (where a coordinate has some 6e-5 radii of resolution left).
#[test]
fn closed_spheres_have_no_leaks() {
    let mut random = Random(1);
    for radius in [5e-5, 1.0, 1000.0] {
        for offset in [Vec3::ZERO, Vec3::new(1000.0, -600.0, 300.0)] {
            let center = offset * radius;
            let triangles = sphere(center, radius);
            let bvh = SceneBvh::build(&scene(&triangles));
            let rays: Vec<Ray> = (0..70_000)
                .map(|i| {
                    let corners = triangles[random.below(triangles.len())];
                    let (a, b) = (corners[i % 3], corners[(i + 1) % 3]);
                    let target = if i % 4 == 0 { a } else { a + (b - a) * random.unit() };
                    let origin = center + random.point() * (0.4 * radius);
                    Ray::new(origin, target - origin)
                })
                .collect();
            let (mut hits, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
            bvh.closest_batch(&rays, &mut hits);
            bvh.occluded_batch(&rays, &mut occluded);
            let leaks = hits.iter().filter(|h| h.is_none()).count() + occluded.iter().filter(|&&o| !o).count();
            assert_eq!(leaks, 0, "radius {radius}, centre {center}");
        }
    }
}
