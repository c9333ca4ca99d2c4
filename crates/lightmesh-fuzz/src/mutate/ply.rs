//! PLY: its header by words; its body by words where it is text, else by numbers.

use fastrand::Rng;

use super::{LONGEST, bytes, few_times, text};

const END: &[u8] = b"end_header\n";
const WORDS: [&str; 34] = [
    "ply",
    "format",
    "ascii",
    "binary_little_endian",
    "binary_big_endian",
    "1.0",
    "element",
    "vertex",
    "face",
    "property",
    "list",
    "char",
    "uchar",
    "short",
    "ushort",
    "int",
    "uint",
    "float",
    "double",
    "int8",
    "uint8",
    "float32",
    "float64",
    "x",
    "y",
    "z",
    "nx",
    "red",
    "s",
    "u",
    "vertex_indices",
    "vertex_index",
    "comment",
    "obj_info",
];

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let end = input.windows(END.len()).position(|window| window == END).map_or(input.len(), |at| at + END.len());
    let (mut header, mut body) = (input[..end].to_vec(), input[end..].to_vec());
    let is_text = header.windows(5).any(|window| window == b"ascii");
    few_times(rng, |rng| match (rng.u8(0..3), is_text) {
        (0, _) => text::change(&mut header, &WORDS, rng),
        (_, true) => text::change(&mut body, &["0", "3", "nan"], rng),
        (_, false) => bytes::change(&mut body, rng),
    });
    header.append(&mut body);
    header.truncate(LONGEST);
    header
}
