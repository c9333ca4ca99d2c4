//! All outputs of a run, before its work begins.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{
    destination::{Destination, folder_of},
    identity::is_same_file,
    partial::Leftovers,
    staged::{StagedFile, Unstaged},
};
use crate::error::{Error, one_line};

/// Stages every file, in the order of the paths: from now on no other process can. What dead writers have left stays until
/// the files are [renewed](StagedFile::renewed) or written to: until then, see [`StagedFile::leftovers`].
///
/// # Errors
/// [`Error::SameOutput`] if two of them would be one file, however they are spelled; [`Error::InUse`] if another
/// process writes one of them; else as [`StagedFile::create`]. Nothing is left then.
pub fn claim(paths: &[PathBuf]) -> Result<Vec<StagedFile>, Error> {
    // Refuse what is there under two names.
    for (i, path) in paths.iter().enumerate() {
        if let Some(other) = paths[..i].iter().find(|other| is_one_output(path, other)) {
            return Err(same(path, other));
        }
    }

    // Always in the same order: of two runs with the same files one gets all of them.
    let mut order: Vec<usize> = (0..paths.len()).collect();
    order.sort_by_key(|&i| real_path(&paths[i]));
    let mut files: Vec<(usize, StagedFile)> = Vec::with_capacity(paths.len());
    for i in order {
        match StagedFile::try_create(&paths[i], Leftovers::Kept) {
            Ok(file) => files.push((i, file)),
            Err(Unstaged::Failed(error)) => return Err(error),
            // Two names of a file that is not there yet have one temporary.
            Err(Unstaged::InUse(temporary)) => {
                let is_it = |file: &StagedFile| file.partial().is_some_and(|own| is_same_file(&own.path, &temporary));
                return Err(match files.iter().find(|(_, file)| is_it(file)) {
                    Some((other, _)) => same(&paths[i.max(*other)], &paths[i.min(*other)]),
                    None => Error::InUse { file: one_line(paths[i].display()) },
                });
            }
        }
    }
    files.sort_by_key(|(i, _)| *i);
    Ok(files.into_iter().map(|(_, file)| file).collect())
}

fn same(path: &Path, other: &Path) -> Error {
    Error::SameOutput { file: one_line(path.display()), other: one_line(other.display()) }
}

/// Returns whether two outputs would end in one place. What goes to a device such as `/dev/null` does no harm to
/// another output there.
fn is_one_output(a: &Path, b: &Path) -> bool {
    let is_device = || fs::metadata(a).is_ok_and(|there| is_character_device(&there));
    (is_same_file(a, b) || real_path(a) == real_path(b)) && !is_device()
}

/// Returns the path of what is written: without links, as far as it is there.
fn real_path(path: &Path) -> PathBuf {
    match Destination::of(path) {
        Ok(Destination::File(target)) => match (folder_of(&target).canonicalize(), target.file_name()) {
            (Ok(folder), Some(name)) => folder.join(name),
            _ => target,
        },
        Ok(Destination::Stream(path) | Destination::Open(_, path)) => path,
        Err(_) => path.to_owned(),
    }
}

#[cfg(unix)]
fn is_character_device(there: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    there.file_type().is_char_device()
}

#[cfg(not(unix))]
fn is_character_device(_: &fs::Metadata) -> bool {
    false
}
