//! Arguments of `man`.

use std::path::PathBuf;

use clap::Args;

/// Where manual pages go.
#[derive(Debug, Args)]
#[command(after_help = NOTES)]
pub(crate) struct ManArgs {
    /// Folder to write one page for the program and one for each command to; made where there is none
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

const NOTES: &str = "\
Examples:
  lightmesh man | man -l -
  lightmesh man -o ~/.local/share/man/man1";
