//! Files that appear whole or not at all.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use crate::error::{Error, one_line};

/// A file under a temporary name beside its target. [`StagedFile::commit`] gives it its name; dropped before that, it
/// is removed, and whatever had the target's name stays as it was.
#[derive(Debug)]
pub struct StagedFile {
    writer: Option<BufWriter<File>>,
    temporary: PathBuf,
    target: PathBuf,
}

impl StagedFile {
    /// Creates the temporary, `.NAME.PID.partial` in the target's folder.
    ///
    /// # Errors
    /// If the folder is missing or not writable, or the target is a folder.
    pub fn create(target: &Path) -> Result<Self, Error> {
        let file = || one_line(target.display());
        let failed = |cause| Error::Write { file: file(), cause };
        // Refuse targets that could not be written later.
        if target.is_dir() {
            return Err(Error::IsFolder { file: file() });
        }
        let Some(name) = target.file_name() else {
            return Err(failed(io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file")));
        };
        let folder = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(Error::NoFolder { file: file(), folder: one_line(folder.display()) });
        }
        // A leftover of a killed process may hold the name: take the next.
        let mut attempt = 0;
        loop {
            let mut hidden = std::ffi::OsString::from(".");
            hidden.push(name);
            hidden.push(format!(".{}-{attempt}.partial", std::process::id()));
            let temporary = folder.join(hidden);
            match OpenOptions::new().write(true).create_new(true).open(&temporary) {
                Ok(file) => {
                    return Ok(Self { writer: Some(BufWriter::new(file)), temporary, target: target.to_owned() });
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 100 => attempt += 1,
                Err(error) => return Err(failed(error)),
            }
        }
    }

    /// Returns the path of the content until it is committed.
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Returns the path of the content after that.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Gives the content its name, in the place of an older file.
    ///
    /// # Errors
    /// If the last bytes cannot be written or the name cannot be given; the temporary is removed then.
    pub fn commit(mut self) -> Result<(), Error> {
        let writer = self.writer.take();
        let flushed = writer.map_or(Ok(()), |mut writer| writer.flush());
        let renamed = flushed.and_then(|()| fs::rename(&self.temporary, &self.target));
        renamed.map_err(|cause| Error::Write { file: one_line(self.target.display()), cause })
    }
}

impl Write for StagedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.as_mut().map_or(Ok(0), |writer| writer.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl io::Seek for StagedFile {
    fn seek(&mut self, position: io::SeekFrom) -> io::Result<u64> {
        self.writer.as_mut().map_or(Ok(0), |writer| writer.seek(position))
    }
}

impl Drop for StagedFile {
    /// Removes the temporary; after [`StagedFile::commit`] there is none and the attempt does nothing.
    fn drop(&mut self) {
        drop(self.writer.take());
        let _ = fs::remove_file(&self.temporary);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn appears_whole_when_committed() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.txt");
        fs::write(&target, "old").unwrap();
        let mut file = StagedFile::create(&target).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "old");
        file.commit().unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn leaves_nothing_when_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = StagedFile::create(&folder.path().join("a.txt")).unwrap();
        file.write_all(b"half of it").unwrap();
        assert_eq!(names(folder.path()).len(), 1);
        drop(file);
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn says_what_is_wrong_with_the_place() {
        let folder = tempfile::tempdir().unwrap();
        let missing = StagedFile::create(&folder.path().join("no/a.png")).unwrap_err().to_string();
        assert!(missing.contains("a.png") && missing.contains("does not exist"), "{missing}");
        let taken = StagedFile::create(folder.path()).unwrap_err().to_string();
        assert!(taken.contains("is a folder"), "{taken}");
    }
}
