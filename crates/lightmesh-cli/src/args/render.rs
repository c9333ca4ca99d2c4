//! Arguments of `render`.

use std::{path::PathBuf, time::Duration};

use clap::{Args, ValueEnum, value_parser};
use lightmesh::{Aov, Falloff, Interpolation, Method, RenderOptions, Spacing};
use lightmesh_io::{LoadOptions, Units};

use super::{
    aov,
    emitters::EmitterArgs,
    exposure::{self, Exposure},
    falloff, interpolation, memory,
    method::{MethodArg, PaperScaleArg},
    size::{self, Size},
    spacing, time_limit,
    weight::WeightArg,
};

const EXAMPLES: &str = "\
Examples:
  lightmesh render room.glb -o room.png
  lightmesh render room.glb -o room.exr -o room.png --size 1920x1080 --spp 16 --spacing 1/80 --stats room.json
  lightmesh render room.glb -o room.png --method path --time-limit 60 --preview so-far.png";

/// The most samples per pixel where time is what limits them.
const MOST_SPP: u32 = 1 << 16;

/// The arguments of `render`. Defaults are those of [`RenderOptions`]; a test holds them together.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RenderArgs {
    /// Scene file: .gltf, .glb, .obj or .ply
    pub(crate) scene: PathBuf,

    /// Picture to write: .png (exposed, tone mapped, sRGB) or .exr (linear cd/m²); may be given several times
    #[arg(short, long = "output", value_name = "FILE", required = true, help_heading = "Output")]
    pub(crate) output: Vec<PathBuf>,
    /// Width and height in pixels [default: 1280 wide, height from the camera's aspect]
    #[arg(long, value_name = "WxH", value_parser = size::parse, allow_hyphen_values = true, help_heading = "Output")]
    pub(crate) size: Option<Size>,
    /// Exposure of PNG files: 2^EV times the luminance in cd/m², then the tone map; auto: 18% grey with highlights kept
    #[arg(long, value_name = "EV|auto", default_value = "auto", value_parser = exposure::parse, allow_hyphen_values = true, help_heading = "Output")]
    pub(crate) exposure: Exposure,
    /// Write 16-bit instead of 32-bit floats to EXR files
    #[arg(long, help_heading = "Output")]
    pub(crate) half: bool,
    /// Layers that .exr files get beside the light (docs/aov.md), separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = aov::parser(), help_heading = "Output")]
    aov: Vec<Aov>,
    /// Write the picture so far to this .png, exposed and tone mapped, about once a second while it improves; it
    /// changes nothing of the finished picture, which it becomes
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) preview: Option<PathBuf>,
    /// Write seconds, rays, mesh points and memory as JSON
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) stats: Option<PathBuf>,
    /// Write what the light mesh knows after the render to this file, for --mesh
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) save_mesh: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(long, short, help_heading = "Output")]
    pub(crate) quiet: bool,

    /// How light is computed
    #[arg(long, value_enum, default_value = "mesh", help_heading = "Light")]
    method: MethodArg,
    /// Keep the error of the light, relative to the picture's mean, at most so large (0.05 is 5%); with --method mesh:
    /// it then reads the mesh light by light and shoots as many shadow rays as that takes, all of them where lights are
    /// few
    #[arg(long, value_name = "E", allow_hyphen_values = true, help_heading = "Light")]
    error: Option<f32>,
    /// Samples per pixel, 1 to 65536; box filter of one pixel; 1 samples the pixel's centre [default: 4; with
    /// --time-limit, which makes it the most, 65536]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..), help_heading = "Light")]
    spp: Option<u32>,
    /// Take samples until the render, from the built scene on, has taken this long; every pixel gets one, however long
    /// that takes. How many there are in time is never quite the same, and nor is the picture
    #[arg(long, value_name = "SECONDS", value_parser = time_limit::parse, allow_hyphen_values = true, help_heading = "Light")]
    pub(crate) time_limit: Option<Duration>,
    /// Diffuse interreflections, 0 to 4096; 0: direct light only; 1: the paper; --method standard computes none
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().bounces, value_parser = value_parser!(u32).range(..=4096), help_heading = "Light")]
    bounces: u32,
    /// Mirror and refraction events that a ray may meet in a row
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().depth, help_heading = "Light")]
    depth: u32,
    /// Drop mirrored and refracted rays that carry less than this fraction of the light, 0 to below 1
    #[arg(long, value_name = "FRACTION", default_value_t = RenderOptions::default().cutoff, value_parser = fraction, allow_hyphen_values = true, help_heading = "Light")]
    cutoff: f32,
    /// Attenuation of light with distance: r2 (physical) or C+r, C in metres (the paper's phi 3)
    #[arg(long, value_name = "r2|C+r", default_value = "r2", value_parser = falloff::parse, allow_hyphen_values = true, help_heading = "Light")]
    falloff: Falloff,
    /// Error of the sum over more than 512 lights or light samples, as a part of all light that arrives at a place, 0
    /// to below 1; 0: every light by itself, as --method standard and path always do
    #[arg(long, value_name = "FRACTION", default_value_t = RenderOptions::default().light_error, value_parser = fraction, allow_hyphen_values = true, help_heading = "Light")]
    light_error: f32,
    /// Seed of all randomness
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().seed, help_heading = "Light")]
    seed: u64,

    #[command(flatten)]
    pub(crate) emitters: EmitterArgs,

    /// Go on with the light mesh in this file, which --save-mesh wrote for the same scene and the same settings of the
    /// mesh; the picture is the same, and sooner
    #[arg(long, value_name = "FILE", help_heading = "Light mesh")]
    pub(crate) mesh: Option<PathBuf>,
    /// Distance between mesh points: metres, 1/K of the longest edge of the scene's box, or auto (1/64)
    #[arg(long, value_name = "METRES|1/K|auto", default_value = "auto", value_parser = spacing::parse, allow_hyphen_values = true, help_heading = "Light mesh")]
    spacing: Spacing,
    /// Distance between points of the indirect mesh; auto is 1/30, with --error 1/45
    #[arg(long, value_name = "METRES|1/K|auto", default_value = "auto", value_parser = spacing::parse, allow_hyphen_values = true, help_heading = "Light mesh")]
    indirect_spacing: Spacing,
    /// Rays that gather light at a point of the indirect mesh, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().gather_rays, value_parser = value_parser!(u32).range(1..=65536), help_heading = "Light mesh")]
    gather_rays: u32,
    /// How often the meshes may halve their spacing where their light is not good enough, 0 to 4 [default: 0, with
    /// --error 2]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(..=4), help_heading = "Light mesh")]
    refine: Option<u32>,
    /// Let the meshes' density fall with the distance from the camera: nearer than this half the spacing, nearer than
    /// half of it a quarter, nearer than a quarter of it an eighth
    #[arg(long, value_name = "METRES", allow_hyphen_values = true, help_heading = "Light mesh")]
    graded: Option<f32>,
    /// Shadow rays, and gather rays if there are bounces, at each hit with --method unbiased, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = RenderOptions::default().rays, value_parser = value_parser!(u32).range(1..=65536), help_heading = "Light mesh")]
    rays: u32,
    /// Mesh points that a surface reads: trilinear, nearest, or sphere[:R], R in spacings, at most 16 (sphere: 1.5);
    /// auto: trilinear, with --method paper sphere. trilinear:RULE is the paper's: corners behind the surface count as
    /// zero or one (no or all light), or as the nearest or the mirror corner does; with --method mesh and paper
    #[arg(long, value_name = "WHICH", default_value = "auto", value_parser = interpolation::parse, help_heading = "Light mesh")]
    interpolation: Interpolation,
    /// How much each point of the sphere counts (phi 4 and phi 5), with --interpolation sphere
    #[arg(long, value_enum, default_value = "constant", help_heading = "Light mesh")]
    weight: WeightArg,
    /// Attenuation inside the direct field of --method paper (phi 1)
    #[arg(long, value_name = "r2|C+r", default_value = "r2", value_parser = falloff::parse, allow_hyphen_values = true, help_heading = "Light mesh")]
    field_falloff: Falloff,
    /// Scale of the mean in --method paper
    #[arg(long, value_enum, default_value = "visibility", help_heading = "Light mesh")]
    paper_scale: PaperScaleArg,

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

    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=4096), help_heading = "Machine")]
    pub(crate) threads: Option<u32>,
    /// Most memory that the render may take, in B, KB, MB, GB, KiB, MiB or GiB; more is an error before allocation
    #[arg(long, value_name = "SIZE", default_value = memory::DEFAULT, value_parser = memory::parse, allow_hyphen_values = true, help_heading = "Machine")]
    max_memory: u64,
}

/// `--units`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum UnitsArg {
    /// Candela and lux, as the specification says
    Gltf,
    /// Blender's exporter: divide punctual lights by 683
    Blender,
}

/// Parses `--cutoff` and `--light-error`.
fn fraction(text: &str) -> Result<f32, String> {
    let value = text.parse().ok().filter(|x: &f32| (0.0..1.0).contains(x));
    value.ok_or_else(|| "expected a number of at least 0 and below 1".to_owned())
}

impl RenderArgs {
    /// The library's options but for the size, which may need the camera.
    pub(crate) fn options(&self) -> RenderOptions {
        let default = RenderOptions::default();
        let method = Method::from(self.method);
        RenderOptions {
            method,
            width: self.size.map_or(default.width, |size| size.width),
            height: self.size.map_or(default.height, |size| size.height),
            spp: self.spp.unwrap_or(if self.time_limit.is_some() { MOST_SPP } else { default.spp }),
            time_limit: self.time_limit,
            bounces: self.bounces,
            depth: self.depth,
            cutoff: self.cutoff,
            spacing: self.spacing,
            indirect_spacing: self.indirect_spacing,
            gather_rays: self.gather_rays,
            error: self.error,
            refine: self.refine,
            graded: self.graded,
            rays: self.rays,
            interpolation: self.interpolation,
            weight: self.weight.into(),
            field_falloff: self.field_falloff,
            falloff: self.falloff,
            paper_scale: self.paper_scale.into(),
            light_error: self.light_error,
            aovs: self.aov.iter().copied().collect(),
            seed: self.seed,
            max_memory: self.max_memory,
        }
    }

    /// Returns the options of reading the scene file.
    pub(crate) fn load_options(&self) -> LoadOptions {
        LoadOptions {
            units: match self.units {
                UnitsArg::Gltf => Units::Gltf,
                UnitsArg::Blender => Units::Blender,
            },
            allow_outside: self.allow_outside,
            scene: self.scene_name.clone(),
            max_memory: self.max_memory,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use lightmesh::EmitterOptions;

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

    /// Nothing said: the library's defaults, all of them.
    #[test]
    fn defaults_are_the_librarys() {
        let args = parse(&[]).unwrap();
        assert_eq!(args.options(), RenderOptions::default());
        assert_eq!(args.emitters.options(), EmitterOptions::default());
    }

    /// With a time limit, samples are as many as there is time for, unless a number is said.
    #[test]
    fn a_time_limit_makes_samples_the_most() {
        let spp = |args: &[&str]| parse(args).unwrap().options().spp;
        assert_eq!(spp(&["--time-limit", "2"]), 65536);
        assert_eq!(spp(&["--time-limit", "2", "--spp", "8"]), 8);
    }

    #[test]
    fn negative_values_reach_their_parsers() {
        for (flag, value) in [
            ("--spacing", "-1"),
            ("--time-limit", "-1"),
            ("--cutoff", "-0.5"),
            ("--light-error", "-0.5"),
            ("--size", "-1x2"),
            ("--falloff", "-1+r"),
            ("--environment", "-1,0,0"),
            ("--light-radius", "-1"),
            ("--environment-strength", "-2"),
        ] {
            let message = parse(&[flag, value]).unwrap_err().to_string();
            assert!(message.contains(flag) && message.contains("invalid value"), "{message}");
        }
        assert_eq!(parse(&["--exposure", "-3.5"]).unwrap().exposure, Exposure::Ev(-3.5));
        assert_eq!(parse(&["--environment-rotation", "-90"]).unwrap().emitters.environment_rotation, -90.0);
    }
}
