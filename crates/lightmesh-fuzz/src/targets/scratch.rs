//! Files for readers that only read files.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;

/// The path of a file in a folder of this process, in memory where the system has such a folder.
pub(super) fn write(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let in_memory = Path::new("/dev/shm");
        let parent = if in_memory.is_dir() { in_memory.to_owned() } else { std::env::temp_dir() };
        tempfile::Builder::new().prefix("lightmesh-fuzz-").tempdir_in(parent).expect("a folder for temporary files")
    });
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a temporary file");
    path
}
