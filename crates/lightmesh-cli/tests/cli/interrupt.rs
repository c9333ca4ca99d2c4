//! Ctrl-C, as the shell sends it.

use std::{
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::place::Place;

/// A render that would take hours ends within a second of SIGINT with exit code 130 and leaves no file.
#[test]
fn ends_within_a_second_and_leaves_nothing() {
    let place = Place::new();
    for method in ["standard", "mesh", "path"] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_lightmesh"))
            .current_dir(place.folder.path())
            .args(["render", "scene.gltf", "-o", "a.exr", "-o", "a.png", "--stats", "a.json"])
            .args(["--method", method, "--size", "1000x1000", "--spp", "60000"])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(500));
        assert!(child.try_wait().unwrap().is_none(), "{method} was done too early to interrupt");

        let pressed = Instant::now();
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let status = child.wait().unwrap();
        assert!(pressed.elapsed() < Duration::from_millis(1000), "{method}: {:?}", pressed.elapsed());
        assert_eq!(status.code(), Some(130), "{method}");
        assert_eq!(place.files(), ["scene.gltf"], "{method}");
    }
}
