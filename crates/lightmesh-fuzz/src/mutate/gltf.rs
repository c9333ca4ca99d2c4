//! glTF: its JSON as a tree, and its numbers in the binary chunk or in data URIs.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fastrand::Rng;
use serde_json::{Value, json};

use super::{LONGEST, bytes, few_times, json};

/// The beginning of a buffer's data in its URI.
const DATA: &str = "data:application/octet-stream;base64,";

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let (text, binary) = split(input);
    let document = serde_json::from_slice::<Value>(text);
    let Some(mut document) = document.ok().filter(|_| rng.u8(0..16) != 0) else {
        // The container, or a text that is no JSON any more.
        let mut input = input.to_vec();
        few_times(rng, |rng| bytes::change(&mut input, rng));
        input.truncate(LONGEST);
        return input;
    };
    let mut binary = binary.map(<[u8]>::to_vec);
    few_times(rng, |rng| match rng.u8(0..4) {
        0 => match &mut binary {
            Some(binary) => bytes::change_in_place(binary, rng),
            None => change_data_uri(&mut document, rng),
        },
        _ => json::change(&mut document, rng),
    });
    join(&json::to_text(&document, rng), binary.as_deref())
}

/// Changes a buffer that is in its URI.
fn change_data_uri(document: &mut Value, rng: &mut Rng) {
    let Some(buffers) = document.get_mut("buffers").and_then(Value::as_array_mut) else { return };
    for uri in buffers.iter_mut().filter_map(|buffer| buffer.get_mut("uri")) {
        let data = uri.as_str().and_then(|uri| uri.strip_prefix(DATA)).and_then(|text| STANDARD.decode(text).ok());
        if let Some(mut data) = data {
            bytes::change_in_place(&mut data, rng);
            *uri = json!(data_uri(&data));
        }
    }
}

/// Bytes as a URI.
pub(crate) fn data_uri(data: &[u8]) -> String {
    format!("{DATA}{}", STANDARD.encode(data))
}

/// The JSON text and the binary chunk of a sound GLB; anything else is all text.
fn split(input: &[u8]) -> (&[u8], Option<&[u8]>) {
    fn chunk(rest: &[u8]) -> Option<(&[u8], &[u8])> {
        let length = u32::from_le_bytes(*rest.first_chunk()?) as usize;
        rest.get(8..)?.split_at_checked(length)
    }
    if !input.starts_with(b"glTF") {
        return (input, None);
    }
    match input.get(12..).and_then(chunk) {
        Some((text, rest)) => (text, chunk(rest).map(|(binary, _)| binary)),
        None => (input, None),
    }
}

/// A GLB of both, with all lengths right; a text alone stays a text.
pub(crate) fn join(text: &[u8], binary: Option<&[u8]>) -> Vec<u8> {
    let Some(binary) = binary else { return text.to_vec() };
    let (text_length, binary_length) = (text.len().next_multiple_of(4), binary.len().next_multiple_of(4));
    let total = 28 + text_length + binary_length;
    let mut glb = Vec::with_capacity(total);
    glb.extend(b"glTF\x02\0\0\0");
    glb.extend((total as u32).to_le_bytes());
    for (kind, data, length, filler) in [(b"JSON", text, text_length, b' '), (b"BIN\0", binary, binary_length, b'\0')] {
        glb.extend((length as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(data);
        glb.resize(glb.len() + length - data.len(), filler);
    }
    glb
}
