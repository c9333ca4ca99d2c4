//! PNG: its chunks, with their checksums made right; its pixels before they are deflated.

use fastrand::Rng;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

use super::{bytes, numbers};

const MAGIC: usize = 8;

/// A chunk's kind and data.
type Chunk = ([u8; 4], Vec<u8>);

/// Chunks that may be put in.
const KINDS: [&[u8; 4]; 20] = [
    b"PLTE", b"tRNS", b"gAMA", b"cHRM", b"sRGB", b"iCCP", b"tEXt", b"zTXt", b"iTXt", b"bKGD", b"pHYs", b"sBIT",
    b"acTL", b"fcTL", b"fdAT", b"IDAT", b"IEND", b"IHDR", b"eXIf", b"cICP",
];

/// Changes one thing.
pub(super) fn change(picture: &mut Vec<u8>, rng: &mut Rng) {
    let (mut chunks, rest) = split(picture);
    if chunks.is_empty() {
        return bytes::change(picture, rng);
    }
    let at = rng.usize(0..chunks.len());
    match rng.u8(0..10) {
        0..=2 => change_header(&mut chunks[0].1, rng),
        3 | 4 => {
            // The pixels, and how they are filtered.
            if let Some((_, data)) = chunks.iter_mut().find(|(kind, _)| kind == b"IDAT")
                && let Ok(mut pixels) = decompress_to_vec_zlib_with_limit(data, 1 << 16)
            {
                bytes::change(&mut pixels, rng);
                *data = stored(&pixels);
            }
        }
        5 => bytes::change(&mut chunks[at].1, rng),
        6 => drop(chunks.remove(at)),
        7 => {
            let chunk = chunks[at].clone();
            chunks.insert(rng.usize(0..=chunks.len()), chunk);
        }
        8 => {
            let other = rng.usize(0..chunks.len());
            chunks.swap(at, other);
        }
        _ => {
            let kind = KINDS[rng.usize(0..KINDS.len())];
            let length = [0, 1, 2, 3, 4, 6, 9, 26, 32, 256, 768][rng.usize(0..11)];
            chunks.insert(at, (*kind, (0..length).map(|_| rng.u8(..)).collect()));
        }
    }
    *picture = [&picture[..MAGIC], &join(&chunks), &rest].concat();
}

/// Width, height, bits, colour, compression, filter or interlace.
fn change_header(header: &mut [u8], rng: &mut Rng) {
    if header.len() < 13 {
        return;
    }
    let size = |rng: &mut Rng| match rng.u8(0..4) {
        0 => numbers::whole(rng) as u32,
        _ => rng.u32(0..40),
    };
    match rng.u8(0..6) {
        0 => header[..4].copy_from_slice(&size(rng).to_be_bytes()),
        1 => header[4..8].copy_from_slice(&size(rng).to_be_bytes()),
        2 => header[8] = [1, 2, 4, 8, 16, rng.u8(..)][rng.usize(0..6)],
        3 => header[9] = [0, 2, 3, 4, 6, rng.u8(..)][rng.usize(0..6)],
        4 => header[12] ^= 1,
        _ => header[rng.usize(10..13)] = rng.u8(0..3),
    }
}

/// The whole chunks, and what follows the last of them.
fn split(picture: &[u8]) -> (Vec<Chunk>, Vec<u8>) {
    let mut chunks = Vec::new();
    let mut rest = picture.get(MAGIC..).unwrap_or_default();
    while let (Some(length), Some(kind)) = (rest.first_chunk::<4>(), rest.get(4..8)) {
        let end = 12 + u32::from_be_bytes(*length) as usize;
        let Some(data) = rest.get(8..end.saturating_sub(4)).filter(|_| end <= rest.len()) else { break };
        chunks.push(([kind[0], kind[1], kind[2], kind[3]], data.to_vec()));
        rest = &rest[end..];
    }
    (chunks, rest.to_vec())
}

fn join(chunks: &[Chunk]) -> Vec<u8> {
    let mut out = Vec::new();
    for (kind, data) in chunks {
        out.extend((data.len() as u32).to_be_bytes());
        let start = out.len();
        out.extend(kind);
        out.extend(data);
        let sum = crc32fast::hash(&out[start..]);
        out.extend(sum.to_be_bytes());
    }
    out
}

/// A zlib stream that holds these bytes as they are, up to the length of one block.
fn stored(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len().min(usize::from(u16::MAX));
    let mut out = vec![0x78, 0x01, 0x01];
    out.extend((length as u16).to_le_bytes());
    out.extend((!(length as u16)).to_le_bytes());
    out.extend(&bytes[..length]);
    let sum = |(a, b): (u32, u32), &byte: &u8| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (a + b) % 65_521)
    };
    let (a, b) = bytes[..length].iter().fold((1, 0), sum);
    out.extend((b << 16 | a).to_be_bytes());
    out
}
