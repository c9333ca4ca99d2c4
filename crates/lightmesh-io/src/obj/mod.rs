//! Wavefront OBJ with MTL (Wavefront, "Advanced Visualizer Manual", appendix B1, 1992).
//!
//! Our own parser: `tobj` 4.0.5 panics on a `Kd` of fewer than three numbers and on an index far out of range, makes
//! triangles of lines, lets texture coordinates slip where only some faces have them, and names no line in its errors.

mod build;
mod image_file;
mod material;
mod mtl;
mod parse;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::load_options::{LoadOptions, Loaded};
use crate::warnings::Warnings;

/// The state of one reading: the file's name, its folder, the options, the budget, the warnings.
pub(crate) struct Context<'a> {
    file: &'a str,
    folder: Option<&'a Path>,
    options: &'a LoadOptions,
    budget: Budget,
    warnings: Warnings,
    /// The files that the scene names.
    files: Vec<PathBuf>,
}

impl Context<'_> {
    /// An error in the text of line `line`.
    fn syntax(&self, line: usize, what: impl std::fmt::Display) -> Error {
        Error::Syntax { file: one_line(self.file), place: format!("line {line}"), what: one_line(what) }
    }

    /// A value that no scene can have, in line `line`.
    fn invalid(&self, line: usize, what: impl std::fmt::Display) -> Error {
        Error::Invalid { file: one_line(self.file), place: format!("line {line}"), what: one_line(what) }
    }

    /// Pays for memory that is about to be allocated.
    fn spend(&mut self, line: usize, count: usize, item_bytes: usize) -> Result<(), Error> {
        self.budget.take(self.file, format_args!("line {line}"), count as u64, item_bytes as u64)
    }
}

/// Reads an OBJ file that is in memory. `file` is its name for messages; material libraries and textures are looked up
/// in `folder`, and are left out with a warning where it is `None` or where they cannot be read.
///
/// # Errors
/// As [`load`](crate::load).
pub(crate) fn read(
    file: &str,
    bytes: &[u8],
    folder: Option<&Path>,
    options: &LoadOptions,
    budget: Budget,
) -> Result<Loaded, Error> {
    let mut context = Context { file, folder, options, budget, warnings: Warnings::default(), files: Vec::new() };
    let obj = parse::parse(&mut context, bytes)?;
    let data = build::build(&mut context, &obj)?;
    Ok(Loaded { data, warnings: context.warnings.into_sentences(), files: context.files })
}
