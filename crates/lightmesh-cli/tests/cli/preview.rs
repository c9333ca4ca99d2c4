//! `--preview` from the outside.

use std::{
    fs,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::place::Place;

#[test]
fn the_preview_becomes_the_finished_picture_and_changes_nothing() {
    let place = Place::new();
    for method in ["mesh", "paper", "standard", "path"] {
        let line = format!("render scene.gltf --size 40x24 --method {method} --quiet");
        place.run(&format!("{line} -o plain.png")).exits(0);
        let run = place.run(&format!("{line} -o a.png --preview so-far.png")).exits(0);
        assert_eq!(run.stderr(), "");
        assert_eq!(place.files(), ["a.png", "plain.png", "scene.gltf", "so-far.png"]);
        let bytes = |name| fs::read(place.path(name)).unwrap();
        assert_eq!(bytes("so-far.png"), bytes("a.png"), "{method}");
        assert_eq!(bytes("plain.png"), bytes("a.png"), "{method}");
    }
}

#[test]
fn a_preview_that_cannot_be_written_is_refused_at_once() {
    let place = Place::new();
    fs::create_dir(place.path("folder.png")).unwrap();
    for (preview, words) in [
        ("no/a.png", &["no/a.png", "does not exist"][..]),
        ("folder.png", &["folder.png", "is a folder"]),
        ("a.exr", &["a.exr", ".png"]),
        ("so-far", &["so-far", ".png"]),
        ("b.png", &["b.png", "twice"]),
    ] {
        // A size that would take hours: nothing is rendered before.
        let line = format!("render scene.gltf -o b.png --size 5000x5000 --spp 60000 --preview {preview}");
        place.run(&line).exits(2).says(words);
        assert_eq!(place.files(), ["folder.png", "scene.gltf"], "{preview}");
    }
}

/// Starts a render of hours and waits for its preview.
fn render_for_hours(place: &Place, stderr: Stdio) -> Child {
    let mut child = Command::new(env!("CARGO_BIN_EXE_lightmesh"))
        .current_dir(place.folder.path())
        .args(["render", "scene.gltf", "-o", "a.exr", "--preview", "views/so-far.png"])
        .args(["--method", "path", "--size", "600x400", "--spp", "60000", "--threads", "2"])
        .stderr(stderr)
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !place.path("views/so-far.png").exists() {
        assert!(started.elapsed() < Duration::from_secs(20), "no preview");
        assert!(child.try_wait().unwrap().is_none(), "done too early");
        thread::sleep(Duration::from_millis(20));
    }
    child
}

fn interrupt(child: &mut Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

/// Early, and after Ctrl-C still there, whole: a picture of the full size that `compare` reads.
#[test]
fn ctrl_c_leaves_the_preview_whole() {
    let place = Place::new();
    fs::create_dir(place.path("views")).unwrap();
    let mut child = render_for_hours(&place, Stdio::null());
    interrupt(&mut child);
    let left: Vec<_> = fs::read_dir(place.path("views")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["so-far.png"]);
    assert_eq!(place.files(), ["scene.gltf", "views"]);
    place.run("compare views/so-far.png views/so-far.png").exits(0);
}

/// Its folder is taken away while the render goes on: one warning.
#[test]
fn a_preview_that_fails_later_is_one_warning() {
    let place = Place::new();
    fs::create_dir(place.path("views")).unwrap();
    let mut child = render_for_hours(&place, Stdio::piped());
    fs::remove_dir_all(place.path("views")).unwrap();
    thread::sleep(Duration::from_millis(3500));
    interrupt(&mut child);
    let said = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    let said: Vec<&str> = said.lines().filter(|line| line.contains("preview")).collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].starts_with("warning: the preview") && said[0].contains("so-far.png"), "{said:?}");
}
