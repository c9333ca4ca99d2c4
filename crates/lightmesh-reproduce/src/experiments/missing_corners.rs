//! Figures 10-11: the rules for missing corners.

use lightmesh::{Interpolation, Method, MissingCorners};

use crate::error::Error;
use crate::lab::{Lab, direct};
use crate::picture::{Rect, enlarged, figure, luminance};
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

/// The part of the picture that is enlarged, in fractions of its size: boxes on the floor before a wall.
const PART: Rect<f32> = Rect { left: 0.72, top: 0.5, width: 0.28, height: 0.42 };

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(15))?;
    let size = if lab.quick { (240, 160) } else { (720, 480) };
    let with = |interpolation| direct(Method::PAPER, size, 40.0).with(|o| o.mesh.interpolation = interpolation);
    let rule = |rule| with(Interpolation::TrilinearWith(rule));

    // List the rules.
    let ways = [
        ("zero", rule(MissingCorners::Zero)),
        ("one", rule(MissingCorners::One)),
        ("nearest", rule(MissingCorners::Nearest)),
        ("mirror", rule(MissingCorners::Mirror)),
        ("left out, half a cell off the surface (trilinear)", with(Interpolation::Trilinear)),
    ];

    // Measure how far each is from exact light, and whether it is brighter or darker.
    let standard = lab.shot(&place, &direct(Method::Standard, size, 40.0))?;
    let mean = |image: &lightmesh::Image| image.pixels.iter().map(|&p| luminance(p)).sum::<f64>();
    let (mut rows, mut shots, mut biases, mut errors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (name, options) in &ways {
        let shot = lab.shot(&place, options)?;
        biases.push(100.0 * (mean(&shot.image) / mean(&standard.image) - 1.0));
        errors.push(100.0 * shot.error(&standard));
        let (error, bias) = (errors[errors.len() - 1], biases[biases.len() - 1]);
        rows.push(vec![(*name).into(), error.into(), bias.into()]);
        shots.push(shot);
    }

    // Put the numbers into a table.
    let caption = format!(
        "The paper's scalar field under 15 lights, 1/40, {} × {}, direct light: --interpolation trilinear:RULE.",
        size.0, size.1
    );
    let columns = ["a missing corner counts as", "error, %", "bias, %"].map(str::to_owned).to_vec();
    let table = Table { caption, columns, rows };

    // Enlarge the edges of boxes, where corners are missing.
    let part = PART.to_pixels(size);
    let times = if lab.quick { 4 } else { 2 };
    let parts: Vec<_> = shots.iter().chain([&standard]).map(|shot| enlarged(&shot.image, part, times)).collect();
    let names = ways.iter().map(|(name, _)| *name).chain(["standard"]);
    let shown = figure("Boxes on the floor, enlarged.", &names.zip(&parts).collect::<Vec<_>>())?;

    // Judge the claim.
    let claims = vec![Claim {
        claim: "Where missing corners count as zero edges are dark, where they count as one they are bright.".into(),
        paper: None,
        ours: biases[1] - biases[0],
        unit: "% of the light".into(),
        verdict: Verdict::of(biases[0] < biases[2] && biases[2] < biases[1], biases[0] < biases[1]),
        note: format!(
            "Mean light with one less that with zero; holds if that of the nearest corner's value ({:+.1}% off exact light) lies between \
             them ({:+.1} and {:+.1}%).",
            biases[2], biases[0], biases[1]
        ),
    }];
    Ok(Section { tables: vec![table], figures: vec![shown], claims, ..Section::default() })
}
