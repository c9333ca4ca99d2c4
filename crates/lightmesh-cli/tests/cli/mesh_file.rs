//! `--mesh` and `--save-mesh` from the outside.

use std::fs;

use crate::place::Place;

/// Whether the render of this line shot rays to fill its mesh, and the bytes of its PNG.
fn render(place: &Place, line: &str) -> (u64, Vec<u8>) {
    place.run(&format!("{line} -o a.png --stats a.json --quiet")).exits(0);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(place.path("a.json")).unwrap()).unwrap();
    (stats["rays"]["gather"].as_u64().unwrap(), fs::read(place.path("a.png")).unwrap())
}

#[test]
fn a_mesh_goes_on_where_it_was_and_the_picture_is_the_same() {
    let place = Place::new();
    for method in ["mesh", "paper", "hybrid"] {
        let line = format!("render scene.gltf --size 40x24 --method {method} --gather-rays 16");
        let (cold, picture) = render(&place, &format!("{line} --save-mesh a.safetensors"));
        let (warm, again) = render(&place, &format!("{line} --mesh a.safetensors --save-mesh b.safetensors"));
        assert!(cold > 0 && warm == 0, "{method}: {cold} {warm}");
        assert!(picture == again, "{method}");
        // Fewer bounces are in it too; other cameras and samples only read.
        let fewer = format!("{line} --bounces 1");
        let (_, alone) = render(&place, &fewer);
        let (warm, again) = render(&place, &format!("{fewer} --mesh a.safetensors"));
        assert!(warm == 0 && again == alone, "{method}");
        assert_eq!(place.files(), ["a.json", "a.png", "a.safetensors", "b.safetensors", "scene.gltf"]);
    }
}

#[test]
fn a_mesh_of_another_scene_or_of_other_settings_is_refused() {
    let place = Place::new();
    let line = "render scene.gltf --size 8x8 --quiet -o a.png";
    place.run(&format!("{line} --save-mesh a.mesh --bounces 1")).exits(0);
    let scene = fs::read_to_string(place.path("scene.gltf")).unwrap();
    place.write("other.gltf", &scene.replace("100.0", "101.0"));
    place.write("cut.mesh", "short");
    for (line, words) in [
        ("render other.gltf --bounces 1 --mesh a.mesh", &["a.mesh", "another scene"][..]),
        (
            "render scene.gltf --bounces 1 --mesh a.mesh --spacing 1/80",
            &["a.mesh", "made with spacing auto", "ask for 1/80"],
        ),
        ("render scene.gltf --bounces 2 --mesh a.mesh", &["a.mesh", "bounces 1, and the options ask for 2"]),
        ("render scene.gltf --mesh none.mesh", &["none.mesh", "No such file"]),
        ("render scene.gltf --mesh cut.mesh", &["cut.mesh", "5 bytes"]),
        ("render scene.gltf --mesh a.mesh --method path", &["--mesh", "path has no light mesh"]),
        ("render scene.gltf --save-mesh b.mesh --method standard", &["--save-mesh", "standard has no light mesh"]),
        ("render scene.gltf --save-mesh no/b.mesh", &["no/b.mesh", "does not exist"]),
        ("render scene.gltf --save-mesh b.png", &["b.png", "twice"]),
    ] {
        place.run(&format!("{line} -o b.png --size 8x8 --quiet")).exits(2).says(words);
        assert_eq!(place.files(), ["a.mesh", "a.png", "cut.mesh", "other.gltf", "scene.gltf"], "{line}");
    }
}
