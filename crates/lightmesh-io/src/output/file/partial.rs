//! The temporary of a file that is being written, and what dead writers left of theirs.

use std::{
    ffi::OsString,
    fs::{self, File, OpenOptions, TryLockError},
    io,
    path::{Path, PathBuf},
};

use super::fault::{self, Step};

/// How often the name of a temporary is tried while others come and go.
const ATTEMPTS: usize = 50;
/// Names of more bytes are shortened: with what is added to them they would be too long for most file systems.
const LONGEST_NAME: usize = 200;

/// The ending of the name that an old file has while it is replaced.
pub(super) const OLD: &str = "lightmesh.old";

/// A temporary that is ours alone.
#[derive(Debug)]
pub(super) struct Partial {
    pub(super) path: PathBuf,
    /// Whether the file was there already: of a dead writer, or of somebody else who likes such names. It is not to be written
    /// to.
    pub(super) is_leftover: bool,
}

/// What becomes of files that have the names of temporaries and no writer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leftovers {
    /// They are removed.
    Removed,
    /// They stay, and are locked: it may turn out that the scene names them.
    Kept,
}

/// Why there is no temporary.
#[derive(Debug)]
pub(super) enum Refusal {
    /// Another writer has this one.
    InUse(PathBuf),
    /// The operating system would not make it.
    Failed(io::Error),
}

impl From<io::Error> for Refusal {
    fn from(cause: io::Error) -> Self {
        Self::Failed(cause)
    }
}

impl Partial {
    /// Makes the temporary of a file `name` in `folder`, locked; `leftovers`: what becomes of those of dead writers.
    pub(super) fn create(folder: &Path, name: &Path, leftovers: Leftovers) -> Result<(Self, File), Refusal> {
        fault::before(Step::Create)?;
        if leftovers == Leftovers::Removed {
            remove_leftovers(folder, name);
        }
        let path = folder.join(beside(name, "lightmesh.partial"));
        for _ in 0..ATTEMPTS {
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => match file.try_lock() {
                    // Until it was locked, another writer could take it for a leftover.
                    Ok(()) if is_still(&path, &file) => return Ok((Self { path, is_leftover: false }, file)),
                    Ok(()) | Err(TryLockError::WouldBlock) => {}
                    // The file system has no locks: do without.
                    Err(TryLockError::Error(_)) => {
                        drop(file);
                        let _ = fs::remove_file(&path);
                        return Self::unlocked(folder, name);
                    }
                },
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => match Found::at(&path) {
                    Found::Dead(file) if leftovers == Leftovers::Kept => {
                        return Ok((Self { path, is_leftover: true }, file));
                    }
                    Found::Dead(_) if fs::remove_file(&path).is_err() => return Self::unlocked(folder, name),
                    Found::Dead(_) | Found::Gone => {}
                    Found::Alive => return Err(Refusal::InUse(path)),
                    Found::Unknown => return Self::unlocked(folder, name),
                },
                Err(error) => return Err(error.into()),
            }
        }
        Self::unlocked(folder, name)
    }

    /// Makes a temporary that no other process has, where there are no locks.
    fn unlocked(folder: &Path, name: &Path) -> Result<(Self, File), Refusal> {
        let mut attempt = 0;
        loop {
            let path = folder.join(beside(name, &format!("{}-{attempt}.partial", std::process::id())));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok((Self { path, is_leftover: false }, file)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < ATTEMPTS => attempt += 1,
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Returns whether its name still leads to the file.
    pub(super) fn is_still(&self, file: &File) -> bool {
        is_still(&self.path, file)
    }
}

/// `.NAME.` and an ending: a hidden file beside the one of that name.
pub(super) fn beside(name: &Path, ending: &str) -> OsString {
    let name = name.as_os_str();
    let mut hidden = OsString::from(".");
    if name.len() > LONGEST_NAME {
        hidden.push(format!("{:08x}", crc32fast::hash(name.as_encoded_bytes())));
    } else {
        hidden.push(name);
    }
    hidden.push(".");
    hidden.push(ending);
    hidden
}

/// Removes what killed writers have left beside a file, but for the temporary's own name.
pub(super) fn remove_leftovers(folder: &Path, name: &Path) {
    for path in leftovers(folder, name) {
        if path.ends_with(beside(name, OLD)) {
            let _ = fs::remove_file(path);
        } else if let Found::Dead(_locked) = Found::at(&path) {
            let _ = fs::remove_file(path);
        }
    }
}

/// Returns the names that killed writers may have left: the second one of a file that was being replaced, and temporaries of
/// the form `.NAME.PROCESS-NUMBER.partial`. Versions before 0.2 lock none of theirs: where another process has that number
/// now, they do not count.
pub(super) fn leftovers(folder: &Path, name: &Path) -> Vec<PathBuf> {
    let (start, old) = (beside(name, ""), beside(name, OLD));
    let is_left = |file_name: &OsString| {
        let rest = file_name.as_encoded_bytes().strip_prefix(start.as_encoded_bytes());
        let process = rest.and_then(|rest| rest.strip_suffix(b".partial")).and_then(process_of);
        *file_name == old || process.is_some_and(|process| !is_another_process(process))
    };
    let names = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.filter(is_left).map(|file_name| folder.join(file_name)).collect()
}

/// Returns the first of two numbers with a hyphen between them; `None` for any other text.
fn process_of(text: &[u8]) -> Option<&str> {
    let (process, number) = std::str::from_utf8(text).ok()?.split_once('-')?;
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|c| c.is_ascii_digit());
    (is_number(process) && is_number(number)).then_some(process)
}

/// Returns whether another process than this one has that number, as far as the system tells.
fn is_another_process(process: &str) -> bool {
    process != std::process::id().to_string() && Path::new("/proc").join(process).exists()
}

/// A temporary that was there already.
enum Found {
    /// Its writer is dead. While the file is open we hold its lock: nobody else removes it or writes to it.
    Dead(File),
    /// Its writer has just finished.
    Gone,
    /// Its writer lives.
    Alive,
    /// It is no file, or nothing can be found out about it.
    Unknown,
}

impl Found {
    /// Writers lock theirs before they write, and the operating system unlocks those of the dead.
    fn at(path: &Path) -> Self {
        match fs::symlink_metadata(path) {
            Ok(there) if there.is_file() => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Self::Gone,
            _ => return Self::Unknown,
        }
        // Some file systems lock only files that are open for writing.
        let opened = OpenOptions::new().write(true).open(path).or_else(|_| File::open(path));
        match opened.map(|file| (file.try_lock(), file)) {
            Ok((Ok(()), file)) if is_still(path, &file) => Self::Dead(file),
            Ok((Ok(()), _)) => Self::Gone,
            Ok((Err(TryLockError::WouldBlock), _)) => Self::Alive,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Self::Gone,
            _ => Self::Unknown,
        }
    }
}

/// Returns whether a name leads to an open file, which may have been removed since it was opened.
#[cfg(unix)]
fn is_still(path: &Path, file: &File) -> bool {
    use super::identity::of_metadata;
    let (there, ours) = (fs::symlink_metadata(path), file.metadata());
    matches!((there, ours), (Ok(there), Ok(ours)) if of_metadata(&there) == of_metadata(&ours))
}

#[cfg(not(unix))]
fn is_still(path: &Path, _: &File) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_temporaries_are_taken_for_them() {
        for (text, process) in [("12-0", Some("12")), ("1-22", Some("1")), ("12", None), ("a-0", None), ("1-2-3", None)]
        {
            assert_eq!(process_of(text.as_bytes()), process, "{text}");
        }
        assert_eq!((process_of(b"-"), process_of(b"1-\xff")), (None, None));
        assert_eq!(beside(Path::new("a.png"), "lightmesh.partial"), ".a.png.lightmesh.partial");
        assert!(beside(Path::new(&"x".repeat(250)), "lightmesh.partial").len() < 50);
    }
}
