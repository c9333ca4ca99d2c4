//! The number of threads, from the outside.

use std::fs;
use std::process::{Command, Output};

use crate::place::Place;

const LINE: &str = "render scene.gltf -o a.png -o a.exr --stats a.json --size 40x24 --spp 1";

/// Runs the program where RAYON_NUM_THREADS has this value.
fn run(place: &Place, variable: Option<&str>, line: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_lightmesh"));
    program.current_dir(place.folder.path()).args(line.split_whitespace()).env_remove("RAYON_NUM_THREADS");
    program.envs(variable.map(|count| ("RAYON_NUM_THREADS", count))).output().unwrap()
}

/// The threads of the render whose statistics were written.
fn threads(place: &Place) -> u64 {
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(place.path("a.json")).unwrap()).unwrap();
    stats["threads"].as_u64().unwrap()
}

#[test]
fn too_many_threads_are_cut_down_and_the_picture_is_the_same() {
    let place = Place::new();
    let cores = std::thread::available_parallelism().unwrap().get() as u64;
    let most = (4 * cores).max(64);
    assert!(run(&place, None, LINE).status.success());
    assert_eq!(threads(&place), cores);
    let picture = fs::read(place.path("a.png")).unwrap();
    for (variable, option, who) in [
        (Some("100000"), "", "warning: RAYON_NUM_THREADS: "),
        (Some("99999999999999999999999"), "", "warning: RAYON_NUM_THREADS: "),
        (None, "--threads 4096", "warning: threads: "),
    ] {
        if most >= 4096 {
            continue;
        }
        let output = run(&place, variable, &format!("{LINE} {option}"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && said.contains(who) && said.contains(&most.to_string()), "{said}");
        assert_eq!(threads(&place), most);
        assert!(fs::read(place.path("a.png")).unwrap() == picture, "{variable:?} {option}");
    }
    // The option counts, and what is no number does not.
    for (variable, option, count) in [("100000", "--threads 3", 3), ("3", "", 3), ("0", "", cores), ("x", "", cores)] {
        let output = run(&place, Some(variable), &format!("{LINE} {option} --quiet"));
        assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
        assert_eq!(threads(&place), count, "{variable} {option}");
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    let place = Place::new();
    for count in ["0", "1000000", "99999999999999999999999"] {
        place.run(&format!("{LINE} --threads {count}")).exits(2).says(&["--threads", "4096"]);
    }
    assert_eq!(place.files(), ["scene.gltf"]);
}

/// Other commands have threads too.
#[test]
fn describing_and_comparing_heed_the_limit() {
    let place = Place::new();
    assert!(run(&place, None, LINE).status.success());
    for line in ["info scene.gltf", "compare a.exr a.exr"] {
        let output = run(&place, Some("100000"), line);
        assert!(output.status.success(), "{line}: {output:?}");
    }
}

/// The system has no memory for so many stacks.
#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_be_started_are_an_error() {
    let place = Place::new();
    let output = Command::new("sh")
        .current_dir(place.folder.path())
        .args(["-c", &format!("ulimit -v 300000; exec \"$L\" {LINE} --threads 64")])
        .env("L", env!("CARGO_BIN_EXE_lightmesh"))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: threads: 64 threads cannot be started") && said.lines().count() == 1, "{said}");
    assert_eq!(place.files(), ["scene.gltf"]);
}
