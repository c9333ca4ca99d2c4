//! Seconds per frame of the light mesh, cold and warm, beside standard tracing and camera rays with what they hit, runs
//! interleaved.
//!
//! `cargo bench -p lightmesh-io --bench frames [-- SCENE.glb]`; the scene defaults to `scenes/room_15.glb`. All cores,
//! 800 × 800, one sample per pixel, direct light, spacing 1/40; ratios are of medians.

#![allow(clippy::print_stdout, reason = "a bench prints its table")]

use std::path::Path;

use lightmesh::{Camera, LightMesh, Method, RenderOptions, Scene, Spacing, render};
use lightmesh_io::{LoadOptions, load};

/// Interleaved runs.
const RUNS: usize = 15;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    // Relative paths are meant from the repository's root; cargo starts a bench in its package.
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(asked.as_deref().unwrap_or("scenes/room_15.glb"));
    let data = load(&path, &LoadOptions::default())?.data;
    let camera = data.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&data.bounds()));
    let scene = Scene::new(data)?;
    let options = |method| RenderOptions {
        method,
        width: 800,
        height: 800,
        spp: 1,
        bounces: 0,
        spacing: Spacing::Fraction(40.0),
        ..RenderOptions::default()
    };
    let (standard, meshed) = (options(Method::Standard), options(Method::Mesh));

    let mut seconds: [Vec<f64>; 4] = Default::default();
    for _ in 0..RUNS {
        let mut mesh = LightMesh::new(&scene, &meshed)?;
        let mut seconds_of = |options| render(&scene, &camera, options, &mut mesh, &()).map(|f| f.stats.seconds);
        let (exact, cold, warm) = (seconds_of(&standard)?, seconds_of(&meshed)?, seconds_of(&meshed)?);
        for (column, s) in seconds.iter_mut().zip([warm.primary, exact.render, cold.render, warm.render]) {
            column.push(s);
        }
    }

    let median = seconds.map(|mut column| {
        column.sort_by(f64::total_cmp);
        column[RUNS / 2]
    });
    let lights = scene.light_sample_count();
    println!("{}: {lights} lights, {} threads, medians of {RUNS} runs", path.display(), rayon::current_num_threads());
    println!("{:<28} {:>8} {:>14} {:>14}", "", "ms", "over primary", "standard over");
    for (name, s) in
        ["primary rays and their hits", "standard", "mesh, first frame", "mesh, second frame"].iter().zip(median)
    {
        println!("{name:<28} {:>8.1} {:>14.2} {:>14.2}", 1e3 * s, s / median[0], median[1] / s);
    }
    Ok(())
}
