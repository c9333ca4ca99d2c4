//! A folder with a small scene, and the program run in it.

use std::{fs, path::PathBuf, process::Output};

use assert_cmd::Command;
use tempfile::TempDir;

/// A temporary folder with `scene.gltf`: a triangle, a lamp and a camera called "front".
pub(crate) struct Place {
    pub(crate) folder: TempDir,
}

/// A triangle of positions (0,0,0), (1,0,0), (0,1,0), little-endian floats in base64, seen by one camera, lit by one
/// lamp.
const SCENE: &str = r#"{
  "asset": { "version": "2.0" },
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 100.0 }] } },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1, 2] }],
  "nodes": [
    { "mesh": 0 },
    { "camera": 0, "name": "front", "translation": [0.3, 0.3, 3.0] },
    { "translation": [2.0, 2.0, 2.0], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
  ],
  "cameras": [{ "type": "perspective", "name": "front", "perspective": { "yfov": 0.7, "aspectRatio": 2.0, "znear": 0.1 } }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
  "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "buffers": [{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
}"#;

impl Place {
    pub(crate) fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        place.write("scene.gltf", SCENE);
        place
    }

    /// The scene without its lamp (and so without any light).
    pub(crate) fn write_unlit(&self, name: &str) {
        self.write(
            name,
            &SCENE.replace(r#", "extensions": { "KHR_lights_punctual": { "light": 0 } }"#, "").replace(
                r#""extensionsUsed": ["KHR_lights_punctual"],
  "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 100.0 }] } },"#,
                "",
            ),
        );
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Every file in the folder, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(self.folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs a line such as `render scene.gltf -o a.png` here; words are separated by spaces.
    pub(crate) fn run(&self, line: &str) -> Run {
        self.run_with(&[], line)
    }

    /// The same with variables of the environment.
    pub(crate) fn run_with(&self, variables: &[(&str, &str)], line: &str) -> Run {
        let mut command = Command::cargo_bin("lightmesh").unwrap();
        command.envs(variables.iter().copied());
        let output = command.current_dir(self.folder.path()).args(line.split_whitespace()).output().unwrap();
        Run { line: line.to_owned(), output }
    }
}

/// What a run left.
pub(crate) struct Run {
    line: String,
    output: Output,
}

impl Run {
    pub(crate) fn stdout(&self) -> String {
        String::from_utf8(self.output.stdout.clone()).unwrap()
    }

    pub(crate) fn stderr(&self) -> String {
        String::from_utf8(self.output.stderr.clone()).unwrap()
    }

    /// Asserts the exit code.
    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Self {
        assert_eq!(self.output.status.code(), Some(code), "{}\n{}", self.line, self.stderr());
        self
    }

    /// Asserts that stderr is one line that starts with `error: ` and holds each word.
    #[track_caller]
    pub(crate) fn says(self, words: &[&str]) -> Self {
        let stderr = self.stderr();
        assert_eq!(stderr.lines().count(), 1, "{}\n{stderr}", self.line);
        assert!(stderr.starts_with("error: ") && stderr.ends_with('\n'), "{}\n{stderr}", self.line);
        for word in words {
            assert!(stderr.contains(word), "{}\nno {word:?} in {stderr}", self.line);
        }
        self
    }
}
