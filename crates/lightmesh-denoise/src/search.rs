//! Where the library may be.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// The names of the library's file, the most exact one first.
#[cfg(target_os = "windows")]
pub(crate) const NAMES: &[&str] = &["OpenImageDenoise.dll"];
/// The names of the library's file, the most exact one first.
#[cfg(target_os = "macos")]
pub(crate) const NAMES: &[&str] = &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"];
/// The names of the library's file, the most exact one first.
#[cfg(not(any(target_os = "windows", target_os = "macos")))]
pub(crate) const NAMES: &[&str] = &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"];

/// The folders below one that is named, in which the library may be: of the wheel `pyoidn`, and of the project's own
/// packages.
const BELOW: &[&str] = &["", "lib", "bin", "lib64", "oidn/lib", "oidn/bin"];

/// The folders of a Python environment in which its packages may be, relative to `lib/python3.x`.
const PACKAGES: &[&str] = &["site-packages", "dist-packages"];

/// What says where the library is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// The library's file, or a folder with it: nothing else is tried then. `LIGHTMESH_OIDN`.
    pub named: Option<PathBuf>,
    /// The folder of the Python package `pyoidn`, where a caller knows it.
    pub package: Option<PathBuf>,
    /// Roots of the active Python environments. `VIRTUAL_ENV` and `CONDA_PREFIX`.
    pub environments: Vec<PathBuf>,
    /// Folders of programs, in which a `python3` stands for one more environment. `PATH`.
    pub programs: Vec<PathBuf>,
}

/// One place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Candidate {
    /// A file that exists.
    File(PathBuf),
    /// A name that the system's loader knows the folders of.
    System(&'static str),
    /// A folder that lacks the library.
    Without(PathBuf),
}

impl Places {
    /// Returns what the environment of this process says.
    pub fn of_process() -> Self {
        let path = |name| env::var_os(name).filter(|value: &OsString| !value.is_empty()).map(PathBuf::from);
        Self {
            named: path("LIGHTMESH_OIDN"),
            package: None,
            environments: ["VIRTUAL_ENV", "CONDA_PREFIX"].into_iter().filter_map(path).collect(),
            programs: env::var_os("PATH").map_or_else(Vec::new, |path| env::split_paths(&path).collect()),
        }
    }

    /// Returns every place to try, in order; places that cannot have the library are there to be named in a message.
    pub(crate) fn candidates(&self) -> Vec<Candidate> {
        if let Some(path) = &self.named {
            return vec![in_folder(path)];
        }
        let mut all: Vec<Candidate> = self.package.iter().map(|folder| in_folder(folder)).collect();
        for root in &self.environments {
            all.extend(in_environment(root));
        }
        all.extend(NAMES.iter().copied().map(Candidate::System));
        for root in self.roots_of_programs().iter().filter(|root| !self.environments.contains(root)) {
            all.extend(in_environment(root));
        }
        all
    }

    /// The roots of the environments of every Python among the programs: of a virtual environment, and of the
    /// installation that its program is a link to.
    fn roots_of_programs(&self) -> Vec<PathBuf> {
        let mut roots = Vec::new();
        let names = ["python3", "python", "python.exe"];
        let programs = self.programs.iter().flat_map(|folder| names.map(|name| folder.join(name)));
        for program in programs.filter(|program| program.is_file()) {
            for program in [Some(program.clone()), fs::canonicalize(&program).ok()].into_iter().flatten() {
                let Some(folder) = program.parent() else { continue };
                // On Windows an installation's python.exe is in its root, that of an environment in Scripts.
                let root = if cfg!(windows) && !folder.ends_with("Scripts") { Some(folder) } else { folder.parent() };
                roots.extend(root.map(Path::to_owned).filter(|root| !roots.contains(root)));
            }
        }
        roots
    }
}

/// The library's file in a folder or below it, or the file itself.
fn in_folder(path: &Path) -> Candidate {
    if path.is_file() {
        return Candidate::File(path.to_owned());
    }
    let files = BELOW.iter().flat_map(|folder| NAMES.iter().map(move |name| path.join(folder).join(name)));
    files.into_iter().find(|file| file.is_file()).map_or_else(|| Candidate::Without(path.to_owned()), Candidate::File)
}

/// The library in an environment of Python: of the wheel `pyoidn`, or of a package of conda.
fn in_environment(root: &Path) -> Vec<Candidate> {
    // Collect the folders of packages: lib/python3.x of Unix, the newest first, or Lib of Windows.
    let entries = fs::read_dir(root.join("lib")).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_python = |path: &PathBuf| {
        path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with("python3"))
    };
    let mut libraries: Vec<PathBuf> = entries.filter(is_python).collect();
    libraries.sort_by_key(|path| std::cmp::Reverse(version_in(path)));
    // Debian keeps what its own pip installs below /usr/local.
    if root == Path::new("/usr") {
        let local: Vec<PathBuf> =
            libraries.iter().filter_map(|path| Some(Path::new("/usr/local/lib").join(path.file_name()?))).collect();
        libraries = [local, libraries].concat();
    }
    libraries.push(root.join("Lib"));
    let packages = libraries.iter().flat_map(|library| PACKAGES.iter().map(move |name| library.join(name)));
    let packages: Vec<PathBuf> = packages.filter(|folder| folder.is_dir()).collect();

    let mut all: Vec<Candidate> = packages.iter().map(|folder| in_folder(&folder.join("pyoidn"))).collect();
    let own = [root.join("lib"), root.join("Library").join("bin")];
    let own = own.iter().flat_map(|folder| NAMES.iter().map(move |name| folder.join(name)));
    all.extend(own.filter(|file| file.is_file()).map(Candidate::File));
    all
}

/// The numbers in a folder's name: `python3.9` comes before `python3.11`.
fn version_in(path: &Path) -> Vec<u32> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    name.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(folder: &Path, file: &str) -> PathBuf {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, b"").expect("a file");
        path
    }

    fn system() -> Vec<Candidate> {
        NAMES.iter().copied().map(Candidate::System).collect()
    }

    /// What the user names is all that is tried: the file itself, or one in its folder or in those of packages.
    #[test]
    fn a_named_place_is_the_only_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = touch(folder.path(), &format!("oidn/lib/{}", NAMES[0]));
        let environment = folder.path().to_owned();
        let candidates = |named: PathBuf| {
            let environments = vec![environment.clone()];
            Places { named: Some(named), environments, ..Places::default() }.candidates()
        };
        assert_eq!(candidates(file.clone()), [Candidate::File(file.clone())]);
        assert_eq!(candidates(folder.path().join("oidn")), [Candidate::File(file.clone())]);
        assert_eq!(candidates(folder.path().to_owned()), [Candidate::File(file)]);
        let nowhere = folder.path().join("nowhere");
        assert_eq!(candidates(nowhere.clone()), [Candidate::Without(nowhere)]);
    }

    /// First the package that the caller knows, then the active environment, the system, and Python's own packages.
    #[cfg(unix)]
    #[test]
    fn places_are_tried_in_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let library = NAMES[NAMES.len() - 1];
        let known = touch(folder.path(), &format!("known/pyoidn/oidn/lib/{library}"));
        let active = touch(folder.path(), &format!("venv/lib/python3.9/site-packages/pyoidn/oidn/lib/{library}"));
        let newer = touch(folder.path(), &format!("venv/lib/python3.11/site-packages/pyoidn/oidn/lib/{library}"));
        let conda = touch(folder.path(), &format!("conda/lib/{library}"));
        touch(folder.path(), "usr/bin/python3");
        let debian = touch(folder.path(), &format!("usr/lib/python3/dist-packages/pyoidn/oidn/lib/{library}"));
        let places = Places {
            named: None,
            package: Some(path("known/pyoidn")),
            environments: vec![path("venv"), path("conda")],
            programs: vec![path("empty"), path("usr/bin")],
        };
        let files = |files: &[&PathBuf]| files.iter().map(|file| Candidate::File((*file).clone())).collect::<Vec<_>>();
        let expected = [files(&[&known, &newer, &active, &conda]), system(), files(&[&debian])].concat();
        assert_eq!(places.candidates(), expected);
    }

    /// The program of a virtual environment is a link: the environment's packages come before those of the
    /// installation.
    #[cfg(unix)]
    #[test]
    fn links_to_python_stand_for_two_environments() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().canonicalize().expect("a folder");
        touch(&root, "usr/bin/python3.11");
        fs::create_dir_all(root.join("venv/bin")).expect("a folder");
        std::os::unix::fs::symlink(root.join("usr/bin/python3.11"), root.join("venv/bin/python3")).expect("a link");
        let places = Places { programs: vec![root.join("venv/bin")], ..Places::default() };
        assert_eq!(places.roots_of_programs(), [root.join("venv"), root.join("usr")]);
        // A package that is not installed is named, so that a message can tell where it was looked for.
        fs::create_dir_all(root.join("usr/lib/python3.11/site-packages")).expect("a folder");
        let without = Candidate::Without(root.join("usr/lib/python3.11/site-packages/pyoidn"));
        assert_eq!(places.candidates(), [system(), vec![without]].concat());
    }
}
