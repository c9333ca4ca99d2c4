//! Arguments of `render`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use lightmesh::{Error, Quality, RenderOptions};
use lightmesh_io::{LoadOptions, Units};

use super::{
    choices::{Chosen, Surroundings},
    exposure::{self, Exposure},
};

const EXAMPLES: &str = "\
Examples:
  lightmesh render room.glb -o room.png
  lightmesh render room.glb -o room.exr -o room.png --size 1920x1080 --spp 16 --spacing 1/80 --stats room.json
  lightmesh render room.glb -o room.png --method path --time-limit 60 --preview so-far.png";

/// The arguments of `render`: those of files and messages, and the options that Python has, too.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RenderArgs {
    /// Scene file: .gltf, .glb, .obj or .ply
    pub(crate) scene: PathBuf,

    /// Picture to write: .png (exposed, tone mapped, sRGB, dithered) or .exr (linear cd/m²); may be given several times.
    /// No output may be a file that is read
    #[arg(short, long = "output", value_name = "FILE", required = true, help_heading = "Output")]
    pub(crate) output: Vec<PathBuf>,
    /// Exposure of PNG files: 2^EV times the luminance in cd/m², then the tone map; auto: by the light about the camera; unlit surfaces keep their colour
    #[arg(long, value_name = "EV|auto", default_value = "auto", value_parser = exposure::parse, allow_hyphen_values = true, help_heading = "Output")]
    pub(crate) exposure: Exposure,
    /// Write 16-bit instead of 32-bit floats to EXR files
    #[arg(long, help_heading = "Output")]
    pub(crate) half: bool,
    /// Write the picture so far to this .png, exposed and tone mapped, about once a second while it improves; it
    /// changes nothing of the finished picture, which it becomes
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) preview: Option<PathBuf>,
    /// Write seconds, rays, mesh points and memory as JSON
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) stats: Option<PathBuf>,
    /// Write what the light mesh knows after the render to this file, for --mesh; it may not be the one that --mesh reads
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) save_mesh: Option<PathBuf>,
    /// Exit with 3 where --error is not kept; the picture is written all the same
    #[arg(long, help_heading = "Output")]
    pub(crate) strict: bool,
    /// Take the noise out of the finished picture with Open Image Denoise (docs/denoising.md), which is installed apart, as by
    /// `pip install pyoidn`; the picture is then not bit for bit the same on every machine. With --quality preview it is done
    /// wherever the library is installed
    #[arg(long, help_heading = "Output")]
    pub(crate) denoise: bool,
    /// Say nothing but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,

    /// Go on with the light mesh in this file, which --save-mesh wrote for the same scene and the same settings of the
    /// mesh; the picture is the same, and sooner
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) mesh: Option<PathBuf>,

    /// Camera by name or index [default: the first; none in the file: one that frames the scene]
    #[arg(long, value_name = "NAME|INDEX", allow_hyphen_values = true, help_heading = "Scene")]
    pub(crate) camera: Option<String>,
    /// Scene of the file by name or index [default: the file's own choice]
    #[arg(long = "scene", value_name = "NAME|INDEX", allow_hyphen_values = true, help_heading = "Scene")]
    scene_name: Option<String>,
    /// Units of the file's lights: gltf (candela, lux) or blender (its exporter's, 683 times as much)
    #[arg(long, value_enum, default_value = "gltf", help_heading = "Scene")]
    units: UnitsArg,
    /// Let the scene's URIs leave its folder
    #[arg(long, help_heading = "Scene")]
    allow_outside: bool,

    #[command(flatten)]
    pub(crate) chosen: Chosen,
}

/// `--units`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum UnitsArg {
    /// Candela and lux, as the specification says
    Gltf,
    /// Blender's exporter: divide punctual lights by 683
    Blender,
}

impl RenderArgs {
    /// Returns the library's options, checked, but for a size that may need the camera.
    pub(crate) fn options(&self) -> Result<RenderOptions, Error> {
        self.chosen.render_options()
    }

    /// Returns whether `--quality preview` is asked for.
    pub(crate) fn is_preview(&self) -> bool {
        self.chosen.get("quality").is_some_and(|quality| quality.as_text() == Quality::Preview.name())
    }

    /// Returns what there is beside the library's options.
    pub(crate) fn surroundings(&self) -> Surroundings {
        self.chosen.surroundings()
    }

    /// Returns the options of reading the scene file.
    pub(crate) fn load_options(&self, max_memory: u64) -> LoadOptions {
        LoadOptions {
            units: match self.units {
                UnitsArg::Gltf => Units::Gltf,
                UnitsArg::Blender => Units::Blender,
            },
            allow_outside: self.allow_outside,
            scene: self.scene_name.clone(),
            max_memory,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use lightmesh::{Limits, Method, Spacing};

    use super::{
        super::{Cli, Command},
        *,
    };

    fn parse(args: &[&str]) -> Result<Box<RenderArgs>, clap::Error> {
        let all = ["lightmesh", "render", "a.glb", "-o", "a.png"].iter().chain(args);
        Cli::try_parse_from(all).map(|cli| match cli.command {
            Command::Render(args) => args,
            _ => unreachable!("render was asked for"),
        })
    }

    fn options(args: &[&str]) -> RenderOptions {
        parse(args).unwrap().options().unwrap()
    }

    /// Nothing said: the library's defaults but for the memory, which depends on the machine, the method *auto*, and samples
    /// that follow the noise.
    #[test]
    fn defaults_are_the_librarys() {
        let limits = Limits { max_memory: crate::machine::default_limit() };
        let expected = RenderOptions { limits, method: Method::AUTO, ..RenderOptions::default() };
        let expected = expected.with(|o| o.picture.most_spp = Some(64));
        assert_eq!(options(&[]), expected);
        assert_eq!(parse(&[]).unwrap().surroundings(), Surroundings::default());
    }

    #[test]
    fn what_is_said_reaches_the_options() {
        let options = options(&["--graded", "2.5", "--aov", "depth", "--aov", "albedo", "--spacing", "1/80"]);
        assert_eq!((options.method, options.mesh.lod_distance), (Method::AUTO, Some(2.5)));
        assert_eq!((options.picture.aovs.iter().count(), options.mesh.spacing), (2, Spacing::Fraction(80.0)));
    }

    #[test]
    fn exact_is_standard() {
        assert_eq!(options(&["--method", "exact"]), options(&["--method", "standard"]));
    }

    /// With a time limit, samples are as many as there is time for, unless a number is said.
    #[test]
    fn a_time_limit_makes_samples_the_most() {
        assert_eq!(options(&["--time-limit", "2"]).picture.spp, 65536);
        assert_eq!(options(&["--time-limit", "2", "--spp", "8"]).picture.spp, 8);
    }

    #[test]
    fn negative_values_reach_their_parsers() {
        for (flag, value) in [
            ("--spacing", "-1"),
            ("--time-limit", "-1"),
            ("--cutoff", "-0.5"),
            ("--light-error", "-0.5"),
            ("--size", "-1x2"),
            ("--spp", "-1"),
            ("--falloff", "-1+r"),
            ("--environment", "-1,0,0"),
            ("--light-radius", "-1"),
            ("--environment-strength", "-2"),
        ] {
            let message = parse(&[flag, value]).unwrap_err().to_string();
            assert!(message.contains(flag) && message.contains("invalid value"), "{message}");
        }
        assert_eq!(parse(&["--exposure", "-3.5"]).unwrap().exposure, Exposure::Ev(-3.5));
        let turned = parse(&["--environment-rotation", "-90"]).unwrap().surroundings();
        assert_eq!(turned.emitters.environment_rotation, -90.0);
    }
}
