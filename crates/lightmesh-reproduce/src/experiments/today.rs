//! The paper's method and what came after it, on one scene.

use lightmesh::{Method, RenderOptions};

use super::lights::papers;
use crate::Error;
use crate::lab::{Lab, direct};
use crate::picture::figure;
use crate::report::{Claim, Section, Table, Verdict};
use crate::scenes::SceneName;

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(100))?;
    let size = if lab.quick { (240, 160) } else { (720, 480) };
    let path = RenderOptions { spp: 16, ..direct(Method::Path, size, 40.0) };
    let ways = [
        ("standard: a shadow ray to every light", direct(Method::Standard, size, 40.0)),
        ("path tracing, direct light, 16 samples", path),
        ("paper: scalar, spheres of 1.5, 1/40", papers(size, 40.0)),
        ("mesh: six axes, trilinear, 1/40", direct(Method::Mesh, size, 40.0)),
        ("hybrid, 1/40", direct(Method::Hybrid, size, 40.0)),
        ("unbiased, 4 rays, 1/40", direct(Method::Unbiased, size, 40.0)),
        ("mesh, --error 0.05", RenderOptions { error: Some(0.05), ..direct(Method::Mesh, size, 40.0) }),
    ];
    let options: Vec<RenderOptions> = ways.iter().map(|(_, options)| options.clone()).collect();
    let seconds = lab.race(&place, &options)?;
    let standard = lab.shot(&place, &options[0])?;
    let (mut rows, mut shots) = (Vec::new(), Vec::new());
    for ((name, options), &took) in ways.iter().zip(&seconds) {
        let shot = lab.shot(&place, options)?;
        // Path tracing has other samples in a pixel, and its edges with them.
        let error = 100.0 * shot.error(&standard);
        rows.push(vec![
            (*name).into(),
            took.into(),
            (seconds[0] / took).into(),
            error.into(),
            shot.stats.rays.shadow.into(),
        ]);
        shots.push(shot);
    }
    let columns = ["method", "seconds", "times as fast as standard", "error, %", "shadow rays"];
    let caption = format!(
        "100 lights, {} × {}, direct light, one sample at each pixel's centre but for path tracing, whose error includes its edges' \
         antialiasing.",
        size.0, size.1
    );
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let pictures: Vec<_> = [2, 3, 4, 0].map(|i: usize| (ways[i].0, &shots[i].image)).to_vec();
    let shown = figure("The room under 100 lights.", &pictures)?;
    let errors = [2, 3, 4].map(|i: usize| shots[i].error(&standard));
    let claims = vec![Claim {
        claim: "(Not the paper's:) what came after it is nearer to the truth: six axes than the scalar, single lights than six axes.".into(),
        paper: None,
        ours: 100.0 * errors[2],
        unit: "%".into(),
        verdict: Verdict::of(errors[1] < errors[0] && errors[2] < errors[1], errors[2] < errors[0]),
        note: format!(
            "Error of hybrid; holds if it is less than that of six axes ({:.1}%) and this less than the scalar's ({:.1}%).",
            100.0 * errors[1],
            100.0 * errors[0]
        ),
    }];
    Ok(Section { tables: vec![table], figures: vec![shown], claims, ..Section::default() })
}
