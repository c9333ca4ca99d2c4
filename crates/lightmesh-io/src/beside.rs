//! Files beside the scene file: the one place that decides what a scene may name.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// A regular file that the scene may read, open.
#[derive(Debug)]
pub(crate) struct Beside {
    file: File,
    /// Bytes that [`Beside::read`] may return, to be paid for first.
    pub(crate) length: u64,
}

/// Why a name is not followed. A reader says in its own format's words what becomes of it.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// The scene was not read from a folder.
    NoFolder,
    /// Empty, or with a NUL in it.
    NotAName,
    /// The path leaves the scene's folder, as it is written or after symbolic links are followed.
    Outside,
    /// A folder, a pipe, a device.
    NotAFile,
    /// The operating system would not find or open it.
    Unreadable {
        /// The path that was looked for.
        target: PathBuf,
        /// The error of the operating system.
        cause: io::Error,
    },
}

/// The advice for [`Refusal::Outside`].
pub(crate) const OUTSIDE: &str = "leaves the scene's folder; put the file beside the scene or pass --allow-outside";

/// Opens the file that a scene in `folder` calls `name`: a path with slashes or, as Windows exporters write them,
/// backslashes. Unless `allow_outside`, it must stay in the folder.
///
/// What is outside is refused as it is written, before the file system is asked: the answer says nothing about files
/// there.
pub(crate) fn open(folder: Option<&Path>, name: &str, allow_outside: bool) -> Result<Beside, Refusal> {
    let Some(folder) = folder else { return Err(Refusal::NoFolder) };
    let relative = name.replace('\\', "/");
    if relative.is_empty() || relative.contains('\0') {
        return Err(Refusal::NotAName);
    }
    if !allow_outside && !stays_inside(Path::new(&relative)) {
        return Err(Refusal::Outside);
    }

    // Symbolic links may lead out of a path that stays inside as written.
    let target = folder.join(&relative);
    let unreadable = |cause| Refusal::Unreadable { target: target.clone(), cause };
    let resolved = target.canonicalize().map_err(unreadable)?;
    if !allow_outside && !resolved.starts_with(folder.canonicalize().map_err(unreadable)?) {
        return Err(Refusal::Outside);
    }
    // A pipe or a device could keep us waiting for ever.
    let metadata = resolved.metadata().map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(Refusal::NotAFile);
    }
    let file = File::open(&resolved).map_err(unreadable)?;
    Ok(Beside { file, length: metadata.len() })
}

/// Returns the path of the file that a scene in `folder` calls `name`, if it may read it; the file system is not asked.
pub(crate) fn path_of(folder: Option<&Path>, name: &str, allow_outside: bool) -> Option<PathBuf> {
    let relative = name.replace('\\', "/");
    let is_allowed = allow_outside || stays_inside(Path::new(&relative));
    folder
        .filter(|_| is_allowed && !relative.is_empty() && !relative.contains('\0'))
        .map(|folder| folder.join(relative))
}

impl Beside {
    /// The first [`Beside::length`] bytes: what is appended meanwhile was not paid for.
    pub(crate) fn read(self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(self.length as usize);
        self.file.take(self.length).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// Returns whether a relative path, as written, never climbs above its start.
fn stays_inside(path: &Path) -> bool {
    let mut depth = 0_i64;
    path.components().all(|component| {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => return false,
        }
        depth >= 0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn climbing_out_is_seen_as_written() {
        for path in ["a/b.bin", "./a", "a/../b"] {
            assert!(stays_inside(Path::new(path)), "{path}");
        }
        for path in ["../a", "a/../../b", "/a", "a/../../scene/b"] {
            assert!(!stays_inside(Path::new(path)), "{path}");
        }
    }

    #[test]
    fn each_refusal_has_its_reason() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("scene");
        std::fs::create_dir_all(inside.join("textures")).unwrap();
        std::fs::write(inside.join("textures/a.bin"), [1, 2, 3]).unwrap();
        std::fs::write(folder.path().join("secret"), [4]).unwrap();
        let ask = |name, allow| open(Some(&inside), name, allow);
        assert!(matches!(open(None, "a", true), Err(Refusal::NoFolder)));
        assert!(matches!(ask("", false), Err(Refusal::NotAName)));
        assert!(matches!(ask("a\0", false), Err(Refusal::NotAName)));
        assert!(matches!(ask("../secret", false), Err(Refusal::Outside)));
        assert!(matches!(ask("textures\\..\\..\\secret", false), Err(Refusal::Outside)));
        assert!(matches!(ask("textures", false), Err(Refusal::NotAFile)));
        assert!(matches!(ask("gone", false), Err(Refusal::Unreadable { .. })));
        assert_eq!(ask("textures\\a.bin", false).unwrap().read().unwrap(), [1, 2, 3]);
        assert_eq!(ask("../secret", true).unwrap().read().unwrap(), [4]);
    }
}
