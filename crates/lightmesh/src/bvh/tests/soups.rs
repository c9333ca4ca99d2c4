//! Random and degenerate triangle soups against brute force, bit by bit.

use glam::Vec3;
use proptest::prelude::*;

use super::super::brute_force::closest_brute_force;
use super::super::hit::Target;
use super::super::scene_bvh::SceneBvh;
use super::{Random, rays, scene};

#[derive(Clone, Copy, Debug)]
enum Soup {
    Random,
    Small,
    Slivers,
    Duplicates,
    ZeroArea,
    Coplanar,
    Nested,
}

fn triangles(soup: Soup, count: usize, scale: f32, random: &mut Random) -> Vec<[Vec3; 3]> {
    let mut triangles: Vec<[Vec3; 3]> = (0..count)
        .map(|i| {
            let p = random.point();
            let (e, f) = (random.point(), random.point());
            let corners = match soup {
                Soup::Random => [p, random.point(), random.point()],
                Soup::Small | Soup::Duplicates => [p, p + 0.1 * e, p + 0.1 * f],
                Soup::Slivers => [p, p + e, p + e * 0.5 + f * 1e-6],
                Soup::ZeroArea => [p, p + e, if i % 2 == 0 { p + e } else { p + f }],
                // On a grid, so that planes, edges and corners coincide.
                Soup::Coplanar => [p, e, f].map(|q| Vec3::new((q.x * 4.0).round(), (q.y * 4.0).round(), 0.0) * 0.25),
                Soup::Nested => [e, f, p].map(|q| q * f32::powi(0.5, i as i32 / 2)),
            };
            corners.map(|c| c * scale)
        })
        .collect();
    if let Soup::Duplicates = soup {
        triangles.extend(triangles.clone());
        triangles.extend_from_within(..count / 2);
    }
    triangles
}

fn agrees_with_brute_force(soup: Soup, count: usize, scale: f32, offset: Vec3, seed: u32) -> Result<(), TestCaseError> {
    let mut random = Random(seed);
    let mut triangles = triangles(soup, count, scale, &mut random);
    triangles.iter_mut().flatten().for_each(|c| *c += offset * scale);
    let data = scene(&triangles);
    let bvh = SceneBvh::build(&data);
    for mut ray in rays(&triangles, scale, 200, &mut random) {
        if random.unit() < 0.5 {
            ray.origin += offset * scale;
        }
        // The closest hit has the same bits.
        let truth = closest_brute_force(&data, &ray);
        prop_assert_eq!(bvh.closest(&ray), truth, "{:?}", ray);
        prop_assert_eq!(bvh.occluded(&ray), truth.is_some());

        // Every hit is offered once.
        let mut offered = Vec::new();
        bvh.any_hit(&ray, |hit| {
            offered.push((hit.target, hit.t.to_bits()));
            false
        });
        let mut all = Vec::new();
        for (corners, triangle) in triangles.iter().zip(0..) {
            if let Some(hit) = closest_brute_force(&scene(&[*corners]), &ray) {
                all.push((Target::Triangle { instance: 0, triangle }, hit.t.to_bits()));
            }
        }
        offered.sort_unstable();
        prop_assert_eq!(offered, all);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

    #[test]
    fn soups_agree_with_brute_force(
        soup in prop::sample::select(vec![
            Soup::Random, Soup::Small, Soup::Slivers, Soup::Duplicates, Soup::ZeroArea, Soup::Coplanar, Soup::Nested,
        ]),
        count in 0..150_usize,
        scale in prop::sample::select(vec![1e-6_f32, 1e-3, 1.0, 1e4, 1e8]),
        offset in prop::sample::select(vec![Vec3::ZERO, Vec3::new(100.0, -30.0, 7.0)]),
        seed: u32,
    ) {
        agrees_with_brute_force(soup, count, scale, offset, seed)?;
    }
}

/// Boxes in geometric progression make a chain of the binary tree; equal boxes leave the builder nothing to go by.
#[test]
fn chains_and_equal_boxes_do_not_overflow_the_stack() {
    let unit = [Vec3::new(-1.0, -1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(0.0, 1.0, 1.0)];
    let chain: Vec<[Vec3; 3]> = (0..600).map(|i| unit.map(|c| c * f32::powi(2.0, i / 10 - 30))).collect();
    let equal = vec![unit; 100_000];
    let line: Vec<[Vec3; 3]> = (0..3000).map(|i| unit.map(|c| c + Vec3::X * i as f32)).collect();
    for triangles in [chain, equal, line] {
        let data = scene(&triangles);
        let bvh = SceneBvh::build(&data);
        let count = 600_000 / triangles.len();
        for ray in rays(&triangles, 1.0, count, &mut Random(7)) {
            assert_eq!(bvh.closest(&ray), closest_brute_force(&data, &ray), "{ray:?}");
        }
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let triangles = triangles(Soup::Small, 20_000, 1.0, &mut Random(3));
    let data = scene(&triangles);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        format!("{:?}", pool.install(|| SceneBvh::build(&data)))
    };
    assert!(build(1) == build(2), "trees of one and two threads differ");
}
