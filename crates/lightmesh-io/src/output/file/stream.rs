//! Outputs that are written to instead of replaced: pipes, devices, sockets, and what is open already.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::PathBuf,
};

use super::fault::{self, Step};

/// Something to write finished content to.
#[derive(Debug)]
pub(super) enum Stream {
    /// A pipe, a device or a socket. A pipe without a reader is waited for, as by every program.
    At(PathBuf),
    /// What this process has open under a number, and its name.
    Open(u32, PathBuf),
}

impl Stream {
    /// Copies everything to it.
    pub(super) fn write(&self, mut content: impl io::Read) -> io::Result<()> {
        let mut out = self.open()?;
        let mut buffer = vec![0; 1 << 16];
        loop {
            let count = content.read(&mut buffer)?;
            if count == 0 {
                return out.flush();
            }
            fault::before(Step::Write)?;
            out.write_all(&buffer[..count])?;
        }
    }

    /// Opens it. Standard output and error share their position with whoever else writes there; other open files are
    /// added to at their end.
    fn open(&self) -> io::Result<Box<dyn Write>> {
        fault::before(Step::Open)?;
        let (number, path) = match self {
            Self::At(path) => (None, path),
            Self::Open(number, path) => (Some(*number), path),
        };
        #[cfg(unix)]
        {
            use std::os::{
                fd::AsFd as _,
                unix::{fs::FileTypeExt as _, net::UnixStream},
            };
            match number {
                Some(1) => return Ok(Box::new(File::from(io::stdout().as_fd().try_clone_to_owned()?))),
                Some(2) => return Ok(Box::new(File::from(io::stderr().as_fd().try_clone_to_owned()?))),
                _ => {}
            }
            if number.is_none() && fs::metadata(path)?.file_type().is_socket() {
                return Ok(Box::new(UnixStream::connect(path)?));
            }
        }
        let is_file = number.is_some() && fs::metadata(path)?.is_file();
        let file: File = OpenOptions::new().write(true).append(is_file).open(path)?;
        Ok(Box::new(file))
    }
}
