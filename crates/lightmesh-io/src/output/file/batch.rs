//! Several files that appear together: all of them, or none.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use super::{
    destination::folder_of,
    fault::{self, Step},
    partial::{OLD, beside},
    staged::{Place, StagedFile},
};
use crate::error::{Error, one_line};

/// Files whose content is complete, and which only lack their names.
#[derive(Debug)]
pub struct Batch {
    files: Vec<StagedFile>,
}

/// What became of the file that had the name before.
enum Old {
    /// There was none.
    Missing,
    /// It has this second name.
    Kept(PathBuf),
    /// The file system gives no second names.
    Lost,
}

impl Batch {
    /// Writes the last bytes of every file to the disk, and whatever goes to pipes and devices. No file has its name
    /// yet when this fails.
    ///
    /// # Errors
    /// The first failure; every temporary is removed then.
    pub fn complete(files: impl IntoIterator<Item = StagedFile>) -> Result<Self, Error> {
        let mut files: Vec<StagedFile> = files.into_iter().collect();
        for file in &mut files {
            file.complete().map_err(|cause| file.error(cause))?;
            // Find out now what would stop the names later.
            if let Place::Replaced { target, .. } = &file.place
                && target.is_dir()
            {
                return Err(Error::IsFolder { file: one_line(file.name.display()) });
            }
        }
        for file in &mut files {
            file.pour().map_err(|cause| file.error(cause))?;
        }
        Ok(Self { files })
    }

    /// Gives every file its name. If that fails at one, those before it are taken back and what they replaced is put
    /// back.
    ///
    /// # Errors
    /// [`Error::Write`] if every old file is as it was; [`Error::PartlyWritten`], which names the files that are
    /// replaced, where the file system could not keep the old ones (it has no hard links).
    pub fn commit(mut self) -> Result<(), Error> {
        // The last file needs no way back: nothing can fail after it.
        let mut done: Vec<(usize, Old)> = Vec::new();
        let last = self.files.iter().rposition(|file| matches!(file.place, Place::Replaced { .. }));
        for index in 0..self.files.len() {
            let file = &mut self.files[index];
            let old = match &file.place {
                Place::Replaced { target, .. } if Some(index) != last => keep(target),
                Place::Replaced { .. } => Old::Lost,
                Place::Written(_) => continue,
            };
            if let Err(cause) = give_name(file) {
                let file = one_line(file.name.display());
                discard(&old);
                let replaced = self.take_back(done);
                return Err(match replaced.is_empty() {
                    true => Error::Write { file, cause },
                    false => Error::PartlyWritten { file, cause, replaced: one_line(replaced.join(", ")) },
                });
            }
            done.push((index, old));
        }
        done.iter().for_each(|(_, old)| discard(old));
        Ok(())
    }

    /// Puts old files back, the newest change first. Returns the names of those that stay replaced.
    fn take_back(&self, done: Vec<(usize, Old)>) -> Vec<String> {
        let mut replaced = Vec::new();
        for (index, old) in done.into_iter().rev() {
            let StagedFile { name, place, .. } = &self.files[index];
            let Place::Replaced { target, .. } = place else { continue };
            let back = match &old {
                Old::Missing => fs::remove_file(target),
                Old::Kept(second) => fs::rename(second, target),
                Old::Lost => Err(io::Error::other("it is lost")),
            };
            if back.is_err() {
                discard(&old);
                replaced.insert(0, name.display().to_string());
            }
        }
        replaced
    }
}

impl StagedFile {
    /// Gives the content its name, in the place of an older file; [`Batch`] does so with several files.
    ///
    /// # Errors
    /// If the last bytes cannot be written or the name cannot be given; the temporary is removed then.
    pub fn commit(self) -> Result<(), Error> {
        Batch::complete([self])?.commit()
    }
}

/// Gives a temporary its file's name. It is locked until then.
fn give_name(file: &mut StagedFile) -> io::Result<()> {
    let Place::Replaced { partial, target } = &mut file.place else { return Ok(()) };
    let Some(temporary) = partial.as_ref() else { return Ok(()) };
    // Windows renames no file that is open without being shared.
    if cfg!(windows) {
        file.writer = None;
    }
    fault::before(Step::Rename)?;
    fs::rename(&temporary.path, target)?;
    *partial = None;
    file.writer = None;
    Ok(())
}

/// Gives the file that has the name a second one.
fn keep(target: &Path) -> Old {
    if fs::symlink_metadata(target).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
        return Old::Missing;
    }
    let Some(name) = target.file_name() else { return Old::Lost };
    let second = folder_of(target).join(beside(Path::new(name), OLD));
    // One that a killed process left: it is no longer the newest.
    let _ = fs::remove_file(&second);
    let linked = fault::before(Step::Keep).and_then(|()| fs::hard_link(target, &second));
    if linked.is_ok() { Old::Kept(second) } else { Old::Lost }
}

/// Removes the second name of an old file.
fn discard(old: &Old) {
    if let Old::Kept(second) = old {
        let _ = fs::remove_file(second);
    }
}
