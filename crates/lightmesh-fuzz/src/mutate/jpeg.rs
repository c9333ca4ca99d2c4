//! JPEG: its segments, with their lengths made right.

use fastrand::Rng;

use super::bytes;

/// Changes one thing.
pub(super) fn change(picture: &mut Vec<u8>, rng: &mut Rng) {
    let (mut segments, rest) = split(picture);
    if segments.is_empty() {
        return bytes::change(picture, rng);
    }
    let at = rng.usize(0..segments.len());
    let mut rest = rest;
    match rng.u8(0..10) {
        0..=3 => bytes::change_in_place(&mut segments[at].1, rng),
        4 => bytes::change(&mut segments[at].1, rng),
        5 => drop(segments.remove(at)),
        6 => {
            let segment = segments[at].clone();
            segments.insert(rng.usize(0..=segments.len()), segment);
        }
        7 => {
            // Another kind: other frames (baseline, progressive, lossless, arithmetic), tables, restarts.
            segments[at].0 = [0xc0, 0xc1, 0xc2, 0xc3, 0xc4, 0xc9, 0xdb, 0xdd, 0xe0, 0xe1, 0xee, 0xfe][rng.usize(0..12)];
        }
        _ => bytes::change(&mut rest, rng),
    }
    picture.truncate(2);
    for (kind, data) in segments {
        picture.extend([0xff, kind]);
        picture.extend((data.len() as u16).wrapping_add(2).to_be_bytes());
        picture.extend(data);
    }
    picture.extend(rest);
}

/// Segments up to the first scan's, with their kinds; then the rest.
fn split(picture: &[u8]) -> (Vec<(u8, Vec<u8>)>, Vec<u8>) {
    let mut segments = Vec::new();
    let mut rest = picture.get(2..).unwrap_or_default();
    while let &[0xff, kind, high, low, ..] = rest {
        let end = 2 + usize::from(u16::from_be_bytes([high, low]));
        let Some(data) = rest.get(4..end) else { break };
        segments.push((kind, data.to_vec()));
        rest = &rest[end..];
        if kind == 0xda {
            break;
        }
    }
    (segments, rest.to_vec())
}
