//! The crate's plan holds: folders are stacked, and none imports from one above it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The files and folders of each crate's `src`, from the ground up: each may import only those before it.
const FLOORS: [(&str, &[&str]); 6] = [
    (
        "lightmesh",
        &[
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
            "first_light",
            "distributed",
            "fingerprint",
            "metrics",
        ],
    ),
    (
        "lightmesh-io",
        &[
            "error",
            "budget",
            "warnings",
            "world_origin",
            "beside",
            "srgb",
            "polygon",
            "texture_image",
            "picture_file",
            "load_options",
            "exr_chunk",
            "exr_dwa",
            "exr_file",
            "radiance_file",
            "environment_map",
            "output",
            "picture",
            "gltf",
            "obj",
            "ply",
            "scene_file",
            "scene_bytes",
            "mesh_file",
            "output_faults",
        ],
    ),
    ("lightmesh-denoise", &["error", "search", "resources", "library", "denoiser", "noise", "picture"]),
    (
        "lightmesh-reproduce",
        &["error", "watcher", "report", "scenes", "lab", "penumbra", "picture", "plot", "experiments", "files", "page"],
    ),
    (
        "lightmesh-cli",
        &[
            "machine",
            "args",
            "terminal",
            "exit",
            "interrupt",
            "threads",
            "camera_choice",
            "environment",
            "settings",
            "error_report",
            "stats",
            "denoise",
            "progress",
            "outputs",
            "preview",
            "render",
            "info",
            "compare",
            "reproduce",
            "completions",
            "man",
        ],
    ),
    (
        "lightmesh-py",
        &[
            "error",
            "json",
            "arrays",
            "view",
            "listener",
            "pool",
            "work",
            "output",
            "shared_mesh",
            "bricks",
            "keywords",
            "built",
            "camera",
            "light",
            "material",
            "scene",
            "denoise",
            "image",
            "meters",
            "mesh_files",
            "light_mesh",
            "render",
            "methods",
            "job",
            "gathering",
            "portions",
            "picture_job",
            "metrics",
            "program",
        ],
    ),
];

/// More files than this make a folder hard to read: it wants to be split.
const MOST_FILES: usize = 16;

/// The sources of the library.
fn source() -> PathBuf {
    source_of("lightmesh")
}

/// The sources of a crate beside the library.
fn source_of(package: &str) -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    if package == "lightmesh" { own.join("src") } else { own.join("..").join(package).join("src") }
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
fn homes_of_root_names(source: &Path) -> BTreeMap<String, String> {
    let library = fs::read_to_string(source.join("lib.rs")).expect("lib.rs");
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

/// No file imports from a higher floor than its own, and every floor is in the list. Crates that are not beside the
/// library, as in a package of its own, are passed over.
#[test]
fn folders_are_stacked() {
    let mut wrong = Vec::new();
    for (package, floors) in FLOORS {
        let source = source_of(package);
        if source.is_dir() {
            wrong.extend(arrows_up(&source, floors).into_iter().map(|arrow| format!("{package}: {arrow}")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What is wrong with the imports of the files below a folder; `lib.rs` and `main.rs` may know everybody.
fn arrows_up(source: &Path, floors: &[&str]) -> Vec<String> {
    let homes = homes_of_root_names(source);
    let floor_of = |name: &str| floors.iter().position(|floor| *floor == name);
    let mut wrong = Vec::new();
    for path in files_below(source) {
        let inside = path.strip_prefix(source).expect("a source").to_string_lossy().replace('\\', "/");
        let own = inside.split('/').next().unwrap_or_default().trim_end_matches(".rs");
        if ["lib", "main"].contains(&own) {
            continue;
        }
        let Some(floor) = floor_of(own) else {
            wrong.push(format!("{inside}: \"{own}\" is not in the list of floors"));
            continue;
        };
        for name in imports(&fs::read_to_string(&path).expect("a source")) {
            // Constants of `lib.rs` itself stand on no floor.
            if name.chars().all(|c| c.is_ascii_uppercase() || c == '_') {
                continue;
            }
            let home = homes.get(&name).unwrap_or(&name);
            match floor_of(home) {
                Some(other) if other <= floor => {}
                Some(_) => wrong.push(format!("{inside} imports {name} from {home}, which is above {own}")),
                None => wrong.push(format!("{inside} imports {name}, which no floor has")),
            }
        }
    }
    wrong
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
    assert_eq!(homes_of_root_names(&source())["RenderOptions"], "options");
}

/// The modules of a folder that a file names, through its path or through as many `super::` as lead to it from the
/// file.
fn siblings(text: &str, folder: &str, up: usize, modules: &[String]) -> Vec<String> {
    let code: String =
        text.lines().filter(|line| !line.trim_start().starts_with("//")).map(|line| format!("{line}\n")).collect();
    let (relative, absolute) = ("super::".repeat(up), format!("crate::{}::", folder.replace('/', "::")));
    let ends = |prefix: &str| -> Vec<usize> {
        let starts = code.match_indices(prefix).map(|(start, _)| start);
        starts.filter(|&start| !code[..start].ends_with("::")).map(|start| start + prefix.len()).collect()
    };
    let word =
        |text: &str| -> String { text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect() };
    let mut names = Vec::new();
    for end in [ends(&relative), ends(&absolute)].concat() {
        let rest = code[end..].split(';').next().unwrap_or_default();
        match rest.strip_prefix('{') {
            None => names.push(word(rest)),
            Some(group) => names.extend(group.split(['{', ',', '}']).map(word)),
        }
    }
    names.retain(|name| modules.contains(name));
    names
}

/// A circle of modules, as the names along it, if there is one.
fn circle(arrows: &BTreeMap<String, Vec<String>>) -> Option<Vec<String>> {
    fn walk<'a>(
        arrows: &'a BTreeMap<String, Vec<String>>,
        at: &'a str,
        way: &mut Vec<&'a str>,
        done: &mut Vec<&'a str>,
    ) -> Option<Vec<String>> {
        if let Some(first) = way.iter().position(|name| *name == at) {
            return Some(way[first..].iter().map(|name| (*name).to_owned()).collect());
        }
        if done.contains(&at) {
            return None;
        }
        way.push(at);
        let found = arrows.get(at).into_iter().flatten().find_map(|next| walk(arrows, next, way, done));
        way.pop();
        done.push(at);
        found
    }
    let mut done = Vec::new();
    arrows.keys().find_map(|name| walk(arrows, name, &mut Vec::new(), &mut done))
}

/// Within a folder, no modules import each other in a circle: adapting calls drawing, drawing does not call adapting.
#[test]
fn modules_of_a_folder_are_stacked() {
    let mut folders: Vec<PathBuf> =
        files_below(&source()).iter().filter_map(|path| path.parent().map(Path::to_owned)).collect();
    folders.dedup();
    folders.sort();
    folders.dedup();
    let mut wrong = Vec::new();
    for folder in folders.iter().filter(|folder| **folder != source()) {
        let name = folder.strip_prefix(source()).expect("a folder").to_string_lossy().replace('\\', "/");
        // A module is a file, or a folder whose files count as one.
        let module_of = |path: &Path| -> Option<String> {
            let inside = path.strip_prefix(folder).ok()?.components().next()?.as_os_str().to_string_lossy();
            Some(inside.trim_end_matches(".rs").to_owned()).filter(|module| module != "mod" && module != "tests")
        };
        let files = files_below(folder);
        let modules: Vec<String> = files.iter().filter_map(|path| module_of(path)).collect();
        let mut arrows: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for path in &files {
            let Some(module) = module_of(path) else { continue };
            let text = fs::read_to_string(path).expect("a source");
            let text = text.split("#[cfg(test)]").next().unwrap_or_default();
            let inside = path.strip_prefix(folder).expect("a file below");
            let up = inside.components().count() - usize::from(inside.ends_with("mod.rs"));
            let mut found = siblings(text, &name, up, &modules);
            found.retain(|other| *other != module);
            arrows.entry(module).or_default().extend(found);
        }
        if let Some(circle) = circle(&arrows) {
            wrong.push(format!("{name}: {}", circle.join(" → ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The reader of siblings sees `super::` and the folder's path, and a circle is found.
#[test]
fn circles_are_found() {
    let modules = ["wave", "block", "path"].map(str::to_owned);
    let text = "use super::block::A;\nuse crate::integrator::wave::B;\nuse super::{path, Other};\n";
    assert_eq!(siblings(text, "integrator", 1, &modules), ["block", "path", "wave"]);
    assert_eq!(siblings("use super::super::block::A;", "integrator", 2, &modules), ["block"]);
    let arrows = |arrows: &[(&str, &str)]| -> BTreeMap<String, Vec<String>> {
        arrows.iter().map(|&(from, to)| (from.to_owned(), vec![to.to_owned()])).collect()
    };
    assert_eq!(circle(&arrows(&[("a", "b"), ("b", "c"), ("d", "a")])), None);
    assert_eq!(circle(&arrows(&[("a", "b"), ("b", "c"), ("c", "b")])), Some(vec!["b".to_owned(), "c".to_owned()]));
}
