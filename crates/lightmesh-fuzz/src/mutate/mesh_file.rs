//! Files of meshes: their arrays and their header, with offsets and checksums made right.

use fastrand::Rng;
use serde_json::{Map, Value, json};

use super::{LONGEST, bytes, few_times, json as tree, numbers};

/// An array: its name, the rest of its entry, and its bytes.
#[derive(Debug)]
struct Array {
    name: String,
    entry: Value,
    data: Vec<u8>,
}

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let parsed = split(input).filter(|_| rng.u8(0..16) != 0);
    let Some((mut texts, mut arrays)) = parsed else {
        let mut input = input.to_vec();
        few_times(rng, |rng| bytes::change(&mut input, rng));
        return input;
    };
    // Most files with a wrong checksum are refused for that alone.
    let right_sums = rng.u8(0..16) != 0;
    few_times(rng, |rng| {
        if arrays.is_empty() {
            return tree::change(&mut texts, rng);
        }
        let at = rng.usize(0..arrays.len());
        match rng.u8(0..10) {
            0 => tree::change(&mut texts, rng),
            1 => tree::change(&mut arrays[at].entry, rng),
            2 => drop(arrays.remove(at)),
            3 => {
                let name = arrays[rng.usize(0..arrays.len())].name.clone();
                arrays[at].name = name;
            }
            4 | 5 => resize(&mut arrays[at], rng),
            _ => set(&mut arrays[at], rng),
        }
    });
    let mut file = join(texts, &arrays, right_sums, rng);
    file.truncate(4 * LONGEST);
    file
}

/// Sets a number of an array to a hostile one of its type.
fn set(array: &mut Array, rng: &mut Rng) {
    let word = match array.entry["dtype"].as_str() {
        Some("F32") => numbers::float(rng).to_le_bytes().to_vec(),
        Some("F64") => numbers::double(rng).to_le_bytes().to_vec(),
        Some("U8") => vec![rng.u8(..)],
        Some("U64") => numbers::whole(rng).to_le_bytes().to_vec(),
        _ => (numbers::whole(rng) as u32).to_le_bytes().to_vec(),
    };
    let count = array.data.len() / word.len();
    if count > 0 {
        let at = rng.usize(0..count) * word.len();
        array.data[at..at + word.len()].copy_from_slice(&word);
    }
}

/// Changes a number of an array's shape, and its bytes with it.
fn resize(array: &mut Array, rng: &mut Rng) {
    let shape = array.entry.get_mut("shape").and_then(Value::as_array_mut).filter(|shape| !shape.is_empty());
    let Some(shape) = shape else { return };
    let at = rng.usize(0..shape.len());
    let old = shape[at].as_u64().unwrap_or(0).max(1) as usize;
    let new = [0, 1, old.saturating_add(1), old - 1, old.saturating_mul(2)][rng.usize(0..5)];
    shape[at] = json!(new);
    array.data.resize((array.data.len() / old).saturating_mul(new).min(LONGEST), 0);
}

/// The texts of a sound file, and its arrays in their order.
fn split(input: &[u8]) -> Option<(Value, Vec<Array>)> {
    let (length, rest) = input.split_first_chunk::<8>()?;
    let (header, body) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    let Value::Object(mut header) = serde_json::from_slice(header).ok()? else { return None };
    let mut texts = header.remove("__metadata__").unwrap_or_default();
    if let Some(texts) = texts.as_object_mut() {
        texts.remove("crc32");
    }
    let mut arrays = Vec::new();
    for (name, mut entry) in header {
        let Some(offsets) = entry.as_object_mut().and_then(|entry| entry.remove("data_offsets")) else { continue };
        let offset = |i: usize| offsets.get(i).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
        let (begin, end) = (offset(0)?, offset(1)?);
        arrays.push((begin, Array { name, entry, data: body.get(begin..end)?.to_vec() }));
    }
    arrays.sort_by_key(|(begin, _)| *begin);
    Some((texts, arrays.into_iter().map(|(_, array)| array).collect()))
}

fn join(mut texts: Value, arrays: &[Array], right_sums: bool, rng: &mut Rng) -> Vec<u8> {
    let (mut header, mut sums, mut body) = (Map::new(), Map::new(), Vec::new());
    for Array { name, entry, data } in arrays {
        let mut entry = entry.clone();
        let begin = body.len();
        body.extend(data);
        if let Some(entry) = entry.as_object_mut() {
            entry.insert("data_offsets".into(), json!([begin, body.len()]));
        }
        header.insert(name.clone(), entry);
        sums.insert(name.clone(), json!(crc32fast::hash(data)));
    }
    if let (true, Some(texts)) = (right_sums, texts.as_object_mut()) {
        texts.insert("crc32".into(), json!(Value::Object(sums).to_string()));
    }
    header.insert("__metadata__".into(), texts);
    let header = tree::to_text(&Value::Object(header), rng);
    [&(header.len() as u64).to_le_bytes(), &header[..], &body].concat()
}
