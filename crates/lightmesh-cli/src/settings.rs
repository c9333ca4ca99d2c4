//! The settings of a render as a picture file keeps them.

use lightmesh::{Aov, EmitterOptions, Falloff, PaperScale, RenderOptions, Spacing};
use lightmesh_io::Units;
use serde_json::json;

use crate::args::{EmitterArgs, EnvironmentArg, method_name, spell_interpolation, weight_name};

/// A JSON object with every option, spelled as the command line spells it.
pub fn json(options: &RenderOptions, emitters: &EmitterArgs, units: Units, camera: &str) -> String {
    let RenderOptions {
        method,
        width,
        height,
        spp,
        time_limit,
        bounces,
        depth,
        cutoff,
        spacing,
        indirect_spacing,
        gather_rays,
        error,
        refine,
        graded,
        rays,
        interpolation,
        weight,
        field_falloff,
        falloff,
        paper_scale,
        light_error,
        aovs,
        seed,
        max_memory,
    } = options;
    let EmitterOptions { light_samples, light_radius } = emitters.options();
    json!({
        "method": method_name(*method),
        "size": format!("{width}x{height}"),
        "spp": spp,
        "time-limit": time_limit.map(|limit| limit.as_secs_f64().to_string()),
        "bounces": bounces,
        "depth": depth,
        "cutoff": cutoff.to_string(),
        "spacing": spell_spacing(*spacing),
        "indirect-spacing": spell_spacing(*indirect_spacing),
        "gather-rays": gather_rays,
        "error": error.map(|error| error.to_string()),
        "refine": refine,
        "graded": graded.map(|metres| metres.to_string()),
        "rays": rays,
        "interpolation": spell_interpolation(*interpolation),
        "weight": weight_name(*weight),
        "field-falloff": spell_falloff(*field_falloff),
        "falloff": spell_falloff(*falloff),
        "paper-scale": match paper_scale {
            PaperScale::Visibility => "visibility",
            PaperScale::Constant => "constant",
        },
        "light-error": light_error.to_string(),
        "aov": aovs.iter().map(Aov::name).collect::<Vec<_>>().join(","),
        "environment": emitters.environment.as_ref().map(spell_environment),
        "environment-strength": emitters.environment_strength.to_string(),
        "environment-rotation": emitters.environment_rotation.to_string(),
        "light-samples": light_samples,
        "light-radius": light_radius.to_string(),
        "seed": seed,
        "max-memory": max_memory,
        "units": match units {
            Units::Gltf => "gltf",
            Units::Blender => "blender",
        },
        "camera": camera,
    })
    .to_string()
}

fn spell_spacing(spacing: Spacing) -> String {
    match spacing {
        Spacing::Auto => "auto".to_owned(),
        Spacing::Fraction(k) => format!("1/{k}"),
        Spacing::Metres(metres) => metres.to_string(),
    }
}

fn spell_environment(environment: &EnvironmentArg) -> String {
    match environment {
        EnvironmentArg::File(path) => path.display().to_string(),
        EnvironmentArg::Color(c) => format!("{},{},{}", c.x, c.y, c.z),
    }
}

fn spell_falloff(falloff: Falloff) -> String {
    match falloff {
        Falloff::InverseSquare => "r2".to_owned(),
        Falloff::ConstantPlusDistance { constant } => format!("{constant}+r"),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use lightmesh::{Interpolation, PointWeight};

    use super::*;
    use crate::args::{Cli, Command};

    #[test]
    fn options_are_spelled_as_on_the_command_line() {
        let options = RenderOptions {
            spacing: Spacing::Fraction(80.0),
            falloff: Falloff::ConstantPlusDistance { constant: 0.1 },
            interpolation: Interpolation::Sphere { radius: 2.5 },
            weight: PointWeight::Cosine,
            graded: Some(2.5),
            aovs: [Aov::Depth, Aov::Albedo].into_iter().collect(),
            ..RenderOptions::default()
        };
        let line =
            "lightmesh render a.glb -o a.png --environment 1,0.5,0 --environment-rotation -90 --light-radius 0.1";
        let Command::Render(args) = Cli::parse_from(line.split(' ')).command else { panic!("render was asked for") };
        let text = json(&options, &args.emitters, Units::Blender, "hall");
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
}
