//! The settings of a render as a picture file keeps them.

use lightmesh::RenderOptions;
use lightmesh::schema::{Entry, Kind, RENDER, Value};
use lightmesh_io::Units;
use serde_json::{Map, json};

use crate::args::{EmitterArgs, SURROUNDINGS, Surroundings};

/// Returns a JSON object with every option, spelled as the command line spells it: whole numbers as numbers, everything
/// else as text.
pub fn json(options: &RenderOptions, emitters: &EmitterArgs, units: Units, camera: &str) -> String {
    let mut settings = Map::new();
    let surroundings = Surroundings { emitters: emitters.clone(), threads: None };
    // The picture is the same for every number of threads, and for every limit of memory that it keeps to.
    // The quality is the error by name.
    let render = RENDER.iter().filter(|entry| !["max-memory", "quality"].contains(&entry.about.name));
    render.for_each(|entry| put(&mut settings, entry, options));
    let of_light = SURROUNDINGS.iter().filter(|entry| entry.about.name != "threads");
    of_light.for_each(|entry| put(&mut settings, entry, &surroundings));
    let units = match units {
        Units::Gltf => "gltf",
        Units::Blender => "blender",
    };
    settings.insert("units".to_owned(), json!(units));
    settings.insert("camera".to_owned(), json!(camera));
    serde_json::Value::Object(settings).to_string()
}

fn put<T>(settings: &mut Map<String, serde_json::Value>, entry: &Entry<T>, options: &T) {
    let value = (entry.get)(options).map(|value| match (value, entry.about.kind) {
        (Value::Whole(n), Kind::Whole(..)) => json!(n),
        (value, _) => json!(value.to_string()),
    });
    settings.insert(entry.about.key().to_owned(), value.unwrap_or_default());
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use lightmesh::{Aov, Falloff, Interpolation, Method, PaperScale, PointWeight, Spacing};

    use super::*;
    use crate::args::{Cli, Command};

    #[test]
    fn options_are_spelled_as_on_the_command_line() {
        let options = RenderOptions::default().with(|o| {
            o.mesh.spacing = Spacing::Fraction(80.0);
            o.transport.falloff = Falloff::ConstantPlusDistance { constant: 0.1 };
            o.mesh.interpolation = Interpolation::Sphere { radius: 2.5 };
            o.mesh.weight = PointWeight::Cosine;
            o.mesh.lod_distance = Some(2.5);
            o.picture.aovs = [Aov::Depth, Aov::Albedo].into_iter().collect();
        });
        let line =
            "lightmesh render a.glb -o a.png --environment 1,0.5,0 --environment-rotation -90 --light-radius 0.1";
        let Command::Render(args) = Cli::parse_from(line.split(' ')).command else { panic!("render was asked for") };
        let text = json(&options, &args.surroundings().emitters, Units::Blender, "hall");
        for part in [
            r#""spacing":"1/80""#,
            r#""falloff":"0.1+r""#,
            r#""interpolation":"sphere:2.5""#,
            r#""weight":"cosine""#,
            r#""graded":"2.5""#,
            r#""size":"1280x720""#,
            r#""camera":"hall""#,
            r#""aov":"albedo,depth""#,
            r#""cutoff":"0.001""#,
            r#""units":"blender""#,
            r#""environment":"1,0.5,0""#,
            r#""environment-strength":"1""#,
            r#""environment-rotation":"-90""#,
            r#""light-samples":64"#,
            r#""light-radius":"0.1""#,
        ] {
            assert!(text.contains(part), "{text}");
        }
    }

    /// Pinned, byte for byte: files of several versions are compared.
    #[test]
    fn the_text_never_changes() {
        let text = |options: &RenderOptions| json(options, &EmitterArgs::default(), Units::Gltf, "");
        assert_eq!(
            text(&RenderOptions::default()),
            concat!(
                r#"{"aov":"","bounces":3,"camera":"","cutoff":"0.001","depth":8,"environment":null,"#,
                r#""environment-rotation":"0","environment-strength":"1","error":null,"falloff":"r2","field-falloff":"r2","#,
                r#""gather-rays":null,"graded":null,"indirect-spacing":"auto","interpolation":"auto","light-error":"0.01","#,
                r#""light-radius":"0","light-samples":64,"method":"mesh","most-spp":null,"near-rays":16,"paper-scale":"visibility","#,
                r#""rays":4,"refine":null,"seed":0,"size":"1280x720","spacing":"auto","spp":4,"time-limit":null,"#,
                r#""units":"gltf","weight":"constant"}"#
            )
        );
        let paper = Method::Paper {
            field_falloff: Falloff::ConstantPlusDistance { constant: 0.1 },
            scale: PaperScale::Constant,
        };
        let paper = text(&RenderOptions { method: paper, ..RenderOptions::default() });
        assert!(
            paper.contains(r#""field-falloff":"0.1+r""#) && paper.contains(r#""paper-scale":"constant""#),
            "{paper}"
        );
        let bounded = text(&RenderOptions { method: Method::with_error(0.05), ..RenderOptions::default() });
        assert!(bounded.contains(r#""error":"0.05""#) && bounded.contains(r#""method":"auto""#), "{bounded}");
    }
}
