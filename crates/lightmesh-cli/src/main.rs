//! The `lightmesh` program: a thin face of the library.

#![forbid(unsafe_code)]

mod args;
mod camera_choice;
mod compare;
mod environment;
mod exit;
mod info;
mod interrupt;
mod outputs;
mod preview;
mod progress;
mod render;
mod reproduce;
mod settings;
mod stats;
mod terminal;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Command};

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return exit::usage(&error),
    };
    let result = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
