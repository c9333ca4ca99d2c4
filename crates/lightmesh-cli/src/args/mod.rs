//! The arguments of the command line.

mod choices;
mod completions;
mod environment;
mod exposure;
mod man;
mod render;
mod reproduce;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use lightmesh::schema::{self, Value, parse_bytes};

use crate::machine;

pub use self::{
    choices::{Choice, Chosen, EmitterArgs, SURROUNDINGS, Surroundings, choice, choices},
    environment::EnvironmentArg,
    exposure::{Exposure, parse as parse_exposure},
};
pub(crate) use self::{completions::CompletionsArgs, man::ManArgs, render::RenderArgs, reproduce::ReproduceArgs};

/// Renders scenes lit by many lights, with light meshes.
#[derive(Debug, Parser)]
#[command(name = "lightmesh", version, about, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 failed while working; 2 bad input or usage; 3 the picture is written, but its \
                          error is more than --error (with --strict); 130 interrupted.";

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene into PNG and EXR files
    Render(Box<RenderArgs>),
    /// Say what a scene file holds
    Info(InfoArgs),
    /// Measure how far picture A is from the reference B
    Compare(CompareArgs),
    /// Run the experiments of the paper into one page
    Reproduce(ReproduceArgs),
    /// Print completions for a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write one per command
    Man(ManArgs),
}

/// Arguments of `info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Scene file
    pub(crate) scene: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    /// Which scene of the file, by name or index [default: the file's own choice]
    #[arg(long = "scene", value_name = "NAME|INDEX")]
    pub(crate) scene_name: Option<String>,
    /// Let the scene's URIs leave its folder
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Most memory that reading and building may take, in B, KB, MB, GB, KiB, MiB or GiB [default: half of the
    /// machine's, or of its control group's]
    #[arg(long, value_name = "SIZE", value_parser = bytes, allow_hyphen_values = true)]
    max_memory: Option<String>,
}

impl InfoArgs {
    /// Returns the most memory that reading may take, bytes.
    pub(crate) fn max_memory(&self) -> u64 {
        self.max_memory.as_deref().and_then(parse_bytes).unwrap_or_else(machine::default_limit)
    }
}

/// Checks a size in bytes.
fn bytes(text: &str) -> Result<String, String> {
    let about = schema::named("max-memory").map(|entry| entry.about.kind);
    about.map_or_else(|| Ok(text.to_owned()), |kind| kind.read(&Value::text(text)).map(|value| value.to_string()))
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(after_help = COMPARE_NOTES)]
pub(crate) struct CompareArgs {
    /// Picture: EXR (channels RGB, RGBA or Y) or PNG (decoded to linear)
    pub(crate) a: PathBuf,
    /// Reference, of the same size
    pub(crate) b: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

const COMPARE_NOTES: &str = "\
relrmse  sqrt(mean of (a - b)^2 over pixels and channels) / mean(b), linear values
bias     mean(a) / mean(b) - 1
max      largest |a - b| of a channel
flip     mean of the FLIP error, 0 to 1, at 67 pixels per degree. An EXR is shown as `render` writes a PNG, exposed as
         the reference would be by --exposure auto; a PNG is shown as it is.";

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }
}
