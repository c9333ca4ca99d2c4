//! `lightmesh render` from the outside.

use crate::place::Place;
use serde_json::Value;

#[test]
fn a_picture_is_written_in_both_formats_with_statistics() {
    let place = Place::new();
    let run = place.run("render scene.gltf -o a.png -o a.exr --size 32x16 --spp 1 --stats a.json --threads 2").exits(0);
    assert_eq!(place.files(), ["a.exr", "a.json", "a.png", "scene.gltf"]);
    assert!(run.stderr().contains("a.png, a.exr in ") && run.stderr().contains(" EV"), "{}", run.stderr());

    let stats: Value = serde_json::from_str(&std::fs::read_to_string(place.path("a.json")).unwrap()).unwrap();
    assert_eq!(stats["method"], "auto");
    assert_eq!(stats["scene"], "scene.gltf");
    assert_eq!(stats["threads"], 2);
    assert_eq!(stats["lights"], 1);
    assert_eq!(
        (&stats["image"]["width"], &stats["image"]["height"], &stats["image"]["spp"]),
        (&32.into(), &16.into(), &1.into())
    );
    for key in
        ["load", "build", "primary", "demand", "fill_direct", "fill_indirect", "shade", "render", "output", "total"]
    {
        assert!(stats["seconds"][key].is_number(), "{key}");
    }
    assert!(stats["seconds"]["denoise"] == 0.0 && stats["denoiser"].is_null());
    for key in ["primary", "shadow", "gather", "secondary"] {
        assert!(stats["rays"][key].is_u64(), "{key}");
    }
    for key in ["direct", "indirect"] {
        assert!(stats["fallbacks"][key].is_u64(), "{key}");
    }
    assert!(stats["energy_left_out"].is_number() || stats["energy_left_out"].is_null());
    for mesh in ["direct", "indirect"] {
        for key in ["spacing_m", "points_used", "points_total", "points_invalid", "bytes"] {
            assert!(stats["mesh"][mesh][key].is_number(), "{mesh} {key}");
        }
    }
    assert!(stats["estimated_error"].is_number());
    assert!(stats["peak_memory_bytes"].is_u64());
}

#[test]
fn without_size_the_height_follows_the_cameras_aspect() {
    let place = Place::new();
    place.run("render scene.gltf -o a.exr --quiet --stats a.json --spp 1").exits(0);
    let stats: Value = serde_json::from_str(&std::fs::read_to_string(place.path("a.json")).unwrap()).unwrap();
    assert_eq!(stats["image"]["width"], 1280);
    // The stand-in for "any aspect" is 1.5; the file's camera says 2.
    assert_eq!(stats["image"]["height"], 640);
}

#[test]
fn quiet_says_nothing_and_equal_runs_are_equal_files() {
    let place = Place::new();
    for name in ["a", "b"] {
        let run = place.run(&format!("render scene.gltf -o {name}.png --size 24x24 --quiet")).exits(0);
        assert_eq!((run.stdout(), run.stderr()), (String::new(), String::new()));
    }
    assert_eq!(std::fs::read(place.path("a.png")).unwrap(), std::fs::read(place.path("b.png")).unwrap());
}

#[test]
fn a_scene_without_light_is_lit_from_the_camera_with_a_warning() {
    let place = Place::new();
    place.write_unlit("dark.gltf");
    let run = place.run("render dark.gltf -o a.png --size 8x8").exits(0);
    assert!(run.stderr().contains("warning: ") && run.stderr().contains("no lights"), "{}", run.stderr());
    let quiet = place.run("render dark.gltf -o a.png --size 8x8 --quiet").exits(0);
    assert_eq!(quiet.stderr(), "");
}

/// One part in ten thousand is more than the noise of any plan allows: the picture comes, with what is wrong with it.
#[test]
fn an_error_that_is_not_kept_is_said_and_strict_exits_with_3() {
    let place = Place::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell.glb");
    let line = format!("render {scene} -o a.exr --size 32x24 --spp 1 --error 0.0001 --stats a.json");
    let said = place.run(&line).exits(0).stderr();
    for part in ["more than the 0.01% asked for", "most of the error is in the", "--method path --spp"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let strict = place.run(&(line + " --quiet --strict")).exits(3).stderr();
    assert!(strict.starts_with("error: the picture's error is about") && strict.lines().count() == 1, "{strict}");
    assert!(place.path("a.exr").exists());
    let stats: Value = serde_json::from_str(&std::fs::read_to_string(place.path("a.json")).unwrap()).unwrap();
    assert!(stats["error_estimate"]["path_spp"].as_u64() > Some(1000), "{stats}");
    place.run("render scene.gltf -o b.exr --size 8x8 --error 0.5 --strict").exits(0);
}

#[test]
fn what_bounces_leave_out_is_said_where_the_mesh_knows_it() {
    let place = Place::new();
    let said = |line: &str| place.run(line).exits(0).stderr().contains("% of the light");
    assert!(said("render scene.gltf -o a.png --size 8x8 --bounces 1"));
    assert!(said("render scene.gltf -o a.png --size 8x8"));
    assert!(!said("render scene.gltf -o a.png --size 8x8 --bounces 0"));
    assert!(!said("render scene.gltf -o a.png --size 8x8 --method standard"));
}

#[test]
fn usage_errors_are_one_line_and_exit_2() {
    let place = Place::new();
    for (args, word) in [
        ("--method magic", "magic"),
        ("--size 0x10", "--size"),
        ("--size -1x4", "--size"),
        ("--spacing -1", "--spacing"),
        ("--spacing 1/0", "--spacing"),
        ("--spp 0", "--spp"),
        ("--interpolation cubic", "cubic"),
        ("--interpolation trilinear:two", "trilinear:mirror"),
        ("--interpolation trilinear:zero --method hybrid", "interpolation"),
        ("--weight heavy", "heavy"),
        ("--weight cosine", "sphere"),
        ("--falloff r3", "r3"),
        ("--cutoff 1", "--cutoff"),
        ("--max-memory lots", "lots"),
        ("--threads 0", "--threads"),
        ("--exposure bright", "bright"),
        ("--units feet", "feet"),
        ("--rays 0", "--rays"),
        ("--error 0", "error"),
        ("--error 0.05 --method path", "error"),
        ("--refine 9", "--refine"),
        ("--lod-distance 0", "--lod-distance"),
        ("--lod-distance near", "--lod-distance"),
        ("--graded 2 --method path", "lod-distance"),
        ("--camera nobody", "nobody"),
        ("-o a.jpg", "a.jpg"),
        ("-o no/a.png", "no/a.png"),
        ("-o .", "."),
        ("-o b.exr", "twice"),
        ("--stats no/s.json", "s.json"),
    ] {
        place.run(&format!("render scene.gltf -o b.exr {args}")).exits(2).says(&[word]);
        assert_eq!(place.files(), ["scene.gltf"], "{args}");
    }
    place.run("render scene.gltf").exits(2).says(&["--output"]);
    place.run("render").exits(2).says(&["<SCENE>"]);
    place.run("paint scene.gltf").exits(2).says(&["paint"]);
}

#[test]
fn what_no_memory_holds_is_refused_at_once() {
    let place = Place::new();
    place.run("render scene.gltf -o a.exr --size 4000000x4000000").exits(2).says(&["memory", "--size"]);
    place.run("render scene.gltf -o a.exr --size 2000x2000 --max-memory 1MiB").exits(2).says(&["memory", "1.0 MiB"]);
    assert_eq!(place.files(), ["scene.gltf"]);
}

#[test]
fn files_that_are_no_scene_are_named() {
    let place = Place::new();
    place.write("empty.glb", "");
    place.run("render missing.glb -o a.exr").exits(2).says(&["missing.glb"]);
    place.run("render empty.glb -o a.exr").exits(2).says(&["empty.glb"]);
    place.run("info missing.glb").exits(2).says(&["missing.glb"]);
    assert_eq!(place.files(), ["empty.glb", "scene.gltf"]);
}

#[test]
fn an_older_picture_outlives_a_failure() {
    let place = Place::new();
    place.write("a.png", "yesterday's");
    place.run("render missing.glb -o a.png").exits(2);
    assert_eq!(std::fs::read_to_string(place.path("a.png")).unwrap(), "yesterday's");
}

#[test]
fn info_counts_what_the_file_holds() {
    let place = Place::new();
    let run = place.run("info scene.gltf").exits(0);
    for part in ["triangles  1 ", "1 point", "\"front\", perspective, 40.1 degrees high", "box "] {
        assert!(run.stdout().contains(part), "{part:?} in\n{}", run.stdout());
    }
    let json: Value = serde_json::from_str(&place.run("info scene.gltf --json").exits(0).stdout()).unwrap();
    assert_eq!(json["triangles"]["instanced"], 1);
    assert_eq!(json["cameras"][0]["name"], "front");
    assert_eq!(json["box"]["max"], serde_json::json!([1.0, 1.0, 0.0]));
}

#[test]
fn help_and_version_are_on_stdout() {
    let place = Place::new();
    let help = place.run("render --help").exits(0).stdout();
    for part in ["Light mesh:", "--spacing <METRES|1/K|auto>", "[default: auto]", "Examples:", "half of the machine's"]
    {
        assert!(help.contains(part), "{part:?} in\n{help}");
    }
    assert!(place.run("--version").exits(0).stdout().starts_with("lightmesh 0."));
    let nothing = place.run("").exits(2);
    assert!(nothing.stderr().contains("Usage:") && nothing.stdout().is_empty());
}
