//! Accessors and primitives of glTF files built in memory.

use crate::common::{F32, Gltf, I8, I16, TRIANGLE, U8, U16, U32, assert_says, assert_warns};
use glam::{Vec2, Vec3, Vec4};
use lightmesh_io::LoadOptions;
use serde_json::json;

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

fn bytes<T: Copy, const N: usize>(values: &[T], to_bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&v| to_bytes(v)).collect()
}

#[test]
fn without_indices_every_three_vertices_are_a_triangle() {
    let loaded = Gltf::triangle().load().unwrap();
    assert_eq!(loaded.data.meshes.len(), 1);
    assert_eq!(loaded.data.meshes[0].positions, CORNERS);
    assert_eq!(loaded.data.meshes[0].triangles, [[0, 1, 2]]);
    assert!(loaded.data.meshes[0].normals.is_empty() && loaded.warnings.is_empty());
}

#[test]
fn indices_of_every_unsigned_type() {
    for (component, data) in
        [(U8, vec![2, 0, 1]), (U16, bytes(&[2, 0, 1], u16::to_le_bytes)), (U32, bytes(&[2, 0, 1], u32::to_le_bytes))]
    {
        let mut gltf = Gltf::triangle();
        let indices = gltf.accessor(component, "SCALAR", 3, &data);
        gltf.primitive()["indices"] = json!(indices);
        assert_eq!(gltf.load().unwrap().data.meshes[0].triangles, [[2, 0, 1]]);
    }
    for component in [I8, I16, F32] {
        let mut gltf = Gltf::triangle();
        let indices = gltf.accessor(component, "SCALAR", 3, &[0; 12]);
        gltf.primitive()["indices"] = json!(indices);
        assert_says(&gltf.refusal(), &["mesh 0, primitive 0", "unsigned"]);
    }
}

#[test]
fn an_index_beyond_the_vertices_is_named() {
    let mut gltf = Gltf::triangle();
    let indices = gltf.indices(&[0, 1, 77]);
    gltf.primitive()["indices"] = json!(indices);
    assert_says(&gltf.refusal(), &["index 77 is out of range: primitive has 3 vertices"]);
}

#[test]
fn strips_and_fans_keep_the_front_side() {
    // A unit square in the plane z = 0, counter-clockwise from +Z in both.
    for (mode, order) in [(5, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]), (6, [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0])]
    {
        let mut gltf = Gltf::new();
        let corners: Vec<f32> = order.chunks(2).flat_map(|p| [p[0], p[1], 0.0]).collect();
        let position = gltf.floats("VEC3", &corners);
        gltf.mesh(json!({"attributes": {"POSITION": position}, "mode": mode}));
        gltf.node(json!({"mesh": 0}));
        let loaded = gltf.load().unwrap();
        let mesh = &loaded.data.meshes[0];
        assert_eq!(mesh.triangles.len(), 2);
        let area: f32 = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                0.5 * (b - a).cross(c - a).z
            })
            .sum();
        assert_eq!(area, 1.0, "mode {mode}");
    }
}

#[test]
fn points_and_lines_are_skipped_with_a_warning() {
    for (mode, word) in [(0, "points"), (1, "lines"), (2, "lines"), (3, "lines")] {
        let mut gltf = Gltf::triangle();
        let points = json!({"attributes": {"POSITION": 0}, "mode": mode});
        gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap().insert(0, points);
        let loaded = gltf.load().unwrap();
        assert_eq!(loaded.data.meshes.len(), 1);
        assert_warns(&loaded, &["mesh 0, primitive 0", word]);
        gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap().pop();
        assert_says(&gltf.refusal(), &["nothing to render"]);
    }
    let mut gltf = Gltf::triangle();
    gltf.primitive()["mode"] = json!(7);
    assert_says(&gltf.refusal(), &["mode 7"]);
}

/// KHR_mesh_quantization and the normalisation formulas of glTF 2.0: f = c / 127, c / 255, c / 32767, c / 65535, not
/// under −1.
#[test]
fn positions_of_every_type() {
    let cases: [(u32, bool, Vec<u8>, f32); 9] = [
        (I8, false, bytes(&[-100_i8], i8::to_le_bytes), -100.0),
        (U8, false, vec![200], 200.0),
        (I16, false, bytes(&[-30_000_i16], i16::to_le_bytes), -30_000.0),
        (U16, false, bytes(&[60_000_u16], u16::to_le_bytes), 60_000.0),
        (I8, true, bytes(&[-128_i8], i8::to_le_bytes), -1.0),
        (U8, true, vec![51], 0.2),
        (I16, true, bytes(&[32_767_i16], i16::to_le_bytes), 1.0),
        (U16, true, bytes(&[13_107_u16], u16::to_le_bytes), 0.2),
        (F32, false, bytes(&[0.3_f32], f32::to_le_bytes), 0.3),
    ];
    for (component, normalized, x, expected) in cases {
        // The x of vertex 0 is the value; strides are padded to four bytes as the extension wants.
        let size = x.len();
        let stride = (3 * size).next_multiple_of(4);
        let mut data = vec![0; 3 * stride];
        data[..size].copy_from_slice(&x);
        let one = if component == F32 { 1.0_f32.to_le_bytes()[..].to_vec() } else { vec![1; size] };
        data[stride + size..stride + 2 * size].copy_from_slice(&one);
        data[2 * stride + 2 * size..2 * stride + 3 * size].copy_from_slice(&one);
        let mut gltf = Gltf::triangle();
        gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let accessor = gltf.accessor(component, "VEC3", 3, &data);
        gltf.json["accessors"][accessor]["normalized"] = json!(normalized);
        gltf.json["bufferViews"][accessor]["byteStride"] = json!(stride);
        gltf.primitive()["attributes"]["POSITION"] = json!(accessor);
        let loaded = gltf.load().unwrap();
        assert_eq!(loaded.data.meshes[0].positions[0], Vec3::new(expected, 0.0, 0.0), "{component} {normalized}");
    }
}

#[test]
fn interleaved_attributes_use_stride_and_offset() {
    let mut gltf = Gltf::new();
    let mut data = Vec::new();
    for corner in CORNERS {
        data.extend(bytes(&corner.to_array(), f32::to_le_bytes));
        data.extend(bytes(&[0.0_f32, 0.0, 2.0], f32::to_le_bytes));
    }
    let view = gltf.view(&data);
    gltf.json["bufferViews"][view]["byteStride"] = json!(24);
    for offset in [0, 12] {
        let accessor =
            json!({"bufferView": view, "byteOffset": offset, "componentType": F32, "type": "VEC3", "count": 3});
        gltf.push("accessors", accessor);
    }
    gltf.mesh(json!({"attributes": {"POSITION": 0, "NORMAL": 1}}));
    gltf.node(json!({"mesh": 0}));
    let loaded = gltf.load().unwrap();
    assert_eq!(loaded.data.meshes[0].positions, CORNERS);
    assert_eq!(loaded.data.meshes[0].normals, [Vec3::Z; 3], "normalised");
    // One byte less and the last normal is cut off.
    gltf.json["bufferViews"][view]["byteLength"] = json!(data.len() - 1);
    assert_says(&gltf.refusal(), &["accessor 1", "bufferView 0"]);
}

#[test]
fn sparse_accessors_replace_elements() {
    let mut gltf = Gltf::triangle();
    let indices = gltf.view(&[0, 2]);
    let values = gltf.view(&bytes(&[0.0_f32, 0.0, 5.0, 0.0, 7.0, 0.0], f32::to_le_bytes));
    let sparse = json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": U8},
        "values": {"bufferView": values},
    });
    gltf.json["accessors"][0]["sparse"] = sparse;
    let expected = [Vec3::new(0.0, 0.0, 5.0), Vec3::X, Vec3::new(0.0, 7.0, 0.0)];
    assert_eq!(gltf.load().unwrap().data.meshes[0].positions, expected);

    // Without a buffer view the rest is zero.
    gltf.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let expected = [Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, Vec3::new(0.0, 7.0, 0.0)];
    assert_eq!(gltf.load().unwrap().data.meshes[0].positions, expected);

    // Indices must increase and stay in range.
    for broken in [[2, 2], [2, 0], [0, 3]] {
        let mut gltf = gltf.clone();
        let view = gltf.view(&broken);
        gltf.json["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(view);
        assert_says(&gltf.refusal(), &["accessor 0", "sparse"]);
    }
}

#[test]
fn counts_are_checked_before_allocation() {
    let mut gltf = Gltf::triangle();
    for count in [4_u64, 4_000_000_000, u64::from(u32::MAX) + 1, u64::MAX] {
        gltf.json["accessors"][0]["count"] = json!(count);
        assert_says(&gltf.refusal(), &["accessor 0"]);
    }
    // Zeros need no bytes in the file, but they do in memory.
    gltf.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    gltf.json["accessors"][0]["count"] = json!(4_000_000_000_u64);
    assert_says(&gltf.refusal(), &["mesh 0, primitive 0", "limit of 4.0 GiB"]);
    // Offsets that overflow.
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0]["byteOffset"] = json!(u64::MAX);
    assert_says(&gltf.refusal(), &["accessor 0"]);
    let mut gltf = Gltf::triangle();
    gltf.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX);
    assert_says(&gltf.refusal(), &["bufferView 0"]);
}

#[test]
fn one_array_read_many_times_meets_the_limit() {
    let mut gltf = Gltf::new();
    let position = gltf.floats("VEC3", &TRIANGLE.repeat(1_000));
    let primitive = json!({"attributes": {"POSITION": position}});
    gltf.push("meshes", json!({"primitives": vec![primitive; 50]}));
    gltf.node(json!({"mesh": 0}));
    assert_eq!(gltf.load().unwrap().data.meshes.len(), 50);
    let options = LoadOptions { max_memory: 1_000_000, ..LoadOptions::default() };
    let message = gltf.load_with(&options).unwrap_err().to_string();
    assert_says(&message, &["mesh 0, primitive", "limit of 976.6 KiB", "--max-memory"]);
}

#[test]
fn primitives_that_share_a_large_vertex_array_take_only_their_vertices() {
    let mut gltf = Gltf::new();
    let positions: Vec<f32> = (0..300).flat_map(|i| [i as f32, (i % 7) as f32, (i % 3) as f32]).collect();
    let position = gltf.floats("VEC3", &positions);
    for first in [0_u16, 90, 250] {
        let indices = gltf.indices(&[first + 2, first, first + 1, first + 2, first + 1, first + 3]);
        let mesh = gltf.mesh(json!({"attributes": {"POSITION": position}, "indices": indices}));
        gltf.node(json!({"mesh": mesh}));
    }
    let loaded = gltf.load().unwrap();
    for (mesh, first) in loaded.data.meshes.iter().zip([0, 90, 250]) {
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.triangles, [[2, 0, 1], [2, 1, 3]]);
        assert_eq!(mesh.positions[3].x, (first + 3) as f32);
    }
}

#[test]
fn positions_must_be_finite() {
    for value in [f32::NAN, f32::INFINITY] {
        let mut gltf = Gltf::triangle();
        gltf.binary[16..20].copy_from_slice(&value.to_le_bytes());
        assert_says(&gltf.refusal(), &["mesh 0", "position of vertex 1"]);
    }
}

#[test]
fn attributes_must_match_the_vertices() {
    let mut gltf = Gltf::triangle();
    let normal = gltf.floats("VEC3", &[0.0; 12]);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normal);
    assert_says(&gltf.refusal(), &["accessor 1", "NORMAL", "4 elements for 3 vertices"]);
    let mut gltf = Gltf::triangle();
    let uv = gltf.floats("VEC3", &TRIANGLE);
    gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
    assert_says(&gltf.refusal(), &["accessor 1", "TEXCOORD_0"]);
    let mut gltf = Gltf::triangle();
    gltf.primitive()["attributes"]["NORMAL"] = json!(9);
    assert_says(&gltf.refusal(), &["accessor 9", "NORMAL"]);
}

#[test]
fn broken_normals_tangents_and_triangles_are_mended_with_a_warning() {
    let mut gltf = Gltf::triangle();
    let normal = gltf.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 1.0, 0.0, 0.0]);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normal);
    let loaded = gltf.load().unwrap();
    assert_eq!(loaded.data.meshes[0].normals, [Vec3::Z, Vec3::Z, Vec3::X]);
    assert_warns(&loaded, &["normal", "2 times"]);

    let mut gltf = Gltf::triangle();
    let tangent = gltf.floats("VEC4", &[2.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    gltf.primitive()["attributes"]["TANGENT"] = json!(tangent);
    let loaded = gltf.load().unwrap();
    assert!(loaded.data.meshes[0].tangents.is_empty());
    assert_warns(&loaded, &["tangent"]);
    gltf.binary.truncate(gltf.binary.len() - 16);
    gltf.binary.extend(bytes(&[0.0_f32, 3.0, 0.0, 1.0], f32::to_le_bytes));
    let expected = [Vec4::new(1.0, 0.0, 0.0, -1.0), Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 1.0)];
    assert_eq!(gltf.load().unwrap().data.meshes[0].tangents, expected);

    let mut gltf = Gltf::triangle();
    let indices = gltf.indices(&[0, 1, 2, 0, 1, 1]);
    gltf.primitive()["indices"] = json!(indices);
    assert_warns(&gltf.load().unwrap(), &["no area"]);
}

#[test]
fn colors_of_three_or_four_components_are_normalised_and_clamped() {
    let mut gltf = Gltf::triangle();
    let color = gltf.floats("VEC3", &[0.5, 2.0, -1.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0]);
    gltf.primitive()["attributes"]["COLOR_0"] = json!(color);
    let loaded = gltf.load().unwrap();
    assert_eq!(loaded.data.meshes[0].colors, [Vec4::new(0.5, 1.0, 0.0, 1.0), Vec4::W, Vec4::ONE]);
    assert_warns(&loaded, &["colour"]);

    // Bytes without `normalized`, as some exporters write them.
    let mut gltf = Gltf::triangle();
    let color = gltf.accessor(U8, "VEC4", 3, &[51, 0, 255, 102, 0, 0, 0, 0, 255, 255, 255, 255]);
    gltf.primitive()["attributes"]["COLOR_0"] = json!(color);
    let expected = [Vec4::new(0.2, 0.0, 1.0, 0.4), Vec4::ZERO, Vec4::ONE];
    assert_eq!(gltf.load().unwrap().data.meshes[0].colors, expected);
}

#[test]
fn both_texture_coordinate_sets() {
    let mut gltf = Gltf::triangle();
    let first = gltf.accessor(U16, "VEC2", 3, &bytes(&[0, 65_535, 13_107, 0, 0, 0], u16::to_le_bytes));
    gltf.json["accessors"][first]["normalized"] = json!(true);
    let second = gltf.floats("VEC2", &[0.0, 0.5, 1.5, -2.0, f32::INFINITY, 0.0]);
    gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(first);
    gltf.primitive()["attributes"]["TEXCOORD_1"] = json!(second);
    let loaded = gltf.load().unwrap();
    let [first, second] = &loaded.data.meshes[0].uvs;
    assert_eq!(*first, [Vec2::new(0.0, 1.0), Vec2::new(0.2, 0.0), Vec2::ZERO]);
    assert_eq!(*second, [Vec2::new(0.0, 0.5), Vec2::new(1.5, -2.0), Vec2::ZERO]);
    assert_warns(&loaded, &["texture coordinate"]);
}

#[test]
fn morph_targets_skins_and_animations_are_left_out_with_a_warning() {
    let mut gltf = Gltf::triangle();
    gltf.primitive()["targets"] = json!([{"POSITION": 0}]);
    assert_warns(&gltf.load().unwrap(), &["morph"]);
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["skin"] = json!(0);
    assert_warns(&gltf.load().unwrap(), &["node 0", "skin"]);
    let mut gltf = Gltf::triangle();
    gltf.json["animations"] = json!([{"channels": [], "samplers": []}]);
    assert_warns(&gltf.load().unwrap(), &["animation"]);
}
