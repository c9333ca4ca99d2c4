//! `lightmesh man`.

use std::fs;
use std::path::Path;

use anyhow::Context;
use clap::CommandFactory;

use crate::args::{Cli, ManArgs};
use crate::exit::Failure;
use crate::terminal;

/// Prints the program's page, or writes it and those of its commands into a folder.
pub(crate) fn run(args: &ManArgs) -> Result<(), Failure> {
    match &args.output {
        Some(folder) => write(folder).with_context(|| folder.display().to_string()).map_err(Failure::Work),
        None => {
            let mut page = Vec::new();
            clap_mangen::Man::new(Cli::command()).render(&mut page).map_err(Failure::work)?;
            terminal::print(String::from_utf8_lossy(&page).trim_end()).map_err(Failure::work)
        }
    }
}

/// `lightmesh.1`, `lightmesh-render.1` and so on.
fn write(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder)?;
    clap_mangen::generate_to(Cli::command(), folder)?;
    Ok(())
}
