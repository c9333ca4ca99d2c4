use std::fs;

use glam::{Vec2, Vec3};
use lightmesh::{AlphaMode, Texels, Wrap};
use proptest::prelude::*;

use super::*;

const LIMIT: u64 = 1 << 22;

const HOUSE: &str = "\
# a square and a triangle
mtllib house.mtl
o wall
v 0 0 0
v 1 0 0 1.0
v 1 1 0
v 0 1 0 # upper left
vt 0 0
vt 1 0.25 0
vn 0 0 2
usemtl brick
f 1/1/1 2/2/1 3/2/1 4/1/1
l 1 2 3
g roof
usemtl glass
v 0.5 2 0
f -2// \\
  -3 -1
";

const LIBRARY: &str = "\
newmtl brick
Kd 0.5 0.25 0.125
Ks 1 1 1
illum 2
Ke 3 2 1
newmtl glass
illum 7
Ni 1.33
Tf 0.9 1 0.9
d 0.1
newmtl mirror
illum 3
Ks 0.9 0.8 0.7
newmtl coat
Kd 0.5
illum 5
newmtl veil
d 0.5
";

fn load(text: &str, folder: Option<&Path>) -> Result<Loaded, Error> {
    read("test.obj", text.as_bytes(), folder, &LoadOptions::default(), Budget::new(LIMIT))
}

/// A folder with the library and a picture of 2 × 1 texels, red and half-covered green.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("house.mtl"), LIBRARY).unwrap();
    let picture = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 51]).unwrap();
    fs::create_dir(folder.path().join("my maps")).unwrap();
    picture.save(folder.path().join("my maps/wood grain.png")).unwrap();
    folder
}

#[test]
fn groups_polygons_and_indices_from_the_end() {
    let folder = folder();
    let loaded = load(HOUSE, Some(folder.path())).unwrap();
    let data = &loaded.data;
    let names: Vec<&str> = data.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["wall", "roof"]);
    let [wall, roof] = &data.meshes[..] else { panic!() };
    assert_eq!(wall.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(wall.positions[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(wall.normals, [Vec3::Z; 4]);
    // OBJ's v points up, ours down.
    assert_eq!(wall.uvs[0], [Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.75), Vec2::new(1.0, 0.75), Vec2::new(0.0, 1.0)]);
    assert_eq!(roof.positions, [Vec3::new(0.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.5, 2.0, 0.0)]);
    assert!(roof.normals.is_empty() && roof.uvs[0].is_empty() && roof.colors.is_empty());
    assert_eq!(data.instances.len(), 2);
    assert_eq!(loaded.warnings, ["line 13: points and lines are not rendered"]);
}

#[test]
fn libraries_become_materials() {
    let folder = folder();
    let text = format!(
        "{HOUSE}usemtl mirror\nf 1 2 3\nusemtl coat\nf 1 2 3\nusemtl veil\nf 1 2 3\nusemtl nowhere\nf 1 2 3\nusemtl brick\nf 1 2 3\n"
    );
    let loaded = load(&text, Some(folder.path())).unwrap();
    let [brick, glass, mirror, coat, veil, nowhere] = &loaded.data.materials[..] else { panic!() };
    assert_eq!((brick.base_color, brick.specular), (Vec3::new(0.5, 0.25, 0.125), 0.0));
    assert_eq!((brick.emission, brick.alpha_mode), (Vec3::new(3.0, 2.0, 1.0), AlphaMode::Opaque));
    assert_eq!((glass.transmission, glass.ior, glass.alpha, glass.roughness), (1.0, 1.33, 1.0, 0.0));
    assert_eq!(glass.base_color, Vec3::new(0.9, 1.0, 0.9));
    assert_eq!((mirror.metallic, mirror.roughness, mirror.base_color), (1.0, 0.0, Vec3::new(0.9, 0.8, 0.7)));
    assert_eq!((coat.base_color, coat.specular, coat.roughness, coat.ior), (Vec3::splat(0.5), 1.0, 0.0, 1.5));
    assert_eq!((veil.alpha, veil.alpha_mode, veil.base_color), (0.5, AlphaMode::Blend, Vec3::splat(0.8)));
    assert_eq!((nowhere.base_color, nowhere.specular), (Vec3::splat(0.8), 0.0));
    assert!(loaded.warnings.iter().any(|w| w.contains("\"nowhere\": no material library")), "{:?}", loaded.warnings);
    // The roof's brick is a mesh of its own: group and material both count.
    assert_eq!(loaded.data.meshes.len(), 7);
    assert_eq!(loaded.data.meshes[6].material, 0);
}

#[test]
fn a_line_names_several_libraries_in_quotes_or_not() {
    let folder = tempfile::tempdir().unwrap();
    for (name, red) in [("my wood.mtl", 0.1), ("tin.mtl", 0.2), ("old.lib", 0.3)] {
        let material = name.split(['.', ' ']).next().unwrap();
        fs::write(folder.path().join(name), format!("newmtl {material}\nKd {red} 0 0\n")).unwrap();
    }
    let red = |line: &str, material: &str| {
        let text = format!("mtllib {line}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {material}\nf 1 2 3");
        let loaded = load(&text, Some(folder.path())).unwrap();
        assert!(loaded.warnings.is_empty(), "{line}: {:?}", loaded.warnings);
        let files = loaded.files.iter().filter(|file| file.exists()).count();
        (loaded.data.materials[0].base_color.x, files)
    };
    assert_eq!(red("my wood.mtl", "my"), (0.1, 1));
    assert_eq!(red("tin.mtl", "tin"), (0.2, 1));
    assert_eq!(red("\"my wood.mtl\" tin.mtl", "my"), (0.1, 2));
    assert_eq!(red("tin.mtl \"my wood.mtl\" old.lib", "old"), (0.3, 3));
    assert_eq!(red("\"tin.mtl\"\"my wood.mtl\"", "my"), (0.1, 2));
    assert_eq!(red("\"old.lib", "old"), (0.3, 1));
}

#[test]
fn maps_are_read_beside_the_scene() {
    let folder = folder();
    let library = "newmtl wood\nKd 0 0 0\nmap_Kd -clamp on -s 2 4 -o 0.5 0.25 my maps\\wood grain.png\n\
                   map_d my maps/wood grain.png\nnorm -bm 0.5 my maps/wood grain.png\nbump heights.png\n";
    fs::write(folder.path().join("wood.mtl"), library).unwrap();
    let loaded = load("mtllib wood.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl wood\nf 1 2 3", Some(folder.path())).unwrap();
    let data = &loaded.data;
    let material = &data.materials[0];
    assert_eq!((material.base_color, material.alpha_mode, material.normal_scale), (Vec3::ONE, AlphaMode::Blend, 0.5));
    let color = material.base_color_texture.unwrap();
    let texture = data.textures[color.texture];
    assert_eq!((texture.wrap_s, texture.wrap_t), (Wrap::ClampToEdge, Wrap::ClampToEdge));
    let Texels::Rgba8(texels) = &data.images[texture.image].texels else { panic!() };
    assert_eq!(**texels, [[255, 0, 0, 255], [0, 255, 0, 51]]);
    // (0.1, 0.2) from the lower left: · (2, 4) + (0.5, 0.25) = (0.7, 1.05), which is −0.05 from the top.
    let moved = color.transform.apply(Vec2::new(0.1, 1.0 - 0.2));
    assert!((moved - Vec2::new(0.7, 1.0 - 1.05)).abs().max_element() < 1e-6, "{moved}");
    // The normal map is another image, without the alpha.
    let normal = data.textures[material.normal_texture.unwrap().texture];
    assert_ne!(normal.image, texture.image);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
}

#[test]
fn what_is_missing_or_outside_is_left_out_with_a_warning() {
    let folder = folder();
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).unwrap();
    fs::write(folder.path().join("secret.mtl"), "newmtl a\nKd 0.1 0.1 0.1\n").unwrap();
    let text = |library: &str| format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3");
    let absolute = folder.path().join("secret.mtl").display().to_string();
    for (library, says) in
        [("none.mtl", "cannot be read"), ("../secret.mtl", "leaves the scene's folder"), (&absolute, "leaves")]
    {
        let loaded = load(&text(library), Some(&inner)).unwrap();
        assert!(loaded.warnings[0].contains(says), "{library}: {:?}", loaded.warnings);
        assert_eq!(loaded.data.materials[0].base_color, Vec3::splat(0.8));
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../secret.mtl", inner.join("link.mtl")).unwrap();
        let loaded = load(&text("link.mtl"), Some(&inner)).unwrap();
        assert!(loaded.warnings[0].contains("leaves"), "{:?}", loaded.warnings);
    }
    let options = LoadOptions { allow_outside: true, ..LoadOptions::default() };
    let loaded =
        read("test.obj", text("../secret.mtl").as_bytes(), Some(&inner), &options, Budget::new(LIMIT)).unwrap();
    assert_eq!(loaded.data.materials[0].base_color, Vec3::splat(0.1));
    assert!(loaded.warnings.is_empty());
}

#[test]
fn corners_without_normals_among_others_take_their_faces() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 1 0 0\nvn 0 0 0\nvt 0.5 0.5\n\
                f 1//1 2//1 3//1\nf 1 3 4\nf 1/1/2 2/1/2 4/1/2\n";
    let loaded = load(text, None).unwrap();
    let mesh = &loaded.data.meshes[0];
    let of = |triangle: usize| mesh.triangles[triangle].map(|i| mesh.normals[i as usize]);
    assert_eq!(of(0), [Vec3::X; 3]);
    assert_eq!(of(1), [Vec3::X; 3]);
    assert_eq!(of(2), [Vec3::NEG_Y; 3]);
    assert_eq!(mesh.uvs[0].len(), mesh.positions.len());
    assert_eq!(mesh.normals.len(), mesh.positions.len());
}

/// The shape is good where only the attributes of some corners are miscounted.
#[test]
fn attributes_that_are_not_there_are_mended() {
    let loaded = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1 1\nf 1/1/1 2/2/-1 3/-2\n", None).unwrap();
    let mesh = &loaded.data.meshes[0];
    assert_eq!(mesh.uvs[0], [Vec2::new(1.0, 0.0), Vec2::ZERO, Vec2::ZERO]);
    assert!(mesh.normals.is_empty());
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
    assert!(loaded.warnings.iter().all(|w| w.ends_with("(2 times in the file)")), "{:?}", loaded.warnings);
}

#[test]
fn vertex_colours_are_srgb_and_white_where_missing() {
    let text = "v 0 0 0\nv 1 0 0 1 0 0.7372549\nv 0 1 0\nf 1 2 3\n";
    let mesh = &load(text, None).unwrap().data.meshes[0];
    assert_eq!(mesh.colors[0].to_array(), [1.0; 4]);
    assert!((mesh.colors[1].z - 0.502_886).abs() < 1e-5);
    assert_eq!(mesh.colors[2].to_array(), [1.0; 4]);
}

/// Every error names the file and the line.
#[test]
fn bad_files_are_told_apart() {
    let cases = [
        ("", "nothing to render: the file has no vertices"),
        ("v 0 0 0\nv 1 0 0\nl 1 2", "2 vertices but no face"),
        ("v 0 0\n", "line 1: a vertex needs three numbers"),
        ("v 0 0 a\n", "line 1: \"a\" is no number"),
        ("v 0 0 NaN\n", "line 1: NaN is not a finite"),
        ("v 0 0 1e39\n", "line 1"),
        ("vn 0 inf 1\n", "line 1"),
        ("vt\n", "line 1"),
        ("v 0 0 0\nf 1 2 3\n", "line 2: refers to vertex 2, but there are 1 so far"),
        ("v 0 0 0\nf 1 1 0\n", "refers to vertex 0"),
        ("v 0 0 0\nf 1 1 -2\n", "refers to vertex -2"),
        ("v 0 0 0\nf 1 1 -9223372036854775808\n", "refers to vertex"),
        ("v 0 0 0\nf x 1 1\n", "\"x\" is no index"),
        ("v 0 0 0\nf / 1 1\n", "no corner"),
    ];
    for (text, says) in cases {
        let message = load(text, None).unwrap_err().to_string();
        assert!(message.starts_with("test.obj: ") && message.contains(says), "{text:?}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
    let error = read("test.obj", HOUSE.as_bytes(), None, &LoadOptions::default(), Budget::new(100)).unwrap_err();
    assert!(matches!(error, Error::OutOfMemory { .. }), "{error}");
}

proptest! {
    /// Damaged files give a scene within the limits or an error, never a panic.
    #[test]
    fn damage_never_panics(
        cut in any::<prop::sample::Index>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..5),
    ) {
        let mut bytes = HOUSE.as_bytes().to_vec();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate(bytes.len() - cut.index(bytes.len()) / 2);
        let loaded = read("test.obj", &bytes, None, &LoadOptions::default(), Budget::new(LIMIT));
        for mesh in loaded.iter().flat_map(|loaded| &loaded.data.meshes) {
            prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
            prop_assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
            prop_assert!(mesh.uvs[0].is_empty() || mesh.uvs[0].len() == mesh.positions.len());
        }
    }

    /// So do damaged material libraries.
    #[test]
    fn damaged_libraries_never_panic(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..5),
        words in "(Kd|map_Kd|d|illum|norm|Tf|newmtl)( -?[a-z0-9.]{0,4}){0,5}",
    ) {
        let mut bytes = format!("{LIBRARY}{words}").into_bytes();
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        for material in mtl::parse(&bytes, |_, _| {}) {
            let colors = [material.diffuse, material.specular, material.emission, material.filter];
            prop_assert!(colors.iter().flatten().all(|c| c.is_finite() && c.min_element() >= 0.0));
        }
    }
}
