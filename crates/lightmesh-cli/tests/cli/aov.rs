//! `--aov` from the outside.

use crate::place::Place;

#[test]
fn layers_are_written_beside_the_light() {
    let place = Place::new();
    place.run("render scene.gltf -o plain.exr --size 24x16 --quiet").exits(0);
    let all = "albedo,normal,depth,direct,indirect,mesh_level,mesh_valid,points";
    place.run(&format!("render scene.gltf -o a.exr -o a.png --size 24x16 --quiet --aov {all}")).exits(0);
    place.run("render scene.gltf -o b.exr --size 24x16 --quiet --method path --aov depth --aov albedo").exits(0);

    // Channels stand in the header by name, each ended by a zero byte and the number of its type.
    let holds = |file: &str, channel: &str| {
        let entry = [channel.as_bytes(), &[0, 2, 0, 0, 0]].concat();
        std::fs::read(place.path(file)).unwrap().windows(entry.len()).any(|bytes| bytes == entry)
    };
    for channel in ["R", "albedo.R", "normal.Z", "depth.Z", "direct.G", "indirect.B", "mesh_level.V", "mesh_valid.V"] {
        assert!(holds("a.exr", channel) && (channel == "R") == holds("plain.exr", channel), "{channel}");
    }
    assert!(holds("a.exr", "points.G"));
    assert!(holds("b.exr", "albedo.B") && holds("b.exr", "depth.Z") && !holds("b.exr", "normal.X"));

    // The light is the same, and the settings say which layers there are.
    let same = place.run("compare a.exr plain.exr").exits(0).stdout();
    assert!(same.contains("relrmse  0.000000"), "{same}");
    let text = String::from_utf8_lossy(&std::fs::read(place.path("b.exr")).unwrap()).into_owned();
    assert!(text.contains(r#""aov":"albedo,depth""#));
}

#[test]
fn layers_that_cannot_be_had_are_refused() {
    let place = Place::new();
    let refused = |line: &str, words: &[&str]| {
        place.run(&format!("render scene.gltf {line}")).exits(2).says(words);
        assert_eq!(place.files(), ["scene.gltf"], "{line}");
    };
    refused("-o a.exr --aov albedo,colour", &["'colour'", "--aov", "albedo", "mesh_valid", "points"]);
    refused("-o a.exr --aov albedo,,depth", &["--aov"]);
    refused("-o a.exr --aov", &["--aov"]);
    refused("-o a.png --aov depth", &["--aov", ".exr"]);
    refused("-o a.exr --aov points --method path", &["aov", "points", "standard and path"]);
    refused("-o a.exr --size 1000x1000 --max-memory 39MB --aov albedo", &["memory", "--aov"]);
}
