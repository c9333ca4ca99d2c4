//! Files that are replaced, kept, claimed and left behind.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::*;
use crate::error::Error;

/// A folder, and what is in it.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// A file with this content, under its temporary name.
fn staged(path: &Path, text: &str) -> StagedFile {
    let mut file = StagedFile::create(path).unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

#[test]
fn appears_whole_when_committed() {
    let place = Place::new();
    place.write("a.txt", "old");
    let file = staged(&place.path("a.txt"), "new");
    assert_eq!(place.read("a.txt"), "old");
    file.commit().unwrap();
    assert_eq!(place.read("a.txt"), "new");
    assert_eq!(place.names(), ["a.txt"]);
}

#[test]
fn leaves_nothing_when_dropped() {
    let place = Place::new();
    let file = staged(&place.path("a.txt"), "half of it");
    assert_eq!(place.names(), [".a.txt.lightmesh.partial"]);
    drop(file);
    assert!(place.names().is_empty());
}

#[test]
fn says_what_is_wrong_with_the_place() {
    let place = Place::new();
    let missing = StagedFile::create(&place.path("no/a.png")).unwrap_err().to_string();
    assert!(missing.contains("a.png") && missing.contains("does not exist"), "{missing}");
    let taken = StagedFile::create(place.0.path()).unwrap_err().to_string();
    assert!(taken.contains("is a folder"), "{taken}");
}

#[test]
fn a_second_writer_is_told_until_the_first_has_ended() {
    let place = Place::new();
    let path = place.path("a.txt");
    for end in [|first: StagedFile| first.commit().unwrap(), drop::<StagedFile> as fn(_)] {
        let first = staged(&path, "first");
        let error = StagedFile::create(&path).unwrap_err();
        assert!(matches!(error, Error::InUse { .. }) && error.to_string().contains("a.txt"), "{error}");
        end(first);
        staged(&path, "second").commit().unwrap();
        assert_eq!(place.read("a.txt"), "second");
    }
    assert_eq!(place.names(), ["a.txt"]);
}

/// Nobody holds the lock of what a killed process left, in this version's form and in that of the one before.
#[test]
fn leftovers_of_the_dead_are_removed_and_nothing_else() {
    let place = Place::new();
    // No process has a number of so many digits; this one has not written the last.
    let ours = format!(".a.txt.{}-3.partial", std::process::id());
    let dead = [
        ".a.txt.lightmesh.partial",
        ".a.txt.lightmesh.old",
        ".a.txt.9999999999-0.partial",
        ".a.txt.9999999998-12.partial",
        &ours,
    ];
    let mut others =
        vec![".a.txt.1-x.partial", ".a.txt.partial", ".b.txt.9999999999-0.partial", "a.txt.99999-0.partial"];
    if Path::new("/proc/1").exists() {
        others.push(".a.txt.1-0.partial");
    }
    dead.iter().chain(&others).for_each(|name| place.write(name, "half"));
    place.write(".a.txt.9999999997-0.partial", "alive");
    let alive = File::open(place.path(".a.txt.9999999997-0.partial")).unwrap();
    alive.lock().unwrap();
    staged(&place.path("a.txt"), "new").commit().unwrap();
    let mut left = vec![".a.txt.9999999997-0.partial", "a.txt"];
    left.extend(others);
    left.sort_unstable();
    assert_eq!(place.names(), left);
}

#[test]
fn outputs_that_are_one_file_are_refused() {
    let place = Place::new();
    fs::create_dir(place.path("dir")).unwrap();
    place.write("old.png", "old");
    fs::hard_link(place.path("old.png"), place.path("hard.png")).unwrap();
    for (a, b) in [("a.png", "a.png"), ("a.png", "dir/../a.png"), ("a.png", "./a.png"), ("old.png", "hard.png")] {
        let error = claim(&[place.path(a), place.path("other"), place.path(b)]).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, Error::SameOutput { .. }) && message.contains("twice"), "{message}");
        assert_eq!(message.contains("the same file as"), a != b, "{message}");
    }
    assert_eq!(place.names(), ["dir", "hard.png", "old.png"]);
    let files = claim(&[place.path("b"), place.path("a")]).unwrap();
    assert!(files[0].name().ends_with("b") && files[1].name().ends_with("a"));
}

/// Whether the file of that name is a dead writer's or one that is still needed shows only later.
#[test]
fn what_has_the_name_of_a_temporary_stays_until_it_is_in_the_way() {
    let place = Place::new();
    let (leftover, old) = (".a.txt.lightmesh.partial", ".a.txt.lightmesh.old");
    let files = [leftover, old, ".a.txt.9999999999-0.partial"];
    for name in files {
        place.write(name, "needed");
    }
    let claimed = || claim(&[place.path("a.txt")]).unwrap().remove(0);
    let file = claimed();
    let mut found = file.leftovers();
    found.sort_unstable();
    assert_eq!((found, file.temporary()), (vec![place.path(files[2]), place.path(old), place.path(leftover)], None));
    assert!(matches!(claim(&[place.path("a.txt")]), Err(Error::InUse { .. })));
    drop(file);
    for name in files {
        assert_eq!(place.read(name), "needed");
    }

    let mut file = claimed().renewed().unwrap();
    assert_eq!((file.leftovers(), file.temporary()), (vec![], Some(&*place.path(leftover))));
    file.write_all(b"new").unwrap();
    file.commit().unwrap();
    assert_eq!((place.names(), place.read("a.txt")), (vec!["a.txt".to_owned()], "new".to_owned()));

    // Written to without being renewed.
    place.write(leftover, "longer than what is new");
    let mut file = claimed();
    file.write_all(b"newer").unwrap();
    file.commit().unwrap();
    place.write(leftover, "what would be the content of an empty file");
    claim(&[place.path("b.txt")]).unwrap().remove(0).commit().unwrap();
    assert_eq!((place.read("a.txt"), place.read("b.txt")), ("newer".to_owned(), String::new()));
    claimed().commit().unwrap();
    assert_eq!((place.names(), place.read("a.txt")), (vec!["a.txt".to_owned(), "b.txt".to_owned()], String::new()));
}

/// Whoever cleans up while a render goes on does not cost its picture.
#[test]
fn a_temporary_that_is_removed_meanwhile_is_made_again() {
    let place = Place::new();
    let file = StagedFile::create(&place.path("a.txt")).unwrap();
    fs::remove_file(file.temporary().unwrap()).unwrap();
    let mut file = file.renewed().unwrap();
    file.write_all(b"new").unwrap();
    file.renewed().unwrap().commit().unwrap();
    assert_eq!(place.read("a.txt"), "new");
}

/// A name that cannot be given: a folder took it after everything was complete.
#[test]
fn a_batch_that_fails_puts_old_files_back() {
    let place = Place::new();
    place.write("a", "old a");
    let files = ["a", "new", "c", "d"].map(|name| staged(&place.path(name), "new"));
    let batch = Batch::complete(files).unwrap();
    fs::create_dir_all(place.path("c/full")).unwrap();
    let error = batch.commit().unwrap_err();
    assert!(matches!(&error, Error::Write { file, .. } if file.ends_with("/c")), "{error}");
    assert_eq!(place.read("a"), "old a");
    assert_eq!(place.names(), ["a", "c"]);
}

#[test]
fn a_folder_in_the_place_of_a_file_is_seen_before_the_first_is_replaced() {
    let place = Place::new();
    let files = ["a", "b"].map(|name| staged(&place.path(name), "new"));
    fs::create_dir(place.path("b")).unwrap();
    assert!(matches!(Batch::complete(files), Err(Error::IsFolder { .. })));
    assert_eq!(place.names(), ["b"]);
}

#[cfg(unix)]
mod on_unix {
    use std::io::Read;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    use std::os::unix::net::UnixListener;
    use std::process::Command;

    use super::*;

    #[test]
    fn a_link_stays_and_its_target_is_replaced_or_made() {
        let place = Place::new();
        fs::create_dir(place.path("there")).unwrap();
        place.write("there/old", "old");
        symlink("there/old", place.path("a")).unwrap();
        symlink("there/new", place.path("b")).unwrap();
        for (link, target) in [("a", "there/old"), ("b", "there/new")] {
            let file = staged(&place.path(link), "new");
            assert_eq!(file.temporary().unwrap().parent(), Some(&*place.path("there")));
            file.commit().unwrap();
            assert!(fs::symlink_metadata(place.path(link)).unwrap().is_symlink());
            assert_eq!(place.read(target), "new");
        }
        assert_eq!(fs::read_dir(place.path("there")).unwrap().count(), 2);
    }

    #[test]
    fn permissions_of_a_replaced_file_stay() {
        let place = Place::new();
        for mode in [0o600, 0o640, 0o444, 0o755] {
            let _ = fs::remove_file(place.path("a"));
            place.write("a", "old");
            fs::set_permissions(place.path("a"), fs::Permissions::from_mode(mode)).unwrap();
            staged(&place.path("a"), "new").commit().unwrap();
            assert_eq!(place.read("a"), "new");
            assert_eq!(fs::metadata(place.path("a")).unwrap().permissions().mode() & 0o777, mode);
        }
    }

    #[test]
    fn a_pipe_gets_the_content_and_stays_a_pipe() {
        let place = Place::new();
        assert!(Command::new("mkfifo").arg(place.path("a")).status().unwrap().success());
        let file = staged(&place.path("a"), "new");
        assert_eq!(place.names(), ["a"]);
        let path = place.path("a");
        let reader = std::thread::spawn(move || fs::read_to_string(path).unwrap());
        file.commit().unwrap();
        assert_eq!(reader.join().unwrap(), "new");
        assert!(fs::metadata(place.path("a")).unwrap().file_type().is_fifo());
    }

    #[test]
    fn a_socket_gets_the_content() {
        let place = Place::new();
        let listener = UnixListener::bind(place.path("a")).unwrap();
        let reader = std::thread::spawn(move || {
            let mut text = String::new();
            listener.accept().unwrap().0.read_to_string(&mut text).unwrap();
            text
        });
        staged(&place.path("a"), "new").commit().unwrap();
        assert_eq!(reader.join().unwrap(), "new");
    }

    #[test]
    fn devices_may_be_named_twice_and_say_when_they_are_full() {
        let null = PathBuf::from("/dev/null");
        for file in claim(&[null.clone(), null]).unwrap() {
            file.commit().unwrap();
        }
        if Path::new("/dev/full").exists() {
            let place = Place::new();
            let files = [place.path("a"), PathBuf::from("/dev/full")].map(|path| staged(&path, "new"));
            let error = Batch::complete(files).unwrap_err().to_string();
            assert!(error.starts_with("/dev/full: cannot be written"), "{error}");
            assert!(place.names().is_empty());
        }
    }
}
