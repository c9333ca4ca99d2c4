//! The crate's plan holds: folders are stacked, and none imports from one above it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The files and folders of `src`, from the ground up: each may import only those before it.
const FLOORS: [&str; 22] = [
    "error",
    "image",
    "viewer",
    "progress",
    "sampling",
    "geometry",
    "options",
    "scene",
    "bvh",
    "light",
    "world",
    "interaction",
    "mesh",
    "direct",
    "indirect",
    "light_mesh",
    "film",
    "integrator",
    "api",
    "distributed",
    "fingerprint",
    "metrics",
];

/// More files than this make a folder hard to read: it wants to be split.
const MOST_FILES: usize = 16;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every Rust file below a folder.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(files_below(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The names that directly follow `crate::` in a file, comments left out: `crate::{a::X, B}` has `a` and `B`.
fn imports(text: &str) -> Vec<String> {
    let code: String = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .fold(String::new(), |all, line| all + line + "\n");
    let mut names = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = code[at + "crate::".len()..].trim_start();
        let name =
            |text: &str| text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
        match rest.strip_prefix('{') {
            None => names.push(name(rest)),
            Some(group) => {
                // The items of the outermost braces.
                let (mut depth, mut item) = (0, true);
                for (i, c) in group.char_indices() {
                    if item && depth == 0 && !c.is_whitespace() && c != '}' {
                        names.push(name(&group[i..]));
                        item = false;
                    }
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => item = true,
                        _ => {}
                    }
                }
            }
        }
    }
    names
}

/// The folder that each name comes from which `lib.rs` re-exports.
fn homes_of_root_names() -> BTreeMap<String, String> {
    let library = fs::read_to_string(source().join("lib.rs")).expect("lib.rs");
    let mut homes = BTreeMap::new();
    for statement in library.split("pub use ").skip(1).filter_map(|rest| rest.split(';').next()) {
        let (home, names) = statement.split_once("::").expect("a path");
        for name in names.trim_matches(|c| c == '{' || c == '}').split(',') {
            let name = name.rsplit(" as ").next().unwrap_or(name).trim();
            homes.insert(name.trim_end_matches('}').to_owned(), home.to_owned());
        }
    }
    homes
}

/// No file imports from a higher floor than its own, and every floor is in the list.
#[test]
fn folders_are_stacked() {
    let homes = homes_of_root_names();
    let floor_of = |name: &str| FLOORS.iter().position(|floor| *floor == name);
    let mut wrong = Vec::new();
    for path in files_below(&source()) {
        let inside = path.strip_prefix(source()).expect("a source").to_string_lossy().replace('\\', "/");
        let own = inside.split('/').next().unwrap_or_default().trim_end_matches(".rs");
        if own == "lib" {
            continue;
        }
        let Some(floor) = floor_of(own) else {
            wrong.push(format!("{inside}: \"{own}\" is not in the list of floors"));
            continue;
        };
        for name in imports(&fs::read_to_string(&path).expect("a source")) {
            let home = homes.get(&name).unwrap_or(&name);
            match floor_of(home) {
                Some(other) if other <= floor => {}
                Some(_) => wrong.push(format!("{inside} imports {name} from {home}, which is above {own}")),
                None => wrong.push(format!("{inside} imports {name}, which no floor has")),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// No folder has so many files that a reader is lost in it.
#[test]
fn folders_are_not_crowded() {
    let mut counts = BTreeMap::new();
    for path in files_below(&source()) {
        *counts.entry(path.parent().expect("a folder").to_owned()).or_insert(0) += 1;
    }
    let crowded: Vec<_> = counts.iter().filter(|(_, count)| **count > MOST_FILES).collect();
    assert!(crowded.is_empty(), "{crowded:?}");
}

/// The reader of imports sees through groups, and the names of `lib.rs` lead to folders.
#[test]
fn imports_are_found() {
    let text =
        "use crate::{Error, bvh::{Hit, Target},\n    film::Film};\n// crate::comment\nlet x = crate::mesh::choose(a);";
    assert_eq!(imports(text), ["Error", "bvh", "film", "mesh"]);
    assert_eq!(homes_of_root_names()["RenderOptions"], "options");
}
