//! What the paper named as future work, as options of the product.

use lightmesh::{Falloff, Method, RenderOptions};

use super::lights::papers;
use crate::Error;
use crate::lab::{Lab, direct};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(15))?;
    let size = if lab.quick { (200, 200) } else { (800, 800) };

    // φ1 and φ3, each against exact light with the same φ3.
    let falloff = |constant| Falloff::ConstantPlusDistance { constant };
    let mut rows = Vec::new();
    for (name, field, sum) in [
        ("r² and r² (default)", Falloff::InverseSquare, Falloff::InverseSquare),
        ("0.5 m + r and r²", falloff(0.5), Falloff::InverseSquare),
        ("0.5 m + r and 0.5 m + r", falloff(0.5), falloff(0.5)),
        ("10 m + r and r²", falloff(10.0), Falloff::InverseSquare),
    ] {
        let options = RenderOptions { field_falloff: field, falloff: sum, ..papers(size, 40.0) };
        let standard = lab.shot(&place, &RenderOptions { falloff: sum, ..direct(Method::Standard, size, 40.0) })?;
        let shot = lab.shot(&place, &options)?;
        rows.push(vec![name.into(), (100.0 * shot.error(&standard)).into()]);
    }
    let falloffs = Table {
        caption: "φ1 and φ3 (--field-falloff, --falloff): the paper's scalar, 15 lights, 1/40, against exact light with the same φ3.".into(),
        columns: ["φ1 and φ3", "error, %"].map(str::to_owned).to_vec(),
        rows,
    };

    // Adaptive meshes.
    let standard = lab.shot(&place, &direct(Method::Standard, size, 40.0))?;
    let mut rows = Vec::new();
    let mut errors = Vec::new();
    for (name, method) in [("mesh", Method::Mesh), ("hybrid", Method::Hybrid), ("unbiased, 4 rays", Method::Unbiased)] {
        for refine in 0..=2 {
            let options = RenderOptions { refine: Some(refine), ..direct(method, size, 20.0) };
            let shot = lab.shot(&place, &options)?;
            errors.push(shot.error(&standard));
            rows.push(vec![
                name.into(),
                u64::from(refine).into(),
                (100.0 * shot.error(&standard)).into(),
                shot.stats.direct.points_used.into(),
                shot.stats.rays.shadow.into(),
                shot.seconds().into(),
            ]);
        }
    }
    let adaptive = Table {
        caption: "Meshes that refine themselves (--refine), 15 lights, from 1/20.".into(),
        columns: ["method", "refinements at most", "error, %", "points", "shadow rays", "seconds"]
            .map(str::to_owned)
            .to_vec(),
        rows,
    };

    // Threads.
    let most = rayon::current_num_threads();
    let counts: Vec<usize> = (0..).map(|i| 1 << i).take_while(|&n| n < most).chain([most]).collect();
    let options = direct(Method::Mesh, size, 40.0);
    let mut rows = Vec::new();
    let mut seconds = Vec::new();
    for &threads in &counts {
        let fastest = lab.fastest(&place, &options, threads)?;
        seconds.push(fastest);
        rows.push(vec![(threads as u64).into(), fastest.into(), (seconds[0] / fastest).into()]);
    }
    let threads = Table {
        caption: "Threads: mesh, 15 lights, 1/40, the fastest of some runs.".into(),
        columns: ["threads", "seconds", "speed-up"].map(str::to_owned).to_vec(),
        rows,
    };
    let speed_up = seconds[0] / seconds[seconds.len() - 1];
    let claims = vec![
        Claim {
            claim: "Adaptive meshes are better than uniform ones.".into(),
            paper: None,
            ours: errors[2] / errors[0],
            unit: "×".into(),
            verdict: Verdict::of(errors[2] < 0.9 * errors[0], errors[2] < errors[0]),
            note: "Error of mesh after two refinements over that of none, 1/20; holds below 0.9.".into(),
        },
        Claim {
            claim: "The method parallelises.".into(),
            paper: None,
            ours: speed_up,
            unit: "×".into(),
            verdict: Verdict::of(speed_up > 0.6 * most as f64 || most == 1, speed_up > 1.1),
            note: format!("Speed-up of {most} threads over one; holds above six tenths of their number."),
        },
    ];
    Ok(Section { tables: vec![falloffs, adaptive, threads], claims, ..Section::default() })
}
