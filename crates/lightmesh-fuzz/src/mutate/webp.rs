//! WebP: its chunks, with all lengths made right.

use fastrand::Rng;

use super::bytes;

/// Bytes before the first chunk.
const HEADER: usize = 12;

/// Changes one thing.
pub(super) fn change(picture: &mut Vec<u8>, rng: &mut Rng) {
    let mut chunks = split(picture);
    if chunks.is_empty() {
        return bytes::change(picture, rng);
    }
    let at = rng.usize(0..chunks.len());
    match rng.u8(0..8) {
        0..=2 => {
            // The beginning holds sizes and flags.
            let data = &mut chunks[at].1;
            let length = data.len().min(12);
            bytes::change_in_place(&mut data[..length], rng);
        }
        3 | 4 => bytes::change_in_place(&mut chunks[at].1, rng),
        5 => bytes::change(&mut chunks[at].1, rng),
        6 => {
            let chunk = chunks[at].clone();
            chunks.insert(rng.usize(0..=chunks.len()), chunk);
        }
        _ => {
            let kind =
                [*b"VP8 ", *b"VP8L", *b"VP8X", *b"ALPH", *b"ANIM", *b"ANMF", *b"ICCP", *b"EXIF"][rng.usize(0..8)];
            if rng.bool() {
                chunks[at].0 = kind;
            } else {
                chunks.insert(at, (kind, (0..rng.usize(0..20)).map(|_| rng.u8(..)).collect()));
            }
        }
    }
    let mut body = b"WEBP".to_vec();
    for (kind, mut data) in chunks {
        body.extend(kind);
        body.extend((data.len() as u32).to_le_bytes());
        data.resize(data.len().next_multiple_of(2), 0);
        body.extend(data);
    }
    picture.truncate(4);
    picture.extend((body.len() as u32).to_le_bytes());
    picture.extend(body);
}

fn split(picture: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    let mut chunks = Vec::new();
    let mut rest = picture.get(HEADER..).unwrap_or_default();
    while let (Some(kind), Some(length)) = (rest.first_chunk::<4>(), rest.get(4..8)) {
        let length = u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let Some(data) = rest.get(8..8 + length) else { break };
        chunks.push((*kind, data.to_vec()));
        rest = rest.get(8 + length.next_multiple_of(2)..).unwrap_or_default();
    }
    chunks
}
