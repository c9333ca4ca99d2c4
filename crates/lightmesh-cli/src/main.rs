//! The `lightmesh` program.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    lightmesh_cli::run(std::env::args_os()).into()
}
