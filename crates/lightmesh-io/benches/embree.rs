//! Rays per second of our kernel and of Embree 4, one thread, the same rays, runs interleaved.
//!
//! `cargo bench -p lightmesh-io --bench embree [-- SCENE.glb]`; the scene defaults to `../shared/scenes/sponza_25.glb`.
//! Embree is `libembree4` at `LIGHTMESH_EMBREE`, or the one in the Python package `embreex`. Without scene or Embree
//! the program says so and ends.

#![allow(clippy::print_stdout, reason = "a bench prints its table")]

#[path = "embree/ffi.rs"]
mod ffi;
#[path = "embree/rays.rs"]
mod rays;
#[path = "embree/scene.rs"]
mod scene;

use std::hint::black_box;
use std::time::{Duration, Instant};

use ffi::{Embree, EmbreeScene, Flags, Quality};
use lightmesh::bvh::SceneBvh;
use lightmesh::geometry::Ray;
use rays::Workload;
use scene::BenchScene;

/// Interleaved runs; the table shows medians.
const RUNS: usize = 15;

/// Rays per turn: some milliseconds.
const CHUNK: usize = 16_384;

fn main() {
    let path = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let scene = match BenchScene::load(path.as_deref()) {
        Ok(scene) => scene,
        Err(why) => return println!("skipped: {why}"),
    };
    let embree = match Embree::load() {
        Ok(embree) => embree,
        Err(why) => return println!("skipped: {why}"),
    };
    if let Err(why) = compare(&scene, &embree) {
        println!("skipped: {why}");
    }
}

fn compare(scene: &BenchScene, embree: &Embree) -> Result<(), String> {
    let start = Instant::now();
    let bvh = SceneBvh::build(&scene.data);
    let triangles = scene.world_triangles();
    println!(
        "{} triangles, {} B per triangle, built in {:.0} ms",
        triangles.len(),
        bvh.bytes() / triangles.len() as u64,
        1e3 * start.elapsed().as_secs_f64()
    );
    let variants = [
        ("medium", Quality::Medium, Flags::None),
        ("high", Quality::High, Flags::None),
        ("medium robust", Quality::Medium, Flags::Robust),
        ("high robust", Quality::High, Flags::Robust),
    ];
    let opponents: Vec<(&str, EmbreeScene)> = variants
        .into_iter()
        .map(|(name, quality, flags)| Ok((name, embree.scene(&triangles, quality, flags)?)))
        .collect::<Result<_, String>>()?;

    println!("{:10} {:>9} {:>12}   ours / Embree", "rays", "count", "ours Mray/s");
    for workload in rays::workloads(scene, &bvh) {
        check(&workload, &bvh, &opponents[2].1);
        // Each run sums, per contestant, the times of all chunks; contestants take turns at each chunk, so that
        // whatever else the machine does falls on all alike.
        let mut times = vec![Vec::new(); 1 + opponents.len()];
        for _ in 0..RUNS {
            let mut sums = vec![Duration::ZERO; times.len()];
            for rays in workload.rays.chunks(CHUNK) {
                sums[0] += time_ours(rays, workload.any_hit, &bvh);
                for (sum, (_, opponent)) in sums[1..].iter_mut().zip(&opponents) {
                    *sum += time_embree(rays, workload.any_hit, opponent);
                }
            }
            times.iter_mut().zip(sums).for_each(|(times, sum)| times.push(sum));
        }
        let medians: Vec<f64> = times.iter_mut().map(|t| median(t).as_secs_f64()).collect();
        let ratios: Vec<String> =
            opponents.iter().zip(&medians[1..]).map(|((name, _), m)| format!("{name} {:.2}", m / medians[0])).collect();
        let rate = 1e-6 * workload.rays.len() as f64 / medians[0];
        println!("{:10} {:>9} {rate:>12.2}   {}", workload.name, workload.rays.len(), ratios.join("  "));
    }
    Ok(())
}

/// Says how many rays the two kernels answer differently: those that graze an edge.
fn check(workload: &Workload, bvh: &SceneBvh, embree: &EmbreeScene) {
    let differs = |ray: &&Ray| {
        if workload.any_hit {
            return bvh.occluded(ray) != embree.occluded(ray);
        }
        match (bvh.closest(ray), embree.closest(ray)) {
            (Some(ours), Some((t, _))) => (ours.t - t).abs() > 1e-4 * t,
            (ours, theirs) => ours.is_some() != theirs.is_some(),
        }
    };
    let count = workload.rays.iter().filter(differs).count();
    println!("{:10} {count} of {} rays answered differently", workload.name, workload.rays.len());
}

fn time_ours(rays: &[Ray], any_hit: bool, bvh: &SceneBvh) -> Duration {
    if any_hit {
        let mut occluded = vec![false; rays.len()];
        let start = Instant::now();
        bvh.occluded_batch(rays, &mut occluded);
        black_box(&occluded);
        start.elapsed()
    } else {
        let mut hits = vec![None; rays.len()];
        let start = Instant::now();
        bvh.closest_batch(rays, &mut hits);
        black_box(&hits);
        start.elapsed()
    }
}

fn time_embree(rays: &[Ray], any_hit: bool, embree: &EmbreeScene) -> Duration {
    if any_hit {
        let mut occluded = vec![false; rays.len()];
        let start = Instant::now();
        occluded.iter_mut().zip(rays).for_each(|(o, ray)| *o = embree.occluded(ray));
        black_box(&occluded);
        start.elapsed()
    } else {
        let mut hits = vec![None; rays.len()];
        let start = Instant::now();
        hits.iter_mut().zip(rays).for_each(|(h, ray)| *h = embree.closest(ray));
        black_box(&hits);
        start.elapsed()
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}
