//! Light from all sides, and lamps with a size, from the outside.

use glam::Vec3;
use serde_json::Value;

use crate::place::Place;

/// A folder with `plane.gltf`, the triangle with albedo 0.5 and no light, and `sky.gltf`, the same under a sky of
/// radiance (2, 0, 0) of its own.
fn place() -> Place {
    let place = Place::new();
    place.write_unlit("plane.gltf");
    let matte = r#""materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } } }],
        "meshes": [{ "primitives": [{ "material": 0, "#;
    let plane = std::fs::read_to_string(place.path("plane.gltf")).unwrap();
    let plane = plane.replace(r#""meshes": [{ "primitives": [{ "#, matte);
    assert!(plane.contains("specularFactor"));
    place.write("plane.gltf", &plane);

    // E_00 = π L / Y_00.
    let zero = ", [0, 0, 0]".repeat(8);
    let light = format!(r#"{{ "irradianceCoefficients": [[22.2733, 0, 0]{zero}] }}"#);
    let sky = plane.replace(
        r#""scene": 0"#,
        &format!(r#""extensions": {{ "EXT_lights_image_based": {{ "lights": [{light}] }} }}, "scene": 0"#),
    );
    let sky =
        sky.replace(r#""scenes": [{ "#, r#""scenes": [{ "extensions": { "EXT_lights_image_based": { "light": 0 } }, "#);
    place.write("sky.gltf", &sky);
    place
}

/// Renders with these arguments: the mean of the triangle's middle, and the background above it.
fn render(place: &Place, args: &str) -> (Vec3, Vec3) {
    place.run(&format!("render {args} -o a.exr --size 64x32 --quiet")).exits(0);
    let image = lightmesh_io::read_picture(&place.path("a.exr")).unwrap().image;
    let pixel = |x: usize, y: usize| image.pixels[y * 64 + x];
    let middle: Vec3 = (30..34).flat_map(|x| (14..18).map(move |y| pixel(x, y))).sum();
    (middle / 16.0, pixel(32, 0))
}

#[track_caller]
fn assert_near(got: Vec3, expected: Vec3, tolerance: f32) {
    assert!((got - expected).abs().max_element() <= tolerance * expected.max_element(), "{got} is not {expected}");
}

/// L = albedo · strength · colour on a surface that sees nothing but the sky; the sky itself behind it.
#[test]
fn a_constant_environment_lights_a_plane_and_is_seen() {
    let place = place();
    for method in ["mesh", "standard", "path"] {
        let (plane, sky) =
            render(&place, &format!("plane.gltf --method {method} --environment 10,20,5 --environment-strength 3"));
        assert_near(sky, Vec3::new(30.0, 60.0, 15.0), 1e-5);
        assert_near(plane, Vec3::new(15.0, 30.0, 7.5), 0.04);
    }
    let (_, sky) = render(&place, "plane.gltf --environment #ff00ff");
    assert_near(sky, Vec3::new(1.0, 0.0, 1.0), 1e-5);
    // Black is asked for, and not replaced by the soft one.
    let (plane, sky) = render(&place, "plane.gltf --environment 0,0,0");
    assert_eq!((plane, sky), (Vec3::ZERO, Vec3::ZERO));
}

/// A Radiance picture of four quarters: −Z red, +X green, +Z blue, −X white, each 2 bright. The camera looks along −Z.
#[test]
fn a_map_turns_counter_clockwise_seen_from_above() {
    let place = place();
    let (r, g, b, w) = ([128, 0, 0, 130], [0, 128, 0, 130], [0, 0, 128, 130], [128, 128, 128, 130]);
    let row: Vec<u8> = [w, r, r, g, g, b, b, w].concat();
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    std::fs::write(place.path("sky.hdr"), [header, row.repeat(4)].concat()).unwrap();
    for (degrees, seen) in [(0, Vec3::X), (90, Vec3::Y), (-90, Vec3::ONE), (180, Vec3::Z), (450, Vec3::Y)] {
        let (_, sky) = render(&place, &format!("plane.gltf --environment sky.hdr --environment-rotation {degrees}"));
        assert_near(sky, 2.0 * seen, 1e-4);
    }
    // The plane faces +Z, blue; to its sides it sees less of green and white.
    for method in ["mesh", "standard", "path"] {
        let (plane, _) = render(&place, &format!("plane.gltf --environment sky.hdr --method {method}"));
        assert!(plane.x < 0.5 * plane.z && plane.y < 0.5 * plane.z, "{method}: {plane}");
    }
}

#[test]
fn the_command_line_replaces_the_files_environment_and_scales_it() {
    let place = place();
    assert_near(render(&place, "sky.gltf").1, Vec3::new(2.0, 0.0, 0.0), 1e-4);
    assert_near(render(&place, "sky.gltf --environment-strength 4").1, Vec3::new(8.0, 0.0, 0.0), 1e-4);
    assert_near(render(&place, "sky.gltf --environment 0,1,0").1, Vec3::Y, 1e-5);
    let run = place.run("info sky.gltf").exits(0);
    assert!(run.stdout().contains("environment 64x32"), "{}", run.stdout());
}

#[test]
fn only_scenes_that_nothing_lights_get_the_soft_environment() {
    let place = place();
    let said = |line: &str, word: &str| {
        place.run(&format!("render {line} -o a.png --size 8x8")).exits(0).stderr().contains(word)
    };
    assert!(said("plane.gltf", "soft environment"));
    assert!(!said("plane.gltf --environment 1,1,1", "soft environment"));
    assert!(!said("sky.gltf", "soft environment"));
    assert!(said("scene.gltf --environment-strength 2", "--environment-strength"));
    assert!(!said("scene.gltf --environment 1,1,1 --environment-strength 2", "--environment-strength"));
}

/// A lamp that is wholly above the plane lights it like its centre: E = I cosθ / r², whatever its radius.
#[test]
fn a_lamp_with_a_radius_keeps_its_power() {
    let place = place();
    let (point, _) = render(&place, "scene.gltf --method standard --bounces 0");
    for method in ["mesh", "standard", "path"] {
        let (sphere, _) = render(&place, &format!("scene.gltf --method {method} --bounces 0 --light-radius 0.3"));
        assert_near(sphere, point, 0.03);
    }
}

#[test]
fn light_samples_are_counted_and_settings_kept() {
    let place = place();
    let samples = |args: &str| -> u64 {
        place.run(&format!("render {args} -o a.png --size 8x8 --quiet --stats a.json")).exits(0);
        let stats: Value = serde_json::from_str(&std::fs::read_to_string(place.path("a.json")).unwrap()).unwrap();
        stats["light_samples"].as_u64().unwrap()
    };
    assert_eq!(samples("scene.gltf"), 1);
    assert_eq!(samples("scene.gltf --light-radius 0.1"), 64);
    assert_eq!(samples("scene.gltf --environment 1,1,1 --light-samples 32"), 33);
    let png = std::fs::read(place.path("a.png")).unwrap();
    let kept = br#""environment":"1,1,1","#;
    assert!(png.windows(kept.len()).any(|w| w == kept), "settings in the picture");
}

#[test]
fn bad_values_are_one_line_and_exit_2() {
    let place = place();
    place.write("broken.hdr", "#?RADIANCE\n\n-Y 9 +X 9\n");
    let before = place.files();
    for (args, words) in [
        ("--environment sky.png", &["--environment", ".hdr or .exr"][..]),
        ("--environment 1,2", &["R,G,B"]),
        ("--environment -1,0,0", &["R,G,B"]),
        ("--environment gone.hdr", &["gone.hdr", "cannot be read"]),
        ("--environment broken.hdr", &["broken.hdr"]),
        ("--environment 1e30,0,0", &["plane.gltf", "environment", "radiance"]),
        ("--environment-strength -1", &["--environment-strength"]),
        ("--environment-strength nan", &["--environment-strength"]),
        ("--environment-rotation north", &["--environment-rotation", "must be a number"]),
        ("--light-samples 0", &["--light-samples"]),
        ("--light-samples 65537", &["--light-samples"]),
        ("--light-radius -0.1", &["--light-radius", "0 or more"]),
        ("--light-radius inf", &["--light-radius"]),
    ] {
        place.run(&format!("render plane.gltf -o a.exr {args}")).exits(2).says(words);
        assert_eq!(place.files(), before, "{args}");
    }
}
