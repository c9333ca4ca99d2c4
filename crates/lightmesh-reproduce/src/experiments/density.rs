//! Density halved: the gain and its cost. And what a denser mesh cannot mend.

use lightmesh::Method;

use super::lights::papers;
use crate::error::Error;
use crate::lab::{Lab, direct};
use crate::plot::{Line, Plot, SeriesLabelPosition};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

const POINTS: [f32; 4] = [160.0, 80.0, 40.0, 20.0];

/// The paper's gain from half the density, from and to.
const GAIN: (f64, f64) = (1.3, 2.5);

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(15))?;
    let size = if lab.quick { (200, 200) } else { (800, 800) };
    let points = if lab.quick { &POINTS[1..] } else { &POINTS };
    let standard = lab.shot(&place, &direct(Method::Standard, size, 40.0))?;

    // Time the paper's method and ours at every density, each twice as coarse as the one before.
    let mut ways = Vec::new();
    for &points in points {
        ways.extend([papers(size, points), direct(Method::MESH, size, points)]);
    }
    let seconds = lab.race(&place, &ways)?;

    // Compare each with exact light, and with the density before it.
    let (mut rows, mut errors) = (Vec::new(), [Vec::new(), Vec::new()]);
    for (i, &points) in points.iter().enumerate() {
        let mut row = vec![format!("1/{points}").into()];
        for (method, errors) in errors.iter_mut().enumerate() {
            let index = 2 * i + method;
            let shot = lab.shot(&place, &ways[index])?;
            let error = 100.0 * shot.error(&standard);
            errors.push((f64::from(points), error));
            let gain = index.checked_sub(2).map(|denser| seconds[denser] / seconds[index]);
            row.extend([seconds[index].into(), gain.into(), error.into(), shot.stats.direct.points_used.into()]);
        }
        rows.push(row);
    }

    // Put the numbers into a table and a plot.
    let columns = [
        "spacing",
        "paper, s",
        "times as fast as the line above",
        "error, %",
        "points",
        "mesh, s",
        "times as fast as the line above",
        "error, %",
        "points",
    ];
    let caption = format!("15 lights, {} × {}, direct light; medians of interleaved runs.", size.0, size.1);
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let [paper, mesh] = errors;
    let least = |errors: &[(f64, f64)]| errors.iter().map(|e| e.1).fold(f64::INFINITY, f64::min);
    let (least_paper, least_mesh) = (least(&paper), least(&mesh));
    let gains: Vec<f64> = (2..ways.len()).step_by(2).map(|index| seconds[index - 2] / seconds[index]).collect();
    let mean_gain = gains.iter().map(|g| g.ln()).sum::<f64>() / gains.len() as f64;
    let gain = mean_gain.exp();
    let plot = Plot {
        caption: "Error by density.",
        x: "points along the longest edge",
        y: "error, %",
        names: SeriesLabelPosition::UpperRight,
        logarithmic: true,
        lines: vec![Line { name: "paper".into(), points: paper }, Line { name: "mesh".into(), points: mesh }],
    };

    // Judge the claims.
    let claims = vec![
        Claim {
            claim: "Half the density is 1.3 to 2.5 times as fast.".into(),
            paper: Some(GAIN.0),
            ours: gain,
            unit: "×".into(),
            verdict: Verdict::of(gain >= GAIN.0 && gain <= 1.2 * GAIN.1, gain > 1.0),
            note: "The geometric mean over all halvings; holds between 1.3 and 3.".into(),
        },
        Claim {
            claim: "(Not the paper's:) a scalar cannot know that a light behind a surface does not matter to it; no density mends that, six axes do."
                .into(),
            paper: None,
            ours: least_paper,
            unit: "%".into(),
            verdict: Verdict::of(least_paper >= 8.0 && least_mesh < 8.0, least_paper > least_mesh),
            note: format!(
                "The scalar's least error; holds if it is 8% or more and that of six axes, here {least_mesh:.1}%, is less."
            ),
        },
    ];
    Ok(Section { tables: vec![table], figures: vec![plot.figure()?], claims, ..Section::default() })
}
