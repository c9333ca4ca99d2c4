//! Which file a path leads to.

use std::path::Path;

/// A file, whatever it is called: device and inode, or what Windows has instead.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Identity(Inner);

#[cfg(unix)]
type Inner = (u64, u64);
#[cfg(windows)]
type Inner = same_file::Handle;
#[cfg(not(any(unix, windows)))]
type Inner = std::path::PathBuf;

impl Identity {
    /// Returns what a path leads to, by way of links; `None` if there is nothing.
    pub(super) fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        let inner = std::fs::metadata(path).ok().map(|metadata| of_metadata(&metadata));
        #[cfg(windows)]
        let inner = same_file::Handle::from_path(path).ok();
        #[cfg(not(any(unix, windows)))]
        let inner = path.canonicalize().ok();
        inner.map(Self)
    }
}

/// Returns device and inode.
#[cfg(unix)]
pub(super) fn of_metadata(metadata: &std::fs::Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

/// Returns whether two paths lead to one file: by another spelling, a symbolic link, a hard link, or letters that the
/// file system takes for the same. A path that leads nowhere is the same as no other.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    Identity::of(a).is_some_and(|a| Identity::of(b).is_some_and(|b| a == b))
}
