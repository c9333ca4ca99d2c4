//! OpenEXR: the values of its attributes, and its chunks; no length changes, so that all offsets stay right.

use std::ops::Range;

use fastrand::Rng;

use super::bytes;

/// Bytes before the first attribute.
const HEADER: usize = 8;

/// Changes one thing.
pub(super) fn change(map: &mut Vec<u8>, rng: &mut Rng) {
    let (attributes, end) = attributes(map);
    match rng.u8(0..8) {
        0 => bytes::change(map, rng),
        1 => bytes::change_in_place(&mut map[..], rng),
        2..=4 if !attributes.is_empty() => {
            let value = attributes[rng.usize(0..attributes.len())].clone();
            bytes::change_in_place(&mut map[value], rng);
        }
        _ => bytes::change_in_place(&mut map[end..], rng),
    }
}

/// Where the values of the first header's attributes are, and where it ends.
fn attributes(map: &[u8]) -> (Vec<Range<usize>>, usize) {
    let text_end = |from: usize| map.get(from..)?.iter().position(|&b| b == 0).map(|length| from + length + 1);
    let mut found = Vec::new();
    let mut at = HEADER.min(map.len());
    while map.get(at).is_some_and(|&b| b != 0) {
        let Some(kind) = text_end(at) else { break };
        let Some(size) = text_end(kind) else { break };
        let Some(length) = map.get(size..).and_then(|rest| rest.first_chunk::<4>()) else { break };
        let value = size + 4..size.saturating_add(4).saturating_add(u32::from_le_bytes(*length) as usize);
        if value.end > map.len() {
            break;
        }
        at = value.end;
        // The size itself may be damaged, too.
        found.push(if found.len() % 4 == 3 { size..value.end } else { value });
    }
    (found, at)
}
