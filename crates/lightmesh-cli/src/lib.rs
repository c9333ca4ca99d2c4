//! The `lightmesh` program, and the parts that other interfaces of the library share with it: options by name, with
//! their spellings, ranges and defaults, the choice of a camera, environments, and statistics of finished pictures.

#![forbid(unsafe_code)]

mod args;
mod camera_choice;
mod compare;
mod completions;
mod denoise;
mod environment;
mod error_report;
mod exit;
mod info;
mod interrupt;
mod machine;
mod man;
mod outputs;
mod preview;
mod progress;
mod render;
mod reproduce;
mod settings;
mod stats;
mod terminal;
mod threads;

use std::ffi::OsString;

use clap::Parser;

use crate::args::{Cli, Command};
pub use crate::{
    args::{
        Choice, Chosen, EmitterArgs, EnvironmentArg, Exposure, SURROUNDINGS, Surroundings, choice, choices,
        parse_exposure,
    },
    camera_choice::{choose as choose_camera, height_for},
    compare::visible_difference,
    denoise::{Denoise, no_noise_message},
    environment::{FirstLit, add_first_light, apply as apply_environment, read as read_environment},
    settings::json as settings_json,
    stats::{MeshesStats, Stats, WorkStats, non_finite_message},
    threads::Threads,
};

/// Name and version of the program, as picture files carry it.
pub const SOFTWARE: &str = concat!("lightmesh ", env!("CARGO_PKG_VERSION"));

/// Runs the program with these arguments, its own name first, and returns its exit code: 0 done; 1 failed while
/// working, or the picture is written and has pixels that are no numbers; 2 bad input or usage; 3 the picture is written but not within `--error` (with `--strict`); 130 interrupted. It
/// may end the process itself, after Ctrl-C.
pub fn run(args: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => return exit::usage(&error),
    };
    let result = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Info(args) => on_threads(|| info::run(&args)),
        Command::Compare(args) => on_threads(|| compare::run(&args)),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    };
    match result {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}

/// Runs a command that has no option for threads.
fn on_threads(work: impl FnOnce() -> Result<(), exit::Failure> + Send) -> Result<(), exit::Failure> {
    threads::start(None, terminal::warning)?.install(work)
}
