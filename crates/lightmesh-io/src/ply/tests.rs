use glam::{Vec2, Vec4};
use proptest::prelude::*;

use super::*;

const LIMIT: u64 = 1 << 20;

/// A square and a triangle with every attribute; `head` is the format.
fn header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 5\nproperty float x\nproperty double y\n\
         property float32 z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\nproperty uchar alpha\nproperty float s\nproperty float t\n\
         element face 2\nproperty list uchar int vertex_indices\nproperty short flags\n\
         element camera 1\nproperty list ushort uint8 bytes\nend_header\n"
    )
}

/// x, y, z; the normal is (0, 0, 2), the colour 255, 188, 0, 7 and s, t are x / 4, y / 4.
const VERTICES: [[f32; 3]; 5] = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [2.0, 0.5, 1.0]];
const FACES: [&[i32]; 2] = [&[0, 1, 2, 3], &[1, 4, 2]];

fn text() -> Vec<u8> {
    let mut out = header("ascii");
    for [x, y, z] in VERTICES {
        out += &format!("{x} {y} {z} 0 .0 2. 255 188 0 7 {} {}\r\n", x / 4.0, y / 4.0);
    }
    for face in FACES {
        out += &format!("{} {} -3\n", face.len(), face.iter().map(i32::to_string).collect::<Vec<_>>().join(" "));
    }
    out += "2 9 9";
    out.into_bytes()
}

fn binary(big_endian: bool) -> Vec<u8> {
    fn put<const N: usize>(out: &mut Vec<u8>, mut little: [u8; N], big_endian: bool) {
        if big_endian {
            little.reverse();
        }
        out.extend(little);
    }
    let mut out = header(if big_endian { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
    for [x, y, z] in VERTICES {
        put(&mut out, x.to_le_bytes(), big_endian);
        put(&mut out, f64::from(y).to_le_bytes(), big_endian);
        for value in [z, 0.0, 0.0, 2.0] {
            put(&mut out, value.to_le_bytes(), big_endian);
        }
        out.extend([255, 188, 0, 7]);
        for value in [x / 4.0, y / 4.0] {
            put(&mut out, value.to_le_bytes(), big_endian);
        }
    }
    for face in FACES {
        out.push(face.len() as u8);
        face.iter().for_each(|index| put(&mut out, index.to_le_bytes(), big_endian));
        put(&mut out, (-3_i16).to_le_bytes(), big_endian);
    }
    put(&mut out, 2_u16.to_le_bytes(), big_endian);
    out.extend([9, 9]);
    out
}

fn load(bytes: &[u8]) -> Result<Loaded, Error> {
    read("test.ply", bytes, None, &LoadOptions::default(), Budget::new(LIMIT))
}

#[test]
fn text_and_both_byte_orders_say_the_same() {
    for bytes in [text(), binary(false), binary(true)] {
        let loaded = load(&bytes).unwrap();
        let mesh = &loaded.data.meshes[0];
        assert_eq!(mesh.positions, VERTICES.map(Vec3::from));
        assert_eq!(mesh.normals, [Vec3::Z; 5]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
        assert_eq!(mesh.uvs[0][3], Vec2::new(0.0, 0.75));
        // sRGB 188 is linear 0.5029.
        assert!((mesh.colors[2] - Vec4::new(1.0, 0.502_886, 0.0, 1.0)).abs().max_element() < 1e-5);
        assert_eq!(loaded.warnings, ["element \"camera\": elements of this name are not read"]);
        assert_eq!((loaded.data.instances.len(), loaded.data.materials[0].specular), (1, 0.0));
    }
}

/// Every error names the file and the place, on one line.
#[test]
fn bad_files_are_told_apart() {
    let vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let face = "element face 1\nproperty list uchar int vertex_index\n";
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let ply = |elements: &str, body: &str| format!("ply\nformat ascii 1.0\n{elements}end_header\n{body}");
    let cases = [
        ("nonsense".into(), "line 1"),
        ("solid cube\n".into(), "no PLY"),
        (ply(vertex, points), "point cloud of 3 vertices"),
        (ply(&format!("{vertex}{face}"), &format!("{points}3 0 1 3")), "face 0 at line 13: refers to vertex 3"),
        (ply(&format!("{vertex}{face}"), &format!("{points}3 0 1 -1")), "-1 is no index"),
        (ply(&format!("{vertex}{face}"), "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2"), "vertex 0"),
        (ply(&format!("{vertex}{face}"), "0 0 1e39\n1 0 0\n0 1 0\n3 0 1 2"), "vertex 0"),
        (ply(&format!("{vertex}{face}"), "0 0 x\n1 0 0\n0 1 0\n3 0 1 2"), "line 10: \"x\" is no number"),
        (ply(&format!("{vertex}{face}"), &format!("{points}3 0 1")), "cut off"),
        (ply(&format!("{vertex}{face}"), &format!("{points}4000000 0 1 2")), "cut off"),
        (ply(&format!("{face}{vertex}"), &format!("3 0 1 2\n{points}")), "before the vertices"),
        (ply(&vertex.replace("vertex 3", "vertex 99999999999999"), points), "announces 99999999999999 vertex"),
        (ply("element vertex 3\nproperty float x\n", "0 1 2"), "no x, y and z"),
        (ply("element vertex 3\nproperty list float int x\n", "0 1 2"), "line 4"),
        (ply(&format!("{vertex}{face}"), &format!("{points}2 0 1")), "nothing to render"),
        ("ply\nformat ascii 2.0\nend_header\n".into(), "format ascii 2.0"),
        ("ply\nend_header\n".into(), "no format"),
    ];
    for (file, says) in cases {
        let message = load(file.as_bytes()).unwrap_err().to_string();
        assert!(message.starts_with("test.ply: ") && message.contains(says), "{file:?}: {message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

/// Records without properties take no bytes, so that a header of 100 bytes can announce 2⁶⁴ of them.
#[test]
fn records_of_nothing_are_not_counted() {
    let file = text();
    let file =
        String::from_utf8(file).unwrap().replace("element vertex", "element void 18446744073709551615\nelement vertex");
    assert_eq!(load(file.as_bytes()).unwrap().data.meshes[0].triangles.len(), 3);
}

#[test]
fn memory_is_paid_before_it_is_taken() {
    let error = read("test.ply", &binary(false), None, &LoadOptions::default(), Budget::new(100)).unwrap_err();
    assert!(matches!(error, Error::OutOfMemory { .. }), "{error}");
}

proptest! {
    /// Damaged files give a scene within the limits or an error, never a panic.
    #[test]
    fn damage_never_panics(
        form in 0..3,
        cut in any::<prop::sample::Index>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        truncate in any::<bool>(),
    ) {
        let mut bytes = match form { 0 => text(), 1 => binary(false), _ => binary(true) };
        for (at, value) in edits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if truncate {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(loaded) = load(&bytes) {
            let mesh = &loaded.data.meshes[0];
            prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
            prop_assert!(mesh.positions.iter().all(|p| p.is_finite()));
        }
    }
}
