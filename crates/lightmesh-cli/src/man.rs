//! `lightmesh man`.

use std::fs;
use std::path::Path;

use anyhow::Context;
use clap::CommandFactory;
use lightmesh_io::output::StagedFile;

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
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let commands: Vec<clap::Command> = program.get_subcommands().cloned().collect();
    for command in commands.into_iter().chain([program]).filter(|command| !command.is_hide_set()) {
        let page = clap_mangen::Man::new(command);
        let mut file = StagedFile::create(&folder.join(page.get_filename()))?;
        page.render(&mut file)?;
        file.commit()?;
    }
    Ok(())
}
