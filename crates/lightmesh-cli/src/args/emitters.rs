//! Light with a size: the environment, lamps with a radius, and how many samples stand for each.

use clap::{Args, value_parser};
use lightmesh::EmitterOptions;

use super::environment::{self, EnvironmentArg};

/// Defaults are those of [`EmitterOptions`]; a test holds them together.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct EmitterArgs {
    /// Light from all sides, in place of the file's own: a latitude-longitude map (.hdr or .exr; its middle is +X, its
    /// top +Y), or one colour as R,G,B (linear) or #rrggbb (sRGB)
    #[arg(long, value_name = "FILE|COLOUR", value_parser = environment::parse, allow_hyphen_values = true, help_heading = "Emitters")]
    pub(crate) environment: Option<EnvironmentArg>,
    /// Multiply the environment, also the file's own: cd/m² per unit of the map or colour
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = strength, allow_hyphen_values = true, help_heading = "Emitters")]
    pub(crate) environment_strength: f32,
    /// Turn the environment about +Y, also the file's own; counter-clockwise seen from above
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, value_parser = degrees, allow_hyphen_values = true, help_heading = "Emitters")]
    pub(crate) environment_rotation: f32,
    /// Light samples per emissive mesh, lamp with a radius and environment, 1 to 65536
    #[arg(long, value_name = "N", default_value_t = EmitterOptions::default().light_samples, value_parser = value_parser!(u32).range(1..=65536), help_heading = "Emitters")]
    light_samples: u32,
    /// Make the file's punctual lights spheres of this radius, in metres, and equal power; 0: points
    #[arg(long, value_name = "METRES", default_value_t = EmitterOptions::default().light_radius, value_parser = radius, allow_hyphen_values = true, help_heading = "Emitters")]
    light_radius: f32,
}

impl EmitterArgs {
    /// The library's options.
    pub fn options(&self) -> EmitterOptions {
        EmitterOptions { light_samples: self.light_samples, light_radius: self.light_radius }
    }
}

fn strength(text: &str) -> Result<f32, String> {
    not_negative(text).ok_or_else(|| "expected a number of at least 0".to_owned())
}

fn radius(text: &str) -> Result<f32, String> {
    not_negative(text).ok_or_else(|| "expected metres, 0 or more".to_owned())
}

fn degrees(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|x: &f32| x.is_finite()).ok_or_else(|| "expected a number of degrees".to_owned())
}

fn not_negative(text: &str) -> Option<f32> {
    text.parse().ok().filter(|x: &f32| *x >= 0.0 && x.is_finite())
}
