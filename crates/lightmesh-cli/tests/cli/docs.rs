//! The documentation names only what is there: files, options, functions, and what commands are given.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::place::Place;

/// A page and its text.
struct Page {
    /// From the repository's root, with forward slashes.
    name: String,
    text: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the repository")
}

/// Every file of the repository below a folder of it, from the root and with forward slashes; build outputs and
/// hidden folders are left out.
fn files_below(folder: &str) -> Vec<String> {
    let mut files = Vec::new();
    let Ok(entries) = fs::read_dir(root().join(folder)) else { return files };
    for entry in entries.map(|entry| entry.expect("an entry")) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let path = if folder.is_empty() { name.clone() } else { format!("{folder}/{name}") };
        if entry.path().is_dir() {
            let is_output = ["target", "__pycache__", "out"].contains(&name.as_str());
            let is_hidden = name.starts_with('.') && ![".ci", ".github"].contains(&name.as_str());
            if !is_output && !is_hidden {
                files.extend(files_below(&path));
            }
        } else {
            files.push(path);
        }
    }
    files
}

/// The pages that describe what is there today: not the change log, which also tells of what was.
fn pages() -> Vec<Page> {
    let names = files_below("").into_iter().filter(|name| name.ends_with(".md") && name != "CHANGELOG.md");
    let read = |name: String| Page { text: fs::read_to_string(root().join(&name)).expect("a page"), name };
    names.map(read).collect()
}

/// The sources, whose names pages may use.
fn sources() -> Vec<String> {
    let is_source =
        |name: &String| [".rs", ".py", ".pyi", ".toml", ".json", ".yaml"].iter().any(|end| name.ends_with(end));
    let own = |name: &String| !name.ends_with("tests/cli/docs.rs");
    let files = files_below("").into_iter().filter(is_source).filter(own);
    files.map(|name| fs::read_to_string(root().join(name)).unwrap_or_default()).collect()
}

impl Page {
    /// The lines of its code blocks.
    fn code_lines(&self) -> impl Iterator<Item = &str> {
        let mut fenced = false;
        self.text.lines().filter_map(move |line| {
            if line.trim_start().starts_with("```") {
                fenced = !fenced;
                return None;
            }
            (fenced || line.starts_with("    ")).then(|| line.trim())
        })
    }

    /// What stands in `backticks` in its prose.
    fn spans(&self) -> impl Iterator<Item = &str> {
        let mut fenced = false;
        let prose = self.text.lines().filter(move |line| {
            let fence = line.trim_start().starts_with("```");
            fenced ^= fence;
            !fenced && !fence && !line.starts_with("    ")
        });
        prose.flat_map(|line| line.split('`').skip(1).step_by(2))
    }

    /// Commands of code blocks and spans, word by word.
    fn commands(&self) -> impl Iterator<Item = Vec<&str>> {
        let line = |text| {
            let before_comment: &str = str::split(text, " #").next().unwrap_or_default();
            before_comment.split_whitespace().collect::<Vec<_>>()
        };
        self.code_lines().chain(self.spans()).map(line).filter(|words| words.len() > 1)
    }

    /// Where its links lead that stay in the repository, without anchors.
    fn links(&self) -> impl Iterator<Item = &str> {
        let targets = self.text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let inside = targets.filter(|target| !target.contains("://") && !target.starts_with('#'));
        inside.map(|target| target.split('#').next().unwrap_or_default())
    }
}

/// Prints all that is wrong at once.
fn none_of(wrong: &BTreeSet<String>) {
    assert!(wrong.is_empty(), "{}", wrong.iter().map(|line| format!("\n{line}")).collect::<String>());
}

fn is_word(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Paths from the root, names of sources, and links lead to files.
#[test]
fn paths_exist() {
    let files = files_below("");
    let exists = |path: &str| {
        let path = path.trim_end_matches('/');
        files.iter().any(|file| file == path || file.starts_with(&format!("{path}/")))
    };
    let ends_some_path = |end: &str| {
        let (folder, middle) = (end.ends_with('/'), format!("/{end}"));
        files
            .iter()
            .map(|file| format!("/{file}"))
            .any(|file| file.ends_with(&middle) || folder && file.contains(&middle))
    };
    let mut wrong = BTreeSet::new();
    for page in pages() {
        // The site is made of copies in other places; its own program checks these links.
        for link in page.links().filter(|_| !page.name.starts_with("tools/site/")) {
            let path = root().join(&page.name).parent().expect("a folder").join(link);
            if !path.exists() {
                wrong.insert(format!("{}: the link {link} leads nowhere", page.name));
            }
        }
        for text in page.code_lines().chain(page.spans()) {
            for word in text.split(|c: char| c.is_whitespace() || "(),;:'\"|[]{}=".contains(c)) {
                let word = word.trim_end_matches('.');
                let tops =
                    ["docs/", "crates/", "scenes/", "examples/", "python/", "farm/", "tools/", ".ci/", ".github/"];
                let is_pattern = ["*", "<", "_N.", "…", "$"].iter().any(|part| word.contains(part));
                let from_root = tops.iter().any(|top| word.starts_with(top));
                if from_root && !is_pattern && !exists(word) && !ends_some_path(word) {
                    wrong.insert(format!("{}: there is no {word}", page.name));
                }
            }
        }
        let sources =
            page.spans().filter(|span| span.ends_with(".rs") || span.ends_with(".pyi") || span.ends_with('/'));
        for span in sources.filter(|span| !span.contains([' ', '*', ':', '<']) && span.len() > 1) {
            if !ends_some_path(span.trim_start_matches("../")) {
                wrong.insert(format!("{}: no file or folder is called {span}", page.name));
            }
        }
    }
    none_of(&wrong);
}

/// The options that each command of the program has, and all of the Python package's own programs together.
fn options_by_command() -> BTreeMap<&'static str, BTreeSet<String>> {
    let place = Place::new();
    let flags = |text: &str| -> BTreeSet<String> {
        let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
        words.filter(|word| word.starts_with("--") && word.len() > 2).map(str::to_owned).collect()
    };
    let mut options: BTreeMap<_, _> = ["render", "info", "compare", "reproduce", "completions", "man"]
        .map(|command| (command, flags(&place.run(&format!("{command} --help")).exits(0).stdout())))
        .into();
    let python = files_below("python/lightmesh").into_iter().chain(files_below("tools")).chain(files_below("examples"));
    let python = python.filter(|name| name.ends_with(".py"));
    let texts = python.map(|name| fs::read_to_string(root().join(name)).unwrap_or_default());
    options.insert("farm", texts.flat_map(|text| flags(&text)).chain(options["render"].clone()).collect());
    options
}

/// Options that commands are given, and those that prose names, exist.
#[test]
fn options_exist() {
    let options = options_by_command();
    let all: BTreeSet<&String> = options.values().flatten().collect();
    let mut wrong = BTreeSet::new();
    for page in pages() {
        for words in page.commands().filter(|words| words[0] == "lightmesh") {
            let Some(known) = options.get(words[1]) else {
                if !words[1].starts_with('-') && words[1] != "help" {
                    wrong.insert(format!("{}: there is no command lightmesh {}", page.name, words[1]));
                }
                continue;
            };
            for flag in words[2..].iter().filter(|word| word.starts_with("--") && word.len() > 2) {
                let flag = flag.split(['=', '|', ',']).next().unwrap_or_default();
                if !known.contains(flag) {
                    wrong.insert(format!("{}: lightmesh {} has no {flag}", page.name, words[1]));
                }
            }
        }
        for span in page.spans().filter(|span| span.starts_with("--")) {
            let flag = span.split([' ', '=']).next().unwrap_or_default().to_owned();
            if !all.contains(&flag) {
                wrong.insert(format!("{}: no command has {flag}", page.name));
            }
        }
    }
    none_of(&wrong);
}

/// The names that belong to each type: methods, constants, variants and fields, from its definition and its `impl`
/// blocks.
fn members(sources: &[String]) -> BTreeMap<String, BTreeSet<String>> {
    let mut members: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for source in sources {
        // Blocks begin and end in the first column: the sources are formatted.
        let mut owners: Vec<String> = Vec::new();
        for line in source.lines().filter(|line| !line.is_empty()) {
            let words: Vec<&str> =
                line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect();
            let is_outer = !line.starts_with([' ', '}', '/', '#']);
            if is_outer {
                let kind = words.iter().position(|word| ["struct", "enum", "trait", "impl", "type"].contains(word));
                owners = kind.map_or_else(Vec::new, |i| words[i + 1..].iter().map(|&word| word.to_owned()).collect());
                if kind.is_none() {
                    owners.clear();
                }
                for owner in &owners {
                    members.entry(owner.clone()).or_default();
                }
            } else if !line.trim_start().starts_with("//") {
                for owner in &owners {
                    members.entry(owner.clone()).or_default().extend(words.iter().map(|&word| word.to_owned()));
                }
            }
        }
    }
    members
}

/// `Type::member` is a member of that type, and names in snake case occur in the sources.
#[test]
fn functions_exist() {
    let sources = sources();
    let members = members(&sources);
    let words: BTreeSet<&str> =
        sources.iter().flat_map(|text| text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))).collect();
    let mut wrong = BTreeSet::new();
    for page in pages() {
        for span in page.spans() {
            let name = span.split('(').next().unwrap_or_default();
            let path: Vec<&str> = name.split("::").collect();
            // `_N` stands for numbers.
            if !path.iter().all(|word| is_word(word)) || name.ends_with("_N") {
                continue;
            }
            if let [.., owner, member] = path[..] {
                let is_type = owner.starts_with(|c: char| c.is_ascii_uppercase());
                let found = if is_type {
                    members.get(owner).is_some_and(|own| own.contains(member))
                } else {
                    words.contains(member)
                };
                if !found {
                    wrong.insert(format!("{}: there is no {name}", page.name));
                }
            } else if name.contains('_') && name.starts_with(|c: char| c.is_ascii_lowercase()) && !words.contains(name)
            {
                wrong.insert(format!("{}: nothing is called {name}", page.name));
            }
        }
    }
    none_of(&wrong);
}

/// Commands of cargo and Python are given packages, tests, examples and scripts that exist.
#[test]
fn commands_find_what_they_run() {
    let files = files_below("");
    let any = |test: &dyn Fn(&str) -> bool| files.iter().any(|file| test(file));
    let mut wrong = BTreeSet::new();
    for page in pages() {
        for words in page.commands() {
            let mut missing =
                |what: &str| wrong.insert(format!("{}: {}: there is no {what}", page.name, words.join(" ")));
            for (&word, &next) in words.iter().zip(&words[1..]) {
                let found = match (words[0], word) {
                    ("cargo", "-p") => any(&|file| file == format!("crates/{next}/Cargo.toml")),
                    ("cargo", "--example" | "--bench") => any(&|file| {
                        file.ends_with(&format!("/{next}.rs")) || file.contains(&format!("/{next}/main.rs"))
                    }),
                    // Each package's integration tests are one program.
                    ("cargo", "--test") => ["suite", "cli"].contains(&next),
                    ("python" | "python3", script) if script.ends_with(".py") => any(&|file| file == script),
                    _ => true,
                };
                if !found {
                    missing(if word.ends_with(".py") { word } else { next });
                }
                if words[0] == "cargo" && next.ends_with("::") {
                    let module = format!("/tests/{}.rs", next.trim_end_matches("::"));
                    if !any(&|file| file.ends_with(&module)) {
                        missing(&module);
                    }
                }
            }
        }
    }
    none_of(&wrong);
}

/// The checks can fail: of a page full of what is not there, each name is found.
#[test]
fn a_page_is_read_as_it_is_written() {
    let text = "See `Scene::render` and [it](a.md#b).\n\n    lightmesh render x.glb --spp 4   # a comment\n\n```sh\ncargo test -p y\n```\n";
    let page = Page { name: "docs/a.md".into(), text: text.into() };
    assert!(page.spans().eq(["Scene::render"]));
    assert!(page.links().eq(["a.md"]));
    let commands: Vec<_> = page.commands().collect();
    assert_eq!(commands, [vec!["lightmesh", "render", "x.glb", "--spp", "4"], vec!["cargo", "test", "-p", "y"]]);
    let members = members(&["impl Scene {\n    pub fn new() {}\n}\nfn other() {}\n".to_owned()]);
    assert!(members["Scene"].contains("new") && !members["Scene"].contains("other"));
}
