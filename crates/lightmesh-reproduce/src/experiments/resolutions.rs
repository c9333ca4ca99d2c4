//! Table 2: by resolution.

use lightmesh::Method;

use super::lights::papers;
use crate::error::Error;
use crate::lab::{Lab, direct};
use crate::plot::{Line, Plot, SeriesLabelPosition};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

/// Pixels of a side, and the ratio of times that the paper has.
const SIZES: [(u32, Option<f64>); 4] = [(50, Some(0.09)), (250, Some(1.09)), (800, Some(3.29)), (1600, None)];

const POINTS: f32 = 40.0;

/// Two sizes, one eight times the other, between which the paper's mesh grew by so many percent on average.
const GROWTH: (u32, u32, f64) = (100, 800, 3.46);

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(15))?;
    let scale = if lab.quick { 4 } else { 1 };
    let (mut rows, mut ratios, mut lines) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    // Time exact light, the paper's method and ours at every size.
    for (side, then) in SIZES {
        let size = (side / scale, side / scale);
        let ways = [direct(Method::Standard, size, POINTS), papers(size, POINTS), direct(Method::MESH, size, POINTS)];
        let seconds = lab.race(&place, &ways)?;
        let paper = lab.shot(&place, &ways[1])?;
        ratios.push(seconds[0] / seconds[1]);
        for (line, &other) in lines.iter_mut().zip(&seconds[1..]) {
            line.push((f64::from(size.0), seconds[0] / other));
        }
        rows.push(vec![
            format!("{} × {}", size.0, size.1).into(),
            seconds[0].into(),
            seconds[1].into(),
            (seconds[0] / seconds[1]).into(),
            then.into(),
            paper.stats.direct.points_used.into(),
            seconds[2].into(),
            (seconds[0] / seconds[2]).into(),
        ]);
    }
    // Put the numbers into a table and a plot, beside those of 2001.
    let columns =
        ["pixels", "standard, s", "paper, s", "ratio", "ratio in 2001", "mesh points, paper", "mesh, s", "ratio"];
    let caption = format!("15 lights, one sample per pixel, direct light, 1/{POINTS}; medians of interleaved runs.");
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let [paper, mesh] = lines;
    let plot = Plot {
        caption: "How many times as fast as standard tracing.",
        x: "pixels of a side",
        y: "times as fast",
        names: SeriesLabelPosition::UpperLeft,
        logarithmic: true,
        lines: vec![
            Line { name: "paper".into(), points: paper },
            Line { name: "mesh".into(), points: mesh },
            Line {
                name: "in 2001".into(),
                points: SIZES.iter().filter_map(|&(side, then)| Some((f64::from(side / scale), then?))).collect(),
            },
        ],
    };

    // Count mesh points at the two sizes that the paper compares.
    let (small, large, then) = GROWTH;
    let mut used = Vec::new();
    for side in [small / scale, large / scale] {
        used.push(lab.shot(&place, &papers((side, side), POINTS))?.stats.direct.points_used as f64);
    }
    let growth = 100.0 * (used[1] / used[0] - 1.0);
    // Judge the claims.
    let claims = vec![
        Claim {
            claim: "The larger the picture, the larger the gain: slower at 50 × 50, faster at 800 × 800.".into(),
            paper: Some(3.29),
            ours: ratios[2],
            unit: "×".into(),
            verdict: Verdict::of(
                ratios[..3].windows(2).all(|pair| pair[1] > pair[0]) && ratios[0] < 1.0 && ratios[2] > 1.0,
                ratios[2] > ratios[0] && ratios[2] > 1.0,
            ),
            note: "The ratio at the third size; holds if ratios grow from below 1 to above 1.".into(),
        },
        Claim {
            claim: "A picture of eight times the size asks for hardly more mesh points.".into(),
            paper: Some(then),
            ours: growth,
            unit: "%".into(),
            verdict: Verdict::of(growth < 10.0, growth < 100.0),
            note: format!(
                "Points used at {large} × {large} over those at {small} × {small}{}, less 1; holds below 10%.",
                if lab.quick { ", both a quarter of that" } else { "" }
            ),
        },
    ];
    Ok(Section { tables: vec![table], figures: vec![plot.figure()?], claims, ..Section::default() })
}
