//! Outputs take the place of nothing that is still needed, and appear whole or not at all.

use std::fs;
use std::path::Path;

use crate::place::Place;

/// A render that would take hours: what is refused is refused before.
const LONG: &str = "--size 5000x5000 --spp 60000 --quiet";

impl Place {
    /// `scene.gltf` with its buffer and an image, which nothing uses, in files of their own; an OBJ with its materials
    /// and a texture; a map of the sky; a light mesh.
    fn with_files() -> Self {
        let place = Self::new();
        let data = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
        let scene = fs::read_to_string(place.path("scene.gltf")).unwrap();
        place.run("render scene.gltf -o sky.exr -o wood.png --save-mesh old.mesh --size 8x4 --quiet").exits(0);
        let images = r#""images": [{ "uri": "unused%20image.png" }], "buffers""#;
        place.write("scene.gltf", &scene.replace(data, "data.exr").replace(r#""buffers""#, images));
        let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        fs::write(place.path("data.exr"), floats.map(f32::to_le_bytes).concat()).unwrap();
        fs::copy(place.path("wood.png"), place.path("unused image.png")).unwrap();
        place.write("a.obj", "mtllib a.png\nusemtl wood\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        place.write("a.png", "newmtl wood\nmap_Kd wood.png\nnewmtl unused\nmap_Ke sky.exr\n");
        fs::create_dir(place.path("dir")).unwrap();
        place
    }

    /// Every file and what it holds.
    fn contents(&self) -> Vec<(String, Vec<u8>)> {
        self.files().into_iter().map(|name| (name.clone(), fs::read(self.path(&name)).unwrap_or_default())).collect()
    }
}

#[test]
fn what_is_read_is_not_replaced() {
    let place = Place::with_files();
    fs::copy(place.path("scene.gltf"), place.path("copy.gltf")).unwrap();
    let before = place.contents();
    for (line, words) in [
        ("scene.gltf -o b.png --stats scene.gltf", ["scene.gltf: --stats", "the scene scene.gltf"]),
        ("scene.gltf -o b.png --save-mesh scene.gltf", ["scene.gltf: --save-mesh", "the scene scene.gltf"]),
        ("scene.gltf -o b.png --stats dir/../scene.gltf", ["dir/../scene.gltf: --stats", "the scene scene.gltf"]),
        ("dir/../scene.gltf -o b.png --stats ./scene.gltf", ["./scene.gltf: --stats", "the scene dir/../scene.gltf"]),
        ("scene.gltf -o data.exr", ["data.exr: --output", "a file of the scene, ./data.exr"]),
        ("scene.gltf -o b.png --stats data.exr", ["data.exr: --stats", "a file of the scene, ./data.exr"]),
        ("scene.gltf -o b.png --save-mesh dir/../data.exr", ["dir/../data.exr: --save-mesh", "./data.exr"]),
        ("a.obj -o a.png", ["a.png: --output", "a file of the scene, ./a.png"]),
        ("a.obj -o b.png --preview wood.png", ["wood.png: --preview", "a file of the scene, ./wood.png"]),
        ("a.obj -o sky.exr", ["sky.exr: --output", "a file of the scene, ./sky.exr"]),
        ("scene.gltf --environment sky.exr -o ./sky.exr", ["./sky.exr: --output", "the environment map sky.exr"]),
        ("scene.gltf --mesh old.mesh --save-mesh old.mesh -o b.png", ["old.mesh: --save-mesh", "the light mesh"]),
        ("scene.gltf --mesh old.mesh --stats ./old.mesh -o b.png", ["./old.mesh: --stats", "--mesh, old.mesh"]),
    ] {
        place.run(&format!("render {line} {LONG}")).exits(2).says(&words);
        assert!(place.contents() == before, "{line}");
    }
    // An image that the scene names and does not use; its name has a space.
    let unused = place.path("unused image.png");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_lightmesh"))
        .current_dir(place.folder.path())
        .args(["render", "scene.gltf", "--size", "5000x5000", "--spp", "60000", "-o"])
        .arg(&unused)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("a file of the scene, ./unused image.png"));
    assert!(place.contents() == before);
}

/// Temporaries of dead writers are removed, but not what only has the name of one.
#[test]
fn what_is_read_may_have_the_name_of_a_temporary() {
    let place = Place::with_files();
    let taken = |output: &str| format!(".{output}.lightmesh.partial");
    fs::copy(place.path("old.mesh"), place.path(&taken("c.png"))).unwrap();
    fs::copy(place.path("old.mesh"), place.path(".g.png.lightmesh.old")).unwrap();
    fs::copy(place.path("old.mesh"), place.path(".h.png.9999999999-0.partial")).unwrap();
    fs::copy(place.path("scene.gltf"), place.path(&taken("d.png"))).unwrap();
    fs::copy(place.path("data.exr"), place.path(&taken("f.png"))).unwrap();
    let scene = fs::read_to_string(place.path("scene.gltf")).unwrap().replace("data.exr", &taken("f.png"));
    place.write("other.gltf", &scene);
    let before = place.contents();
    for (line, what) in [
        ("scene.gltf --mesh .c.png.lightmesh.partial -o c.png", "the light mesh of --mesh"),
        ("scene.gltf -o c.png --mesh ./.c.png.lightmesh.partial", "the light mesh of --mesh"),
        (".d.png.lightmesh.partial -o d.png", "the scene"),
        ("other.gltf -o f.png", "a file of the scene"),
        ("scene.gltf -o g.png --mesh .g.png.lightmesh.old", "the light mesh of --mesh"),
        ("scene.gltf -o h.png --mesh .h.png.9999999999-0.partial", "the light mesh of --mesh"),
    ] {
        place.run(&format!("render {line} {LONG}")).exits(2).says(&[": --output would replace", what]);
        assert!(place.contents() == before, "{line}");
    }
    // Another scene does not need it.
    place.run("render scene.gltf -o f.png --size 8x4 --quiet").exits(0);
    assert!(place.path("f.png").exists() && !place.path(&taken("f.png")).exists());
}

#[test]
fn two_outputs_are_two_files() {
    let place = Place::new();
    fs::create_dir(place.path("dir")).unwrap();
    place.write("old.png", "old");
    fs::hard_link(place.path("old.png"), place.path("hard.png")).unwrap();
    let before = place.contents();
    for (line, words) in [
        ("-o b.png -o b.png", &["b.png", "twice"][..]),
        ("-o b.png -o ./b.png", &["./b.png", "twice", "the same file as b.png"]),
        ("-o b.png --preview dir/../b.png", &["dir/../b.png", "the same file as b.png"]),
        ("-o old.png --preview hard.png", &["hard.png", "the same file as old.png"]),
        ("-o b.png --stats s --save-mesh dir/../s", &["dir/../s", "the same file as s"]),
    ] {
        place.run(&format!("render scene.gltf {line} {LONG}")).exits(2).says(words);
        assert!(place.contents() == before, "{line}");
    }
}

/// The file system decides which letters are the same.
#[test]
fn names_that_differ_in_case_alone_are_one_file_where_they_are() {
    let place = Place::new();
    place.write("probe", "");
    let line = "render scene.gltf -o b.png -o B.png --size 8x8 --quiet";
    match place.path("PROBE").exists() {
        true => drop(place.run(line).exits(2).says(&["B.png", "the same file as b.png"])),
        false => drop(place.run(line).exits(0)),
    }
}

#[cfg(unix)]
mod on_unix {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    use std::process::{Child, Command, Output, Stdio};
    use std::thread;
    use std::time::{Duration, Instant};

    use super::*;

    const PROGRAM: &str = env!("CARGO_BIN_EXE_lightmesh");
    const SHORT: &str = "--size 40x24 --method standard --spp 1 --quiet";

    impl Place {
        /// Runs a line of the shell, in which `$L` is the program.
        fn shell(&self, line: &str) -> Output {
            let mut shell = Command::new("sh");
            shell.current_dir(self.folder.path()).env("L", PROGRAM).args(["-c", line]).stdin(Stdio::null());
            shell.output().unwrap()
        }

        fn fifo(&self, name: &str) {
            assert!(Command::new("mkfifo").arg(self.path(name)).status().unwrap().success());
        }

        /// Starts a render of hours, and waits until it has begun.
        fn start(&self, line: &str) -> Child {
            let mut child = Command::new(PROGRAM)
                .current_dir(self.folder.path())
                .args(line.split_whitespace())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            let started = Instant::now();
            while !self.files().iter().any(|name| name.ends_with(".partial")) {
                assert!(started.elapsed() < Duration::from_secs(20) && child.try_wait().unwrap().is_none());
                thread::sleep(Duration::from_millis(5));
            }
            // All outputs are claimed within moments.
            thread::sleep(Duration::from_millis(300));
            child
        }
    }

    fn end(mut child: Child, signal: &str) {
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        child.wait().unwrap();
    }

    #[test]
    fn links_to_what_is_read_are_seen_through() {
        let place = Place::with_files();
        symlink("scene.gltf", place.path("soft")).unwrap();
        symlink("soft", place.path("softer")).unwrap();
        fs::hard_link(place.path("data.exr"), place.path("hard.exr")).unwrap();
        symlink("dir/../sky.exr", place.path("sky-link.exr")).unwrap();
        let before = place.contents();
        for (line, words) in [
            ("scene.gltf -o b.png --stats soft", ["soft: --stats", "the scene scene.gltf"]),
            ("scene.gltf -o b.png --save-mesh softer", ["softer: --save-mesh", "the scene scene.gltf"]),
            ("scene.gltf -o hard.exr", ["hard.exr: --output", "a file of the scene, ./data.exr"]),
            (
                "scene.gltf --environment sky-link.exr -o sky.exr",
                ["sky.exr: --output", "the environment map sky-link.exr"],
            ),
        ] {
            place.run(&format!("render {line} {LONG}")).exits(2).says(&words);
            assert!(place.contents() == before, "{line}");
        }
    }

    #[test]
    fn a_link_stays_a_link_and_permissions_stay() {
        let place = Place::new();
        fs::create_dir(place.path("real")).unwrap();
        place.write("real/old.png", "old");
        fs::set_permissions(place.path("real/old.png"), fs::Permissions::from_mode(0o640)).unwrap();
        symlink("real/old.png", place.path("a.png")).unwrap();
        symlink("real/new.exr", place.path("a.exr")).unwrap();
        place.run(&format!("render scene.gltf -o a.png -o a.exr {SHORT}")).exits(0);
        for (link, target) in [("a.png", "real/old.png"), ("a.exr", "real/new.exr")] {
            assert!(fs::symlink_metadata(place.path(link)).unwrap().is_symlink());
            assert!(fs::metadata(place.path(target)).unwrap().len() > 100);
        }
        assert_eq!(fs::metadata(place.path("real/old.png")).unwrap().permissions().mode() & 0o777, 0o640);
        assert_eq!(fs::read_dir(place.path("real")).unwrap().count(), 2);
    }

    #[test]
    fn devices_and_pipes_are_written_to() {
        let place = Place::new();
        place.run(&format!("render scene.gltf -o plain.png {SHORT}")).exits(0);
        let plain = fs::read(place.path("plain.png")).unwrap();
        symlink("/dev/stdout", place.path("out.png")).unwrap();
        place.fifo("pipe.png");
        let is_stats = |bytes: &[u8]| serde_json::from_slice::<serde_json::Value>(bytes).unwrap()["rays"].is_object();

        // Into a pipe, two devices, and a file that the shell has opened, at its end.
        let output = place.shell(&format!("$L render scene.gltf -o a.png --stats /dev/stdout {SHORT}"));
        assert!(output.status.success() && is_stats(&output.stdout), "{output:?}");
        let line = format!("$L render scene.gltf -o a.png --stats /dev/null --save-mesh /dev/null {SHORT}");
        assert!(place.shell(&line.replace("standard", "mesh")).status.success());
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        for redirect in ["--stats /dev/fd/3 3>file", "--stats /dev/stdout >file", "--stats /dev/stderr 2>file"] {
            let output = place.shell(&format!("$L render scene.gltf -o a.png {SHORT} {redirect}"));
            assert!(
                output.status.success() && is_stats(&fs::read(place.path("file")).unwrap()),
                "{redirect} {output:?}"
            );
        }
        let around =
            format!("(echo before; $L render scene.gltf -o a.png --stats /dev/stdout {SHORT}; echo after) >file");
        assert!(place.shell(&around).status.success());
        let text = fs::read_to_string(place.path("file")).unwrap();
        assert!(text.starts_with("before\n{") && text.ends_with("}\nafter\n"), "{text}");

        // A picture by the name of a link, and into a named pipe.
        let output = place.shell(&format!("$L render scene.gltf -o out.png {SHORT}"));
        assert!(output.status.success() && output.stdout == plain);
        let output = place.shell(&format!("cat pipe.png >got & $L render scene.gltf -o pipe.png {SHORT} && wait"));
        assert!(output.status.success() && fs::read(place.path("got")).unwrap() == plain);
        assert!(fs::metadata(place.path("pipe.png")).unwrap().file_type().is_fifo());
        assert_eq!(place.files(), ["a.png", "file", "got", "out.png", "pipe.png", "plain.png", "scene.gltf"]);
    }

    #[test]
    fn pipes_and_devices_are_not_read() {
        let place = Place::with_files();
        for name in ["pipe.glb", "pipe.hdr", "pipe.mesh", "pipe.bin", "pipe"] {
            place.fifo(name);
        }
        for name in ["zero.glb", "zero.exr", "zero"] {
            symlink("/dev/zero", place.path(name)).unwrap();
        }
        let scene = fs::read_to_string(place.path("scene.gltf")).unwrap();
        for buffer in ["pipe.bin", "zero.exr"] {
            place.write(&format!("{buffer}.gltf"), &scene.replace("data.exr", buffer));
        }
        let started = Instant::now();
        for (line, words) in [
            ("render pipe.glb", ["pipe.glb", "not a file"]),
            ("render zero.glb", ["zero.glb", "not a file"]),
            ("render pipe", ["pipe", "not a file"]),
            ("render zero", ["zero", "not a file"]),
            ("render /dev/stdin", ["/dev/stdin", "not a file"]),
            ("render pipe.bin.gltf --allow-outside", ["pipe.bin", "not a regular file"]),
            ("render zero.exr.gltf --allow-outside", ["zero.exr", "not a regular file"]),
            ("render scene.gltf --environment pipe.hdr", ["pipe.hdr", "not a regular file"]),
            ("render scene.gltf --environment zero.exr", ["zero.exr", "not a regular file"]),
            ("render scene.gltf --mesh pipe.mesh", ["pipe.mesh", "not a regular file"]),
        ] {
            let output = place.shell(&format!("$L {line} -o b.png --size 8x8 --quiet </dev/zero"));
            let said = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{line}: {said}");
            assert!(said.lines().count() == 1 && words.iter().all(|word| said.contains(word)), "{line}: {said}");
        }
        assert!(started.elapsed() < Duration::from_secs(60));
    }

    /// A file that the shell opens is as good as its name.
    #[test]
    fn standard_input_may_be_a_file() {
        let place = Place::new();
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/triangle.glb");
        fs::copy(scene, place.path("a.glb")).unwrap();
        let output = place.shell(&format!("$L render /dev/stdin -o b.png {SHORT} <a.glb"));
        assert!(output.status.success(), "{output:?}");
        let output = place.shell(&format!("$L render /dev/stdin -o b.png --stats a.glb {SHORT} <a.glb"));
        assert_eq!(output.status.code(), Some(2), "{output:?}");
    }

    /// kill -9 leaves temporaries, which the next run with the same outputs removes.
    #[test]
    fn what_a_killed_run_left_is_removed_by_the_next() {
        let place = Place::new();
        place.write("a.png", "old");
        let child = place.start("render scene.gltf -o a.png -o a.exr --size 2000x2000 --spp 60000 --method path");
        let partials = place.files().iter().filter(|name| name.ends_with(".partial")).count();
        end(child, "-KILL");
        assert_eq!(partials, 2);
        assert_eq!(fs::read(place.path("a.png")).unwrap(), b"old");
        place.write(".a.png.9999999999-0.partial", "as older versions leave it");
        place.run(&format!("render scene.gltf -o a.png -o a.exr {SHORT}")).exits(0);
        assert_eq!(place.files(), ["a.exr", "a.png", "scene.gltf"]);
    }

    #[test]
    fn of_two_runs_with_one_output_the_second_is_told() {
        let place = Place::new();
        let long = "--size 2000x2000 --spp 60000 --method path";
        let first = place.start(&format!("render scene.gltf -o a.png -o b.exr --preview c.png {long}"));
        for (line, name) in [("-o b.exr", "b.exr"), ("-o z.png -o ./a.png", "a.png"), ("-o c.png", "c.png")] {
            let line = format!("render scene.gltf {line} {SHORT}");
            place.run(&line).exits(1).says(&[name, "another program is writing it"]);
        }
        end(first, "-INT");
        let left: Vec<String> = place.files().into_iter().filter(|name| name != "c.png").collect();
        assert_eq!(left, ["scene.gltf"]);
        place.run(&format!("render scene.gltf -o a.png -o b.exr {SHORT}")).exits(0);
    }

    /// Whoever is told leaves no file, and the files of the others belong together.
    #[test]
    fn of_many_runs_at_once_each_wins_or_is_told() {
        let place = Place::new();
        let line = format!("render scene.gltf {SHORT} --stats a.json");
        let runs: Vec<Child> = (0..8)
            .map(|i| {
                // In either order of the outputs, and each of its own size.
                let outputs = if i % 2 == 0 { "-o a.png -o a.exr" } else { "-o a.exr -o a.png" };
                let size = format!("{}x{}", 20 + i, 10 + i);
                let line = format!("{line} {outputs}").replace("40x24", &size);
                let mut run = Command::new(PROGRAM);
                run.current_dir(place.folder.path())
                    .args(line.split_whitespace())
                    .stderr(Stdio::piped())
                    .spawn()
                    .unwrap()
            })
            .collect();
        let mut winners = 0;
        for run in runs {
            let output = run.wait_with_output().unwrap();
            let said = String::from_utf8(output.stderr).unwrap();
            match output.status.code() {
                Some(0) => winners += 1,
                code => assert!(code == Some(1) && said.contains("another program is writing it"), "{code:?} {said}"),
            }
        }
        assert!(winners >= 1);
        assert_eq!(place.files(), ["a.exr", "a.json", "a.png", "scene.gltf"]);
        place.run("compare a.png a.exr").exits(0);
    }

    /// The disk ends after so many blocks of 512 bytes: old files stay, whichever output is the one that fails.
    #[test]
    fn a_disk_that_is_full_leaves_old_files_whole() {
        let place = Place::new();
        let outputs = ["a.png", "a.exr", "a.json", "a.mesh"];
        let line = "render scene.gltf --size 64x64 --quiet -o a.png -o a.exr --stats a.json --save-mesh a.mesh";
        let mut failed = Vec::new();
        for blocks in [0, 1, 2, 4, 8, 16, 32, 64, 128, 1024] {
            outputs.iter().for_each(|name| place.write(name, &format!("old {name}")));
            let before = place.contents();
            // A write past the limit is an error; its signal would end the program and leave its temporaries.
            let output = place.shell(&format!("ulimit -f {blocks}; exec $L {line}"));
            let said = String::from_utf8(output.stderr).unwrap();
            if output.status.success() {
                assert!(outputs.iter().all(|name| !fs::read(place.path(name)).unwrap().starts_with(b"old")));
                assert_eq!(place.files().len(), 5);
                continue;
            }
            assert_eq!(output.status.code(), Some(1), "{blocks}: {said}");
            let name = outputs.iter().find(|name| said.starts_with(&format!("error: {name}: cannot be written")));
            failed.push(*name.unwrap_or_else(|| panic!("{blocks}: {said}")));
            assert!(place.contents() == before, "{blocks}: {said}");
        }
        failed.dedup();
        assert!(failed.len() > 1 && failed.len() < 10, "{failed:?}");
    }

    #[test]
    fn a_device_that_is_full_fails_before_any_file_is_replaced() {
        let place = Place::new();
        if !Path::new("/dev/full").exists() {
            return;
        }
        place.write("a.png", "old");
        symlink("/dev/full", place.path("full.exr")).unwrap();
        place
            .run(&format!("render scene.gltf -o a.png -o full.exr {SHORT}"))
            .exits(1)
            .says(&["full.exr: cannot be written"]);
        assert_eq!(fs::read(place.path("a.png")).unwrap(), b"old");
        for line in ["help", "--version", "info scene.gltf"] {
            let output = place.shell(&format!("exec $L {line} > /dev/full"));
            assert_eq!(output.status.code(), Some(1), "{line}");
            assert!(String::from_utf8_lossy(&output.stderr).contains("cannot be written"), "{line}");
        }
        assert_eq!(place.files(), ["a.png", "full.exr", "scene.gltf"]);
    }

    /// A folder takes the name of an output while the picture is made.
    #[test]
    fn a_name_that_cannot_be_given_leaves_old_files_whole() {
        let place = Place::new();
        place.write("a.png", "old");
        let line = "render scene.gltf -o a.png -o a.exr --size 200x200 --method path --time-limit 2 --quiet";
        let mut child = place.start(line);
        fs::create_dir(place.path("a.exr")).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(1));
        assert_eq!(fs::read(place.path("a.png")).unwrap(), b"old");
        assert_eq!(place.files(), ["a.exr", "a.png", "scene.gltf"]);
    }

    /// Even who cleans up in the middle of a render gets the picture.
    #[test]
    fn a_temporary_that_somebody_removes_is_made_again() {
        let place = Place::new();
        let line = "render scene.gltf -o a.png --size 200x200 --method path --time-limit 2 --quiet";
        let mut child = place.start(line);
        fs::remove_file(place.path(".a.png.lightmesh.partial")).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0));
        assert_eq!(place.files(), ["a.png", "scene.gltf"]);
    }
}
