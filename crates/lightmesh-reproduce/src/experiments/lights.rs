//! Table 1: standard against modified tracing by the number of lights.

use lightmesh::{Interpolation, Method, RenderOptions};

use crate::error::Error;
use crate::lab::{Lab, direct};
use crate::picture;
use crate::plot::{Line, Plot, SeriesLabelPosition};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

/// Numbers of lights, and the ratio of times that the paper has for them.
const LIGHTS: [(usize, Option<f64>); 7] =
    [(5, Some(1.48)), (10, Some(1.65)), (15, Some(1.69)), (50, None), (100, None), (500, None), (1000, None)];

/// Points along the longest edge.
const POINTS: f32 = 40.0;

/// The paper's method as it is used throughout: the scalar field, spheres of one and a half spacings.
pub(super) fn papers(size: (u32, u32), points: f32) -> RenderOptions {
    direct(Method::PAPER, size, points).with(|o| o.mesh.interpolation = Interpolation::Sphere { radius: 1.5 })
}

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let size = if lab.quick { (160, 160) } else { (800, 800) };

    // Time exact light, the paper's method and ours for every number of lights.
    let ways = [direct(Method::Standard, size, POINTS), papers(size, POINTS), direct(Method::MESH, size, POINTS)];
    let mut rows = Vec::new();
    let (mut ratios, mut lines) = (Vec::new(), ["standard", "paper", "mesh"].map(|name| (name, Vec::new())));
    for (count, papers) in LIGHTS {
        let place = lab.place(SceneName::Room(count))?;
        let seconds = lab.race(&place, &ways)?;
        let [standard, paper, mesh] = [0, 1, 2].map(|i| lab.shot(&place, &ways[i]));
        let (standard, paper, mesh) = (standard?, paper?, mesh?);
        ratios.push(seconds[0] / seconds[1]);
        for (line, &seconds) in lines.iter_mut().zip(&seconds) {
            line.1.push((count as f64, seconds));
        }
        rows.push(vec![
            (count as u64).into(),
            seconds[0].into(),
            seconds[1].into(),
            (seconds[0] / seconds[1]).into(),
            papers.into(),
            (100.0 * paper.error(&standard)).into(),
            standard.stats.rays.shadow.into(),
            paper.stats.rays.shadow.into(),
            seconds[2].into(),
            (seconds[0] / seconds[2]).into(),
            (100.0 * mesh.error(&standard)).into(),
        ]);
    }

    // Put the numbers into a table and a plot.
    let columns = [
        "lights",
        "standard, s",
        "paper, s",
        "ratio",
        "ratio in 2001",
        "error, %",
        "shadow rays, standard",
        "shadow rays, paper",
        "mesh, s",
        "ratio",
        "error, %",
    ];
    let caption = format!(
        "{} × {}, one sample at each pixel's centre, direct light, mesh of 1/{POINTS} of the room's length; all threads, medians of \
         interleaved runs. paper: the scalar field read in spheres of 1.5 spacings; mesh: six axes, trilinear.",
        size.0, size.1
    );
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let plot = Plot {
        caption: "Render time by the number of lights.",
        x: "point lights of the same intensity together",
        y: "seconds",
        names: SeriesLabelPosition::UpperLeft,
        logarithmic: true,
        lines: lines.map(|(name, points)| Line { name: name.to_owned(), points }).into(),
    };

    // Show the three pictures of one of the scenes.
    let place = lab.place(SceneName::Room(15))?;
    let pictures = [lab.shot(&place, &ways[1])?, lab.shot(&place, &ways[2])?, lab.shot(&place, &ways[0])?];
    let shown = picture::figure(
        "The room under 15 lights.",
        &[("paper", &pictures[0].image), ("mesh", &pictures[1].image), ("standard", &pictures[2].image)],
    )?;

    // Judge the claims. Times of small pictures are noisy.
    let first = &ratios[..3];
    let slack = if lab.quick { 0.8 } else { 0.95 };
    let claims = vec![
        Claim {
            claim: "With 5, 10 and 15 lights modified tracing is faster than standard tracing.".into(),
            paper: Some(1.48),
            ours: first.iter().copied().fold(f64::INFINITY, f64::min),
            unit: "×".into(),
            verdict: Verdict::of(first.iter().all(|&r| r > 1.0), first[2] > 1.0),
            note: "The smallest of the three ratios; holds if it is above 1.".into(),
        },
        Claim {
            claim: "The more lights, the larger the gain.".into(),
            paper: Some(1.69 / 1.48),
            ours: first[2] / first[0],
            unit: "×".into(),
            verdict: Verdict::of(
                ratios.windows(2).all(|pair| pair[1] > slack * pair[0]) && first[2] > first[0],
                ratios[6] > ratios[0],
            ),
            note: "The ratio with 15 lights over that with 5; holds if it is above 1 and ratios grow all the way to 1000 lights.".into(),
        },
    ];
    Ok(Section { tables: vec![table], figures: vec![plot.figure()?, shown], claims, ..Section::default() })
}
