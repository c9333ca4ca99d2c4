//! What an output's name leads to.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// More symbolic links in a row than this are a circle.
const MOST_LINKS: usize = 40;

/// What an output's name leads to.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Destination {
    /// A file, a folder or nothing yet: its path, whose last part is no link.
    File(PathBuf),
    /// A pipe, a device or a socket.
    Stream(PathBuf),
    /// What this process has open under a number: 1 is standard output.
    Open(u32, PathBuf),
}

impl Destination {
    /// Follows the links at the end of a path.
    ///
    /// # Errors
    /// If they lead in a circle or cannot be read.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        let mut path = path.to_owned();
        for _ in 0..MOST_LINKS {
            if let Some(number) = descriptor(&path) {
                return Ok(Self::Open(number, path));
            }
            // What is there, by way of links, if anything is.
            if fs::metadata(&path).is_ok_and(|there| !there.is_file() && !there.is_dir())
                && !is_link_to_descriptor(&path)
            {
                return Ok(Self::Stream(path));
            }
            if !fs::symlink_metadata(&path).is_ok_and(|there| there.is_symlink()) {
                return Ok(Self::File(path));
            }
            let link = fs::read_link(&path)?;
            path = folder_of(&path).join(link);
        }
        Err(io::Error::other("too many symbolic links"))
    }
}

/// Returns the folder of a file; that of a bare name is the current one.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Returns whether a link is on the way to what this process has open.
fn is_link_to_descriptor(path: &Path) -> bool {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        if descriptor(&path).is_some() {
            return true;
        }
        match fs::read_link(&path) {
            Ok(link) => path = folder_of(&path).join(link),
            Err(_) => return false,
        }
    }
    false
}

/// Returns the number under which this process has the file open, for names such as `/dev/fd/3`.
#[cfg(unix)]
fn descriptor(path: &Path) -> Option<u32> {
    let number = path.file_name()?.to_str()?.parse().ok()?;
    let folder = folder_of(path).canonicalize().ok()?;
    let own = Path::new("/proc").join(std::process::id().to_string());
    let is_list = folder == Path::new("/dev/fd") || (folder.starts_with(own) && folder.ends_with("fd"));
    is_list.then_some(number)
}

#[cfg(not(unix))]
fn descriptor(_: &Path) -> Option<u32> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn links_are_followed_to_their_end() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        symlink("file", at("one")).unwrap();
        symlink("one", at("two")).unwrap();
        symlink("gone", at("dangling")).unwrap();
        symlink("round", at("round")).unwrap();
        symlink("/dev/null", at("null.png")).unwrap();
        symlink("/dev/stdout", at("out.png")).unwrap();
        assert_eq!(Destination::of(&at("two")).unwrap(), Destination::File(at("file")));
        assert_eq!(Destination::of(&at("dangling")).unwrap(), Destination::File(at("gone")));
        assert_eq!(Destination::of(&at("new")).unwrap(), Destination::File(at("new")));
        assert_eq!(Destination::of(&at("null.png")).unwrap(), Destination::Stream(at("null.png")));
        assert!(Destination::of(&at("round")).unwrap_err().to_string().contains("symbolic links"));
        for (name, number) in [("/dev/stdout", 1), ("/dev/stderr", 2), ("/dev/fd/7", 7), ("/proc/self/fd/7", 7)] {
            assert!(matches!(Destination::of(Path::new(name)), Ok(Destination::Open(n, _)) if n == number), "{name}");
        }
        assert!(matches!(Destination::of(&at("out.png")), Ok(Destination::Open(1, _))));
    }
}
