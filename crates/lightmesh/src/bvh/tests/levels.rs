//! Every SIMD level gives the same bits.

use fearless_simd::Level;
use glam::Vec3;

use super::super::scene_bvh::SceneBvh;
use super::super::triangle_block::{BlockRay, Shear, TriangleBlock, TriangleHit, intersect_triangle};
use super::{Random, rays, scene};

/// The levels that this machine has, the weakest first.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = vec![Level::baseline()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_sse4_2().map(Level::Sse4_2));
        levels.extend(best.as_avx2().map(Level::Avx2));
    }
    levels.push(best);
    levels
}

#[test]
fn levels_agree_to_the_bit() {
    let mut random = Random(11);
    let triangles: Vec<[Vec3; 3]> = (0..5000)
        .map(|_| {
            let p = random.point();
            [p, p + 0.2 * random.point(), p + 0.2 * random.point()]
        })
        .collect();
    let mut bvh = SceneBvh::build(&scene(&triangles));
    let rays = rays(&triangles, 1.0, 20_000, &mut random);
    let mut answers = levels().into_iter().map(|level| {
        bvh.level = level;
        let (mut hits, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        bvh.closest_batch(&rays, &mut hits);
        bvh.occluded_batch(&rays, &mut occluded);
        // The order in which hits are offered is part of the answer.
        let offered: Vec<u32> = rays[..500]
            .iter()
            .flat_map(|ray| {
                let mut offered = Vec::new();
                bvh.any_hit(ray, |hit| {
                    offered.push(hit.t.to_bits());
                    false
                });
                offered
            })
            .collect();
        let bits: Vec<_> =
            hits.iter().map(|h| h.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.target))).collect();
        (bits, occluded, offered)
    });
    let first = answers.next().expect("at least one level");
    assert!(first.0.iter().filter(|h| h.is_some()).count() > 5000);
    for (other, level) in answers.zip(1..) {
        assert!(other == first, "level {level} differs from the weakest");
    }
}

/// The block test against its plain twin, on triangles whose corners lie on a grid so that rays meet edges and corners.
#[test]
fn the_block_test_agrees_with_its_scalar_twin() {
    let mut random = Random(5);
    let mut met = 0;
    for _ in 0..20_000 {
        let mut corner = || (random.point() * 4.0).round();
        let triangles: [[Vec3; 3]; 4] = std::array::from_fn(|_| std::array::from_fn(|_| corner()));
        let ray = rays(&triangles, 4.0, 1, &mut random)[0];
        let block = TriangleBlock::new(&[(0, triangles[0]), (1, triangles[1]), (2, triangles[2]), (3, triangles[3])]);
        let shear = Shear::new(&ray);
        let inside = |t: f32| t > ray.t_min && t <= ray.t_max;
        let expected: Vec<TriangleHit> = (0..4)
            .filter_map(|id| Some((intersect_triangle(&shear, &triangles[id as usize])?, id)))
            .filter(|([t, ..], _)| inside(*t))
            .map(|([t, u, v], id)| TriangleHit { t, u, v, id })
            .collect();
        met += expected.len();
        for level in levels() {
            let mut found = Vec::new();
            fearless_simd::dispatch!(level, simd => BlockRay::new(simd, &ray).hits(simd, &block, ray.t_max, |hit| {
                found.push(hit);
                false
            }));
            assert_eq!(found, expected, "{level:?} {ray:?} {triangles:?}");
        }
    }
    assert!(met > 2000, "{met}");
}
