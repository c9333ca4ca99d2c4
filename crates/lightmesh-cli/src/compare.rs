//! `lightmesh compare`.

use std::path::Path;

use anyhow::anyhow;
use lightmesh::metrics::difference;
use lightmesh_io::{Encoding, Picture, read_picture};
use serde::Serialize;

use crate::{args::CompareArgs, exit::Failure, terminal};

/// What is printed.
#[derive(Debug, Serialize)]
struct Comparison {
    relrmse: f64,
    bias: f64,
    max: f64,
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
    let comparison = Comparison { relrmse: d.relrmse, bias: d.bias, max: d.max };
    let text = if args.json {
        serde_json::to_string_pretty(&comparison).map_err(Failure::work)?
    } else {
        format!("relrmse  {:.6}\nbias     {:+.6}\nmax      {:.6}", comparison.relrmse, comparison.bias, comparison.max)
    };
    terminal::print(&text).map_err(Failure::work)
}

fn read(path: &Path) -> Result<Picture, Failure> {
    read_picture(path).map_err(Failure::input)
}
