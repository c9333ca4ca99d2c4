//! The faces and the page about options are those of the table.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use lightmesh::schema::{Group, Kind};
use lightmesh_cli::{Choice, choices};

use crate::place::Place;

/// Every option is in the help, with its name for a value, its default and its words.
#[test]
fn help_has_every_option_of_the_table() {
    let help = Place::new().run("render --help").exits(0).stdout().split_whitespace().collect::<Vec<_>>().join(" ");
    for Choice { about, default } in choices() {
        let value = format!("--{} <{}>", about.name, about.value_name);
        let default = default.map(|default| format!("[default: {default}]"));
        let note = about.default_note.map(|note| format!("[default: {note}]"));
        for part in [Some(value), default, note, Some(about.help.to_owned())].into_iter().flatten() {
            assert!(help.contains(&part), "{part} in {help}");
        }
        if let Kind::Word { words, .. } = about.kind {
            assert!(words.iter().all(|(word, line)| help.contains(&format!("- {word}: {line}"))), "{}", about.name);
        }
    }
}

/// Returns the page about options.
fn page() -> String {
    let mut page = "# Options\n\n\
        The options of a picture: of `lightmesh render`, of `Scene.render` and `LightMesh` in Python (with underscores for dashes), and of \
        `lightmesh farm`.\nThis page is written from the table of options in `crates/lightmesh/src/options/schema.rs`: \
        `WRITE_DOCS=1 cargo test -p lightmesh-cli --test cli options::` writes it.\n"
        .to_owned();
    for group in Group::ALL {
        let _ = write!(
            page,
            "\n## {}\n\n| option | value | default | methods | |\n|---|---|---|---|---|\n",
            group.heading()
        );
        for Choice { about, default } in choices().iter().filter(|choice| choice.about.group == group) {
            let default = about.default_note.map(str::to_owned).or(default.as_ref().map(ToString::to_string));
            let methods = if about.methods.is_empty() { "all".to_owned() } else { about.methods.join(", ") };
            let old = about.old_name.map_or(String::new(), |name| format!(". Until 0.2 called `--{name}`"));
            let since = if about.since == "0.1" { String::new() } else { format!(". Since {}", about.since) };
            let cells = [
                format!("`--{}`", about.name),
                about.kind.expected(),
                default.unwrap_or_else(|| "none".to_owned()),
                methods,
                format!("{}{old}{since}", about.help),
            ];
            let _ = writeln!(page, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
        }
    }
    page
}

#[test]
fn the_page_about_options_is_that_of_the_table() {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/options.md"));
    if std::env::var_os("WRITE_DOCS").is_some() {
        fs::write(&path, page()).expect("docs/options.md");
    }
    let written = fs::read_to_string(&path).expect("docs/options.md").replace('\r', "");
    assert!(written == page(), "docs/options.md is old: run again with WRITE_DOCS=1");
}
