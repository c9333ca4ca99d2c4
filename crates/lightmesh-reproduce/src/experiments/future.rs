//! What the paper named as future work, as options of the product.

use lightmesh::{Falloff, Interpolation, Method, PaperScale, PointWeight};

use super::lights::papers;
use crate::error::Error;
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
        let options = papers(size, 40.0).with(|o| {
            o.method = Method::Paper { field_falloff: field, scale: PaperScale::Visibility };
            o.transport.falloff = sum;
        });
        let standard = lab.shot(&place, &direct(Method::Standard, size, 40.0).with(|o| o.transport.falloff = sum))?;
        let shot = lab.shot(&place, &options)?;
        rows.push(vec![name.into(), (100.0 * shot.error(&standard)).into()]);
    }
    let falloffs = Table {
        caption: "φ1 and φ3 (--field-falloff, --falloff): the paper's scalar, 15 lights, 1/40, against exact light with the same φ3.".into(),
        columns: ["φ1 and φ3", "error, %"].map(str::to_owned).to_vec(),
        rows,
    };

    // φ4 and φ5: of the direct field against exact light, of the indirect one by how much it differs from equal
    // weights.
    let standard = lab.shot(&place, &direct(Method::Standard, size, 40.0))?;
    let sphere = |weight, bounces| {
        papers(size, 40.0).with(|o| {
            o.mesh.interpolation = Interpolation::Sphere { radius: 2.0 };
            o.mesh.weight = weight;
            o.transport.bounces = bounces;
        })
    };
    let equal = lab.shot(&place, &sphere(PointWeight::Constant, 1))?;
    let mut rows = Vec::new();
    let mut by_weight = Vec::new();
    for (name, weight) in [
        ("constant (the paper)", PointWeight::Constant),
        ("Gaussian", PointWeight::Gaussian),
        ("inverse distance", PointWeight::Inverse),
        ("cosine to the normal", PointWeight::Cosine),
    ] {
        let shot = lab.shot(&place, &sphere(weight, 0))?;
        by_weight.push(shot.error(&standard));
        let indirect = lab.shot(&place, &sphere(weight, 1))?;
        rows.push(vec![
            name.into(),
            (100.0 * shot.error(&standard)).into(),
            (100.0 * indirect.error(&equal)).into(),
            shot.seconds().into(),
        ]);
    }
    let weights = Table {
        caption: "φ4 and φ5 (--weight): the paper's scalar in spheres of 2 spacings, 15 lights, 1/40.".into(),
        columns: ["weight", "error of direct light, %", "with one bounce, difference from constant, %", "seconds"]
            .map(str::to_owned)
            .to_vec(),
        rows,
    };
    let best_weight = by_weight[1..].iter().copied().fold(f64::INFINITY, f64::min);

    // Meshes that refine themselves, against one that is dense everywhere.
    let mut rows = Vec::new();
    let uniform = lab.shot(&place, &direct(Method::MESH, size, 80.0))?;
    for (name, method) in [("mesh", Method::MESH), ("hybrid", Method::Hybrid), ("unbiased, 4 rays", Method::UNBIASED)] {
        for refine in 0..=2 {
            let options = direct(method, size, 20.0).with(|o| o.mesh.refine = Some(refine));
            let shot = lab.shot(&place, &options)?;
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
    let adapted = lab.shot(&place, &direct(Method::MESH, size, 20.0).with(|o| o.mesh.refine = Some(2)))?;
    rows.push(vec![
        "mesh, 1/80 everywhere".into(),
        0_u64.into(),
        (100.0 * uniform.error(&standard)).into(),
        uniform.stats.direct.points_used.into(),
        uniform.stats.rays.shadow.into(),
        uniform.seconds().into(),
    ]);
    let adaptive = Table {
        caption: "Meshes that refine themselves (--refine), 15 lights, from 1/20.".into(),
        columns: ["method", "refinements at most", "error, %", "points", "shadow rays", "seconds"]
            .map(str::to_owned)
            .to_vec(),
        rows,
    };

    // Density that falls with the distance from the eye.
    let mut rows = Vec::new();
    let mut graded = Vec::new();
    for (name, metres, points) in [
        ("1/32", None, 32.0),
        ("1/32, --graded 8", Some(8.0), 32.0),
        ("1/32, --graded 12", Some(12.0), 32.0),
        ("1/64", None, 64.0),
        ("1/128", None, 128.0),
    ] {
        let shot = lab.shot(&place, &direct(Method::MESH, size, points).with(|o| o.mesh.lod_distance = metres))?;
        graded.push((shot.error(&standard), shot.stats.direct.points_used));
        rows.push(vec![
            name.into(),
            (100.0 * shot.error(&standard)).into(),
            shot.stats.direct.points_used.into(),
            shot.seconds().into(),
        ]);
    }
    let by_distance = Table {
        caption: "Density that falls with the distance from the eye (--graded METRES), mesh, 15 lights.".into(),
        columns: ["spacing", "error, %", "points", "seconds"].map(str::to_owned).to_vec(),
        rows,
    };

    // The same picture on more and more threads.
    let most = rayon::current_num_threads();
    let counts: Vec<usize> = (0..).map(|i| 1 << i).take_while(|&n| n < most).chain([most]).collect();
    let options = direct(Method::MESH, size, 40.0);
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

    // Judge the claims.
    let points = adapted.stats.direct.points_used as f64 / uniform.stats.direct.points_used.max(1) as f64;
    let squares = (adapted.error(&standard) / uniform.error(&standard)).powi(2);
    let speed_up = seconds[0] / seconds[seconds.len() - 1];
    let claims = vec![
        Claim {
            claim: "Other weights than a constant are worth studying.".into(),
            paper: None,
            ours: best_weight / by_weight[0],
            unit: "×".into(),
            verdict: Verdict::of(best_weight < 0.95 * by_weight[0], best_weight < by_weight[0]),
            note: "Error of the best other weight over that of the constant; holds below 0.95.".into(),
        },
        Claim {
            claim: "An adaptive mesh needs fewer points for the same error than a uniform one.".into(),
            paper: None,
            ours: points * squares,
            unit: "×".into(),
            verdict: Verdict::of(points * squares < 1.0, points < 1.0),
            note: format!(
                "Points times squared error of mesh, 1/20 and refined twice, over those of 1/80 everywhere; holds below 1. It is {points:.2} times \
                 the points and {:.2} times the error.",
                squares.sqrt()
            ),
        },
        Claim {
            claim: "Density that falls with the distance from the eye is better spent.".into(),
            paper: None,
            ours: graded[1].0 / graded[0].0,
            unit: "×".into(),
            verdict: Verdict::of(
                graded[1].0 < graded[0].0 && graded[1].1 < graded[3].1 && graded[2].0 < graded[3].0,
                graded[1].0 < graded[0].0,
            ),
            note: format!(
                "Error at 1/32 with --graded 8 over that without; holds if it is below 1 with fewer points than 1/64 everywhere ({} and {}), and \
                 if --graded 12 has less error than 1/64.",
                graded[1].1, graded[3].1
            ),
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
    Ok(Section { tables: vec![falloffs, weights, adaptive, by_distance, threads], claims, ..Section::default() })
}
