//! Figures 4-9: the nearest point, and spheres.

use lightmesh::{Interpolation, Method};

use crate::error::Error;
use crate::lab::{Lab, direct};
use crate::picture::figure;
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

/// The paper's mesh of 100³ points, of which its picture used so many.
const USED: (f64, f64) = (1e6, 297_000.0);

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(15))?;
    let size = if lab.quick { (240, 160) } else { (720, 480) };
    let with =
        |points, interpolation| direct(Method::PAPER, size, points).with(|o| o.mesh.interpolation = interpolation);
    let sphere = |radius| Interpolation::Sphere { radius };
    // List the neighbourhoods of the paper's figures.
    let ways = [
        ("nearest, 1/40", with(40.0, Interpolation::Nearest)),
        ("nearest, 1/80", with(80.0, Interpolation::Nearest)),
        ("nearest, 1/100", with(100.0, Interpolation::Nearest)),
        ("sphere of 1 spacing, 1/40", with(40.0, sphere(1.0))),
        ("sphere of 1.5, 1/40", with(40.0, sphere(1.5))),
        ("sphere of 3, 1/40", with(40.0, sphere(3.0))),
    ];
    // Render with each, and compare with exact light.
    let standard = lab.shot(&place, &direct(Method::Standard, size, 40.0))?;
    let (mut rows, mut shots) = (Vec::new(), Vec::new());
    for (name, options) in &ways {
        let shot = lab.shot(&place, options)?;
        let mesh = shot.stats.direct;
        rows.push(vec![
            (*name).into(),
            (100.0 * shot.error(&standard)).into(),
            mesh.points_used.into(),
            mesh.points_total.into(),
            (100.0 * mesh.points_used as f64 / mesh.points_total.max(1) as f64).into(),
            shot.seconds().into(),
        ]);
        shots.push(shot);
    }
    // Put the numbers into a table and the pictures beside each other.
    let columns = ["neighbourhood, spacing", "error, %", "points used", "points of the room", "used, %", "seconds"];
    let caption = format!(
        "The paper's scalar field under 15 lights, {} × {}, one sample per pixel, direct light.",
        size.0, size.1
    );
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let mut pictures: Vec<_> = ways.iter().zip(&shots).map(|((name, _), shot)| (*name, &shot.image)).collect();
    pictures.push(("standard", &standard.image));
    let shown = figure("Neighbourhoods of the paper's figures 4 to 9, and exact shadow rays.", &pictures)?;

    // Judge the claims.
    let hundred = shots[2].stats.direct;
    let used = 100.0 * hundred.points_used as f64 / hundred.points_total.max(1) as f64;
    let errors: Vec<f64> = shots.iter().map(|shot| shot.error(&standard)).collect();
    let claims = vec![
        Claim {
            claim: "Only a part of the mesh is ever evaluated.".into(),
            paper: Some(100.0 * USED.1 / USED.0),
            ours: used,
            unit: "%".into(),
            verdict: Verdict::of(used < 50.0, used < 100.0),
            note: "Points used of those of a full mesh, 1/100; holds below half.".into(),
        },
        Claim {
            claim: "Spheres are better than the nearest point.".into(),
            paper: None,
            ours: errors[4] / errors[0],
            unit: "×".into(),
            verdict: Verdict::of(errors[4] < errors[0], errors[3].min(errors[5]) < errors[0]),
            note: "Error with a sphere of 1.5 over that with the nearest point, both 1/40; holds below 1.".into(),
        },
    ];
    Ok(Section { tables: vec![table], figures: vec![shown], claims, ..Section::default() })
}
