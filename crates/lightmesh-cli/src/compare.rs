//! `lightmesh compare`.

use std::path::Path;

use anyhow::anyhow;
use glam::Vec3;
use lightmesh::metrics::{FLIP_PIXELS_PER_DEGREE, difference, flip};
use lightmesh_io::{
    Encoding, Picture,
    output::{auto_exposure, expose, tone_map},
    read_picture,
};
use serde::Serialize;

use crate::{args::CompareArgs, exit::Failure, terminal};

/// The result, as it is printed.
#[derive(Debug, Serialize)]
struct Comparison {
    relrmse: f64,
    bias: f64,
    max: f64,
    flip: f64,
}

/// Compares two pictures of the same size.
pub(crate) fn run(args: &CompareArgs) -> Result<(), Failure> {
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let size = |picture: &Picture| format!("{}x{}", picture.image.width, picture.image.height);
    if size(&a) != size(&b) {
        let (name_a, name_b) = (args.a.display(), args.b.display());
        return Err(Failure::Input(anyhow!("sizes differ: {name_a} is {}, {name_b} is {}", size(&a), size(&b))));
    }
    if a.encoding != b.encoding {
        let png = if a.encoding == Encoding::DisplayLinear { &args.a } else { &args.b };
        let name = png.display();
        terminal::warning(&format!(
            "{name} holds exposed, tone-mapped light: compared with cd/m², only flip means much"
        ));
    }
    let d = difference(&a.image.pixels, &b.image.pixels);
    let comparison = Comparison { relrmse: d.relrmse, bias: d.bias, max: d.max, flip: visible_difference(&a, &b) };
    let text = if args.json {
        serde_json::to_string_pretty(&comparison).map_err(Failure::work)?
    } else {
        let Comparison { relrmse, bias, max, flip } = comparison;
        format!("relrmse  {relrmse:.6}\nbias     {bias:+.6}\nmax      {max:.6}\nflip     {flip:.6}")
    };
    terminal::print(&text).map_err(Failure::work)
}

/// The mean FLIP error, 0 to 1, of `a` to the reference `b`: what light of a scene is shown as `render` writes a PNG,
/// exposed as the reference would be.
///
/// # Panics
/// If their sizes differ.
pub fn visible_difference(a: &Picture, b: &Picture) -> f64 {
    let ev = auto_exposure(&b.image.pixels);
    let (width, height) = (b.image.width as usize, b.image.height as usize);
    flip(&shown(a, ev), &shown(b, ev), width, height, FLIP_PIXELS_PER_DEGREE)
}

fn read(path: &Path) -> Result<Picture, Failure> {
    read_picture(path).map_err(Failure::input)
}

/// The picture as a display shows it: an EXR like a PNG that `render` writes at `ev`, a PNG as it is.
fn shown(picture: &Picture, ev: f32) -> Vec<Vec3> {
    match picture.encoding {
        Encoding::SceneLinear => picture.image.pixels.iter().map(|&p| tone_map(expose(p, ev))).collect(),
        Encoding::DisplayLinear => picture.image.pixels.clone(),
    }
}
