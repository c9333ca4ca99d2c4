//! Arguments of `reproduce`.

use std::path::PathBuf;

use clap::Args;

/// What is run, and where it goes.
#[derive(Debug, Args)]
#[command(after_help = NOTES)]
pub(crate) struct ReproduceArgs {
    /// Folder to write to; made where there is none
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Small pictures: done within a minute, but times mean little
    #[arg(long)]
    pub(crate) quick: bool,
    /// Run also what an earlier run of the same kind has finished
    #[arg(long)]
    pub(crate) force: bool,
    /// Experiments to run, separated by commas [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Threads; at most 4 for each core, or 64 where that is more [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) threads: Option<u32>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

const NOTES: &str = "\
DIR/index.html is the page and needs no other file; DIR/report.json has its numbers. DIR/experiments keeps what is finished: the same command
goes on where it was stopped.";
