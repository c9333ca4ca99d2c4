//! Where the time of a frame goes, for each method beside standard tracing, runs interleaved.
//!
//! `cargo bench -p lightmesh-io --bench frames [-- SCENE.glb]`; the scene defaults to `scenes/room_15.glb`. All cores,
//! 800 × 800, one sample per pixel, direct light. Medians; ratios are of medians. A second frame finds the mesh filled.
//! The operations: a camera ray with what it hits, a mesh point, and the light of a hit (reading the mesh, shadow rays,
//! sums, adding to the picture).

#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod room;

use lightmesh::{Frame, LightMesh, Method, Scene, render};

use room::{direct_light, from_root, open};

/// Interleaved runs.
const RUNS: usize = 15;

/// What a column holds, and how it is found from a first and a second frame.
type Column = (&'static str, fn(&Frame, &Frame) -> f64);

/// Milliseconds of frames, then microseconds of operations.
const COLUMNS: [Column; 6] = [
    ("first", |first, _| 1e3 * first.stats.seconds.render),
    ("second", |_, second| 1e3 * second.stats.seconds.render),
    ("primary", |_, second| 1e3 * second.stats.seconds.primary),
    ("ray, us", |_, second| 1e6 * second.stats.seconds.primary / second.stats.rays.primary as f64),
    ("point, us", |first, _| 1e6 * first.stats.seconds.fill_direct / first.stats.direct.points_used.max(1) as f64),
    ("hit, us", |_, second| 1e6 * second.stats.seconds.shade / second.stats.rays.primary as f64),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked = std::env::args().skip(1).find(|a| !a.starts_with("--")).unwrap_or_else(|| "scenes/room_15.glb".into());
    let (data, camera) = open(&asked)?;
    let scene = Scene::new(data)?;
    let unbiased = direct_light(Method::UNBIASED, 80.0).with(|o| o.method = Method::unbiased(4));
    let methods = [
        ("standard", direct_light(Method::Standard, 40.0)),
        ("mesh 1/40", direct_light(Method::MESH, 40.0)),
        ("hybrid 1/80", direct_light(Method::Hybrid, 80.0)),
        ("unbiased 1/80, 4 rays", unbiased),
    ];

    let mut measured = methods.each_ref().map(|_| COLUMNS.map(|_| Vec::new()));
    for _ in 0..RUNS {
        for ((_, options), columns) in methods.iter().zip(&mut measured) {
            let mut mesh = LightMesh::new(&scene, options)?;
            let mut frame = || render(&scene, &camera, options, &mut mesh, &());
            let (first, second) = (frame()?, frame()?);
            for (column, (_, value)) in columns.iter_mut().zip(COLUMNS) {
                column.push(value(&first, &second));
            }
        }
    }

    let lights = scene.light_sample_count();
    let path = from_root(&asked);
    println!("{}: {lights} lights, {} threads, medians of {RUNS} runs", path.display(), rayon::current_num_threads());
    println!("{:<22}{}{:>22}{:>20}", "", heading(), "second over primary", "standard over first");
    let medians = measured.map(|columns| columns.map(median));
    for ((name, _), row) in methods.iter().zip(medians) {
        let numbers: String = row.iter().map(|number| format!("{number:>11.2}")).collect();
        println!("{name:<22}{numbers}{:>22.2}{:>20.2}", row[1] / row[2], medians[0][0] / row[0]);
    }
    Ok(())
}

fn heading() -> String {
    COLUMNS.map(|(name, _)| format!("{name:>11}")).concat()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
