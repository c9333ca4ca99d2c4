//! What helps at the terminal: `help`, completions and manual pages.

use std::fs;

use crate::place::Place;

#[test]
fn help_is_a_command_too() {
    let place = Place::new();
    let asked = place.run("help render").exits(0);
    assert_eq!(asked.stdout(), place.run("render --help").exits(0).stdout());
    assert!(place.run("help").exits(0).stdout().contains("completions"));
    place.run("help bake").exits(2).says(&["bake"]);
}

/// Each shell gets a script that knows commands and options.
#[test]
fn every_shell_completes() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = place.run(&format!("completions {shell}")).exits(0);
        assert_eq!(run.stderr(), "");
        for word in ["lightmesh", "render", "compare", "time-limit", "unbiased"] {
            assert!(run.stdout().contains(word), "{shell}: {word}");
        }
    }
    place.run("completions tcsh").exits(2).says(&["tcsh", "bash", "zsh", "fish", "powershell", "elvish"]);
    assert_eq!(place.files(), ["scene.gltf"]);
}

#[test]
fn manual_pages_are_printed_or_written() {
    let place = Place::new();
    let page = place.run("man").exits(0).stdout();
    assert!(page.contains(".TH lightmesh 1") && page.contains("lightmesh\\-render(1)"), "{page}");
    assert_eq!(place.files(), ["scene.gltf"]);

    place.run("man -o share/man1").exits(0);
    let mut pages: Vec<_> = fs::read_dir(place.path("share/man1"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    pages.sort();
    let commands = ["compare", "completions", "info", "man", "render", "reproduce"];
    let mut expected: Vec<_> = commands.map(|command| format!("lightmesh-{command}.1")).to_vec();
    expected.push("lightmesh.1".to_owned());
    assert_eq!(pages, expected);
    let render = fs::read_to_string(place.path("share/man1/lightmesh-render.1")).unwrap();
    assert!(render.contains("\\-\\-time\\-limit"), "{render}");

    place.run("man -o scene.gltf").exits(1).says(&["scene.gltf"]);
}
