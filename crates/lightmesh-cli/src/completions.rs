//! `lightmesh completions`.

use clap::CommandFactory;

use crate::args::{Cli, CompletionsArgs};
use crate::exit::Failure;
use crate::terminal;

/// Prints the script that lets a shell complete the program's commands and options.
pub(crate) fn run(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "lightmesh", &mut script);
    terminal::print(String::from_utf8_lossy(&script).trim_end()).map_err(Failure::work)
}
