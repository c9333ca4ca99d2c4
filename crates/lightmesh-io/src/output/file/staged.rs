//! One file that appears whole or not at all.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

use tempfile::SpooledTempFile;

use super::{
    destination::{Destination, folder_of},
    fault::{self, Step},
    partial::{Leftovers, Partial, Refusal, leftovers, remove_leftovers},
    stream::Stream,
};
use crate::error::{Error, one_line};

/// Content for a pipe or a device is kept in memory up to this many bytes, then in a temporary file.
const IN_MEMORY: usize = 64 << 20;

/// A file under a temporary name beside its target. [`StagedFile::commit`] gives it its name; dropped before that, it
/// is removed, and whatever had the target's name stays as it was. As long as it is there, no other process can stage
/// the same target.
///
/// Where the name is that of a pipe, a device or a socket, the content is kept elsewhere and written to it in the end.
#[derive(Debug)]
pub struct StagedFile {
    /// As the caller wrote it.
    pub(super) name: PathBuf,
    pub(super) writer: Option<BufWriter<Sink>>,
    pub(super) place: Place,
}

/// Where the content goes in the end.
#[derive(Debug)]
pub(super) enum Place {
    /// From a temporary to a file.
    Replaced {
        /// `None` when it has its name.
        partial: Option<Partial>,
        /// Its last part is no link.
        target: PathBuf,
    },
    /// To what is there.
    Written(Stream),
}

/// Where the content grows.
#[derive(Debug)]
pub(super) enum Sink {
    Partial(File),
    Kept(SpooledTempFile),
}

/// Why a file cannot be staged.
pub(super) enum Unstaged {
    /// Another writer has this temporary.
    InUse(PathBuf),
    /// Anything else.
    Failed(Error),
}

impl StagedFile {
    /// Creates the temporary in the target's folder.
    ///
    /// # Errors
    /// If the folder is missing or not writable, or the target is a folder; [`Error::InUse`] if another process, or
    /// another part of this one, is writing the same file.
    pub fn create(target: &Path) -> Result<Self, Error> {
        Self::try_create(target, Leftovers::Removed).map_err(|unstaged| match unstaged {
            Unstaged::InUse(_) => Error::InUse { file: one_line(target.display()) },
            Unstaged::Failed(error) => error,
        })
    }

    /// [`StagedFile::create`] that says which temporary is in use.
    pub(super) fn try_create(name: &Path, leftovers: Leftovers) -> Result<Self, Unstaged> {
        let file = || one_line(name.display());
        let failed = |cause| Unstaged::Failed(Error::Write { file: file(), cause });
        let target = match Destination::of(name).map_err(failed)? {
            Destination::File(target) => target,
            Destination::Stream(path) => return Ok(Self::of_stream(name, Stream::At(path))),
            Destination::Open(number, path) => {
                fs::metadata(&path).map_err(failed)?;
                return Ok(Self::of_stream(name, Stream::Open(number, path)));
            }
        };
        // Refuse targets that could not be written later.
        if target.is_dir() {
            return Err(Unstaged::Failed(Error::IsFolder { file: file() }));
        }
        let Some(file_name) = target.file_name() else {
            return Err(failed(io::Error::new(io::ErrorKind::InvalidInput, "not the name of a file")));
        };
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(Unstaged::Failed(Error::NoFolder { file: file(), folder: one_line(folder.display()) }));
        }
        match Partial::create(folder, Path::new(file_name), leftovers) {
            Ok((partial, file)) => {
                if !partial.is_leftover {
                    keep_permissions(&file, &target);
                }
                Ok(Self {
                    name: name.to_owned(),
                    writer: Some(BufWriter::new(Sink::Partial(file))),
                    place: Place::Replaced { partial: Some(partial), target },
                })
            }
            Err(Refusal::InUse(path)) => Err(Unstaged::InUse(path)),
            Err(Refusal::Failed(cause)) => Err(failed(cause)),
        }
    }

    fn of_stream(name: &Path, stream: Stream) -> Self {
        let sink = Sink::Kept(SpooledTempFile::new(IN_MEMORY));
        Self { name: name.to_owned(), writer: Some(BufWriter::new(sink)), place: Place::Written(stream) }
    }

    /// Returns this file, ready to be written to, without what dead writers have left; a new and empty one if somebody has
    /// removed its temporary: nothing is written to it yet, and whole folders may be cleaned in the hours that a render
    /// takes.
    ///
    /// # Errors
    /// As [`StagedFile::create`].
    pub fn renewed(self) -> Result<Self, Error> {
        let Place::Replaced { partial: Some(partial), target } = &self.place else { return Ok(self) };
        let is_there = match self.writer.as_ref().map(BufWriter::get_ref) {
            Some(Sink::Partial(file)) => partial.is_still(file),
            _ => true,
        };
        if is_there && !partial.is_leftover {
            if let Some(name) = target.file_name() {
                remove_leftovers(folder_of(target), Path::new(name));
            }
            return Ok(self);
        }
        // Unlock what was there, so that it can be removed.
        let name = self.name.clone();
        drop(self);
        Self::create(&name)
    }

    /// Returns the path of the content until it is committed; `None` if it grows under no name, or if there still is one
    /// of the [`Self::leftovers`] of that name.
    pub fn temporary(&self) -> Option<&Path> {
        self.partial().filter(|partial| !partial.is_leftover).map(|partial| partial.path.as_path())
    }

    /// Returns the paths of files beside the target that have no writer and the names of temporaries: they stay until this
    /// one is [renewed](Self::renewed).
    pub fn leftovers(&self) -> Vec<PathBuf> {
        let Place::Replaced { partial, target } = &self.place else { return Vec::new() };
        let own = partial.iter().filter(|partial| partial.is_leftover).map(|partial| partial.path.clone());
        let others = target.file_name().map(|name| leftovers(folder_of(target), Path::new(name)));
        own.chain(others.into_iter().flatten()).collect()
    }

    pub(super) fn partial(&self) -> Option<&Partial> {
        match &self.place {
            Place::Replaced { partial, .. } => partial.as_ref(),
            Place::Written(_) => None,
        }
    }

    /// Makes it a file of its own if there was one of the temporary's name.
    fn replace_leftover(&mut self) -> io::Result<()> {
        if self.partial().is_some_and(|partial| partial.is_leftover) {
            let target = self.name.clone();
            // Unlock what was there, so that it can be removed.
            self.writer = None;
            *self = Self::create(&target).map_err(io::Error::other)?;
        }
        Ok(())
    }

    /// Returns its name as it was given to [`StagedFile::create`].
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// An [`Error::Write`] about it.
    pub fn error(&self, cause: io::Error) -> Error {
        Error::Write { file: one_line(self.name.display()), cause }
    }

    /// Hands the last bytes to the disk.
    pub(super) fn complete(&mut self) -> io::Result<()> {
        self.replace_leftover()?;
        let Some(writer) = &mut self.writer else { return Ok(()) };
        writer.flush()?;
        match writer.get_ref() {
            Sink::Partial(file) => {
                fault::before(Step::Sync)?;
                match file.sync_all() {
                    // Some file systems have nothing to do here, and say so.
                    Err(error) if matches!(error.kind(), io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput) => {
                        Ok(())
                    }
                    result => result,
                }
            }
            Sink::Kept(_) => Ok(()),
        }
    }

    /// Writes the content to the pipe or device, if it goes to one.
    pub(super) fn pour(&mut self) -> io::Result<()> {
        let Place::Written(stream) = &self.place else { return Ok(()) };
        let Some(writer) = &mut self.writer else { return Ok(()) };
        writer.rewind()?;
        match writer.get_mut() {
            Sink::Kept(kept) => stream.write(kept),
            Sink::Partial(_) => Ok(()),
        }
    }
}

impl Write for StagedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.replace_leftover()?;
        self.writer.as_mut().map_or(Ok(0), |writer| writer.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Seek for StagedFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.writer.as_mut().map_or(Ok(0), |writer| writer.seek(position))
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        fault::before(Step::Write)?;
        match self {
            Self::Partial(file) => file.write(bytes),
            Self::Kept(kept) => kept.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Partial(file) => file.flush(),
            Self::Kept(kept) => kept.flush(),
        }
    }
}

impl Seek for Sink {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        match self {
            Self::Partial(file) => file.seek(position),
            Self::Kept(kept) => kept.seek(position),
        }
    }
}

impl Drop for StagedFile {
    /// Removes the temporary, if it has not got its name.
    fn drop(&mut self) {
        // What a buffer still holds is of no use: it must not be written now.
        let sink = self.writer.take().map(|writer| writer.into_parts().0);
        if let Place::Replaced { partial: Some(partial), .. } = &self.place {
            let ours = match &sink {
                _ if partial.is_leftover => false,
                Some(Sink::Partial(file)) => partial.is_still(file),
                _ => true,
            };
            // Remove it while it is locked, so that nobody else takes it for theirs.
            if ours {
                let _ = fs::remove_file(&partial.path);
            }
        }
    }
}

/// Gives a temporary the permissions, and if the system lets us the owner, of the file that it will replace.
#[cfg(unix)]
fn keep_permissions(file: &File, target: &Path) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    if let (Ok(old), Ok(new)) = (fs::metadata(target), file.metadata()) {
        if (old.uid(), old.gid()) != (new.uid(), new.gid()) {
            let _ = fchown(file, Some(old.uid()), Some(old.gid()));
        }
        let _ = file.set_permissions(fs::Permissions::from_mode(old.mode() & 0o777));
    }
}

#[cfg(not(unix))]
fn keep_permissions(_: &File, _: &Path) {}
