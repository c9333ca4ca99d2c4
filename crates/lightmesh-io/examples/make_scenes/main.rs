//! Writes the project's own scenes into `scenes/`, or into the folder given as the only argument.
//!
//! The same program gives the same bytes on every machine; a test of this crate compares the files with it.

use std::path::PathBuf;
use std::process::ExitCode;

mod scenes;

#[expect(clippy::print_stdout, clippy::print_stderr, reason = "a program says what it wrote")]
fn main() -> ExitCode {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from(default), PathBuf::from);
    for scene in scenes::all() {
        let path = folder.join(scene.file_name);
        let glb = scene.document.to_glb();
        if let Err(error) = std::fs::write(&path, &glb) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
        println!("{} ({} triangles, {} bytes)", path.display(), scene.document.triangle_count(), glb.len());
    }
    ExitCode::SUCCESS
}
