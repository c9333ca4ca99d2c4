//! PLY files: text and both orders of bytes.

use super::Seed;

const PROPERTIES: &str = "property float x\nproperty double y\nproperty float32 z\nproperty float nx\nproperty float ny\n\
    property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n";
const FACES: &str = "property list uchar int vertex_indices\nproperty short flags\n";
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

pub(crate) fn seeds() -> Vec<Seed> {
    let plain = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 .5\n3 0 1 2\n";
    vec![
        Seed::new("plain.ply", plain),
        Seed::new("text.ply", text()),
        Seed::new("little.ply", binary(false)),
        Seed::new("big.ply", binary(true)),
    ]
}

fn header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment ours\nelement vertex 4\n{PROPERTIES}element face 2\n{FACES}\
         element camera 1\nproperty list ushort uint8 bytes\nend_header\n"
    )
}

fn text() -> String {
    let mut text = header("ascii");
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z} 0 .0 2. 255 188 0 {x} {y}\n");
    }
    text + "4 0 1 2 3 -3\n3 0 1 2 7\n2 9 9\n"
}

fn binary(is_big: bool) -> Vec<u8> {
    let mut out = header(if is_big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
    let mut put = |bytes: &[u8]| match is_big {
        true => out.extend(bytes.iter().rev()),
        false => out.extend(bytes),
    };
    for [x, y, z] in CORNERS {
        put(&x.to_le_bytes());
        put(&f64::from(y).to_le_bytes());
        [z, 0.0, 0.0, 2.0].iter().for_each(|value| put(&value.to_le_bytes()));
        [255, 188, 0].iter().for_each(|byte| put(&[*byte]));
        [x, y].iter().for_each(|value| put(&value.to_le_bytes()));
    }
    for face in [&[0_i32, 1, 2, 3][..], &[0, 1, 2]] {
        put(&[face.len() as u8]);
        face.iter().for_each(|index| put(&index.to_le_bytes()));
        put(&(-3_i16).to_le_bytes());
    }
    put(&2_u16.to_le_bytes());
    put(&[9]);
    put(&[9]);
    out
}
