//! Seconds per frame by the number of lights: the mesh with clusters of lights, the mesh with every light, standard
//! tracing.
//!
//! `cargo bench -p lightmesh-io --bench many_lights [-- --write]`. The room of `scenes/room_100.glb` with 10 to 100,000
//! point lights of constant total power, spread over all of it; 800 × 800, one sample per pixel, direct light, spacing
//! 1/40, all cores. The fastest of five first frames, so that other work of the machine counts little; what takes
//! longer than ten seconds is run once, and slow methods end early. Prints the table of docs/many-lights.md and writes
//! `target/many_lights.csv`; with `--write` also the plot, docs/images/many-lights.svg.

#![allow(clippy::print_stdout, reason = "a bench prints its table")]

#[path = "many_lights/plot.rs"]
mod plot;
mod room;

use std::fmt::Write as _;
use std::fs;

use glam::Vec3;
use lightmesh::{Camera, Light, LightMesh, Method, RenderOptions, Scene, SceneData, render};

use plot::{Plot, Series};
use room::{direct_light, from_root, open};

const COUNTS: [usize; 9] = [10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000];

/// Runs of a frame.
const RUNS: usize = 5;

/// Frames that take longer are run once, seconds.
const LONG: f64 = 10.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (data, camera) = open("scenes/room_100.glb")?;
    let options = direct_light(Method::MESH, 40.0);
    // What is run, and up to how many lights.
    let methods = [
        ("mesh", options.clone(), usize::MAX),
        ("mesh, every light", options.clone().with(|o| o.transport.light_error = 0.0), 10_000),
        ("standard", RenderOptions { method: Method::Standard, ..options.clone() }, 1000),
    ];

    let mut series = methods.each_ref().map(|(name, ..)| Series { name, points: Vec::new() });
    let mut csv = "method,lights,seconds\n".to_owned();
    println!("| lights | {} |\n|---|---|---|---|", methods.each_ref().map(|(name, ..)| *name).join(" | "));
    for count in COUNTS {
        let scene = Scene::new(SceneData { lights: lights(count, &data), ..data.clone() })?;
        let mut row = format!("| {count} ");
        for ((name, options, most), series) in methods.iter().zip(&mut series) {
            if count > *most {
                row += "| ";
                continue;
            }
            let seconds = fastest(&scene, &camera, options)?;
            series.points.push((count as f64, seconds));
            writeln!(csv, "\"{name}\",{count},{seconds}")?;
            write!(row, "| {seconds:.3} s ")?;
        }
        println!("{row}|");
    }

    fs::create_dir_all(from_root("target"))?;
    fs::write(from_root("target/many_lights.csv"), csv)?;
    if std::env::args().any(|a| a == "--write") {
        let plot = Plot { x: "point lights of constant total power", y: "first frame, seconds", series: &series };
        fs::write(from_root("docs/images/many-lights.svg"), plot.svg())?;
    }
    Ok(())
}

/// The shortest time of a first frame, its hierarchy of lights included, seconds.
fn fastest(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Result<f64, lightmesh::Error> {
    let mut seconds = Vec::new();
    while seconds.len() < RUNS && seconds.first().is_none_or(|&s| s < LONG) {
        let started = std::time::Instant::now();
        let mut mesh = LightMesh::new(scene, options)?;
        render(scene, camera, options, &mut mesh, &())?;
        seconds.push(started.elapsed().as_secs_f64());
    }
    Ok(seconds.into_iter().fold(f64::INFINITY, f64::min))
}

/// `count` white point lights of 40 cd together, 0.3 m or more off the box of the room.
fn lights(count: usize, data: &SceneData) -> Vec<Light> {
    let bounds = data.bounds();
    (1..=count)
        .map(|i| {
            // The R₃ sequence: powers of 1 / 1.2207…, the root of x⁴ = x + 1 (Roberts 2018).
            let r3 = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|a: f64| (i as f64 * a).fract() as f32);
            let position = bounds.min + 0.3 + Vec3::from_array(r3) * (bounds.size() - 0.6);
            Light::Point { position, intensity_cd: Vec3::splat(40.0 / count as f32), range: None }
        })
        .collect()
}
