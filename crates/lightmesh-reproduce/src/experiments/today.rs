//! The paper's method and what came after it, on one scene.

use lightmesh::{Method, RenderOptions};

use super::lights::papers;
use crate::error::Error;
use crate::lab::{Lab, direct};
use crate::picture::figure;
use crate::report::{Claim, Figure, Section, Table, Verdict};
use crate::scenes::SceneName;

pub(super) fn run(lab: &mut Lab<'_>) -> Result<Section, Error> {
    let place = lab.place(SceneName::Room(100))?;
    let size = if lab.quick { (240, 160) } else { (720, 480) };

    // Time every method on the same scene.
    let ways = [
        ("standard: a shadow ray to every light", direct(Method::Standard, size, 40.0)),
        ("paper: scalar, spheres of 1.5, 1/40", papers(size, 40.0)),
        ("mesh: six axes, trilinear, 1/40", direct(Method::MESH, size, 40.0)),
        ("hybrid, 1/40", direct(Method::Hybrid, size, 40.0)),
        ("unbiased, 4 rays, 1/40", direct(Method::UNBIASED, size, 40.0)),
        ("mesh, --error 0.05", direct(Method::MESH, size, 40.0).with(|o| o.method = Method::with_error(0.05))),
    ];
    let options: Vec<RenderOptions> = ways.iter().map(|(_, options)| options.clone()).collect();
    let seconds = lab.race(&place, &options)?;

    // Compare each picture with exact light.
    let standard = lab.shot(&place, &options[0])?;
    let (mut rows, mut shots) = (Vec::new(), Vec::new());
    for ((name, options), &time) in ways.iter().zip(&seconds) {
        let shot = lab.shot(&place, options)?;
        let error = 100.0 * shot.error(&standard);
        rows.push(vec![
            (*name).into(),
            time.into(),
            (seconds[0] / time).into(),
            error.into(),
            shot.stats.rays.shadow.into(),
        ]);
        shots.push(shot);
    }

    // Put the numbers into a table and the pictures beside each other.
    let columns = ["method", "seconds", "times as fast as standard", "error, %", "shadow rays"];
    let caption = format!("100 lights, {} × {}, direct light, one sample at each pixel's centre.", size.0, size.1);
    let table = Table { caption, columns: columns.map(str::to_owned).to_vec(), rows };
    let pictures: Vec<_> = [1, 2, 3, 0].map(|i: usize| (ways[i].0, &shots[i].image)).to_vec();
    let shown = figure("The room under 100 lights.", &pictures)?;

    // Judge the claim.
    let errors = [1, 2, 3].map(|i: usize| shots[i].error(&standard));
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

    // Do the same with indirect light.
    let (all_light, shown_too) = all_light(lab)?;
    Ok(Section { tables: vec![table, all_light], figures: vec![shown, shown_too], claims, ..Section::default() })
}

/// Direct light and three bounces, against a path tracer that had much time.
fn all_light(lab: &mut Lab<'_>) -> Result<(Table, Figure), Error> {
    let place = lab.place(SceneName::Room(15))?;
    let (size, truth) = if lab.quick { ((60, 40), 64) } else { ((150, 100), 512) };
    let with = |options: RenderOptions, spp| {
        options.with(|o| {
            o.transport.bounces = 3;
            o.picture.spp = spp;
        })
    };

    // Time path tracing, the paper's method and ours.
    let ways = [
        ("path, 4 samples", with(direct(Method::Path, size, 40.0), 4)),
        ("path, 32 samples", with(direct(Method::Path, size, 40.0), 32)),
        ("paper: scalars, spheres of 1.5, 1/40", with(papers(size, 40.0), 4)),
        ("mesh, 1/40", with(direct(Method::MESH, size, 40.0), 4)),
        ("hybrid, 1/40", with(direct(Method::Hybrid, size, 40.0), 4)),
    ];
    let options: Vec<RenderOptions> = ways.iter().map(|(_, options)| options.clone()).collect();
    let seconds = lab.race(&place, &options)?;

    // Render the truth, with other random numbers than those of the paths that are compared with it.
    let path = RenderOptions { seed: 1, ..with(direct(Method::Path, size, 40.0), truth) };
    let path = lab.shot(&place, &path)?;

    // Compare each picture with the truth.
    let (mut rows, mut shots) = (Vec::new(), Vec::new());
    for ((name, options), &time) in ways.iter().zip(&seconds) {
        let shot = lab.shot(&place, options)?;
        rows.push(vec![(*name).into(), time.into(), (100.0 * shot.error(&path)).into()]);
        shots.push(shot);
    }

    // Put the numbers into a table and the pictures beside each other.
    let caption = format!(
        "15 lights, {} × {}, direct light and three bounces, 4 samples per pixel unless said, against path tracing with {truth} \
         ({:.0} s), whose own noise is in every error.",
        size.0,
        size.1,
        path.seconds()
    );
    let columns = ["method", "seconds", "error, %"].map(str::to_owned).to_vec();
    let name = format!("path, {truth} samples");
    let mut pictures: Vec<_> = [0, 2, 3].map(|i: usize| (ways[i].0, &shots[i].image)).to_vec();
    pictures.push((&name, &path.image));
    Ok((Table { caption, columns, rows }, figure("The room under 15 lights, all of its light.", &pictures)?))
}
