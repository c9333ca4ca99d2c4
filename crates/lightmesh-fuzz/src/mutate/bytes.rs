//! Changes of bytes whose meaning is not known.

use std::ops::Range;

use fastrand::Rng;

use super::numbers;

/// A range of at most `longest` items within `length`.
pub(super) fn range(rng: &mut Rng, length: usize, longest: usize) -> Range<usize> {
    let start = rng.usize(0..=length);
    let end = start + rng.usize(0..=longest.min(length - start));
    start..end
}

/// Changes one thing; the length may change.
pub(super) fn change(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let length = bytes.len();
    match rng.u8(0..8) {
        0 => {
            let at = range(rng, length, 64);
            bytes.drain(at);
        }
        1 => {
            let at = range(rng, length, 64);
            let copy = bytes[at].to_vec();
            let to = rng.usize(0..=length);
            bytes.splice(to..to, copy);
        }
        2 if rng.u8(0..4) == 0 => bytes.truncate(rng.usize(0..=length)),
        3 => {
            let at = rng.usize(0..=length);
            let new: Vec<u8> = (0..rng.usize(1..9)).map(|_| rng.u8(..)).collect();
            bytes.splice(at..at, new);
        }
        _ => change_in_place(bytes, rng),
    }
}

/// Changes one thing; the length stays.
pub(super) fn change_in_place(bytes: &mut [u8], rng: &mut Rng) {
    let length = bytes.len();
    if length == 0 {
        return;
    }
    let at = rng.usize(0..length);
    match rng.u8(0..8) {
        0 => bytes[at] ^= 1 << rng.u8(0..8),
        1 => bytes[at] = rng.u8(..),
        2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][rng.usize(0..5)],
        3 => bytes[at] = bytes[at].wrapping_add(rng.u8(..).wrapping_sub(128) / 16),
        4 => {
            let from = range(rng, length, 16);
            let count = from.len().min(length - at);
            bytes.copy_within(from.start..from.start + count, at);
        }
        _ => set_word(bytes, at, rng),
    }
}

/// Sets a word of one, two, four or eight bytes, mostly aligned, to a hostile number.
pub(super) fn set_word(bytes: &mut [u8], at: usize, rng: &mut Rng) {
    let word = match rng.u8(0..6) {
        0 => (numbers::whole(rng) as u16).to_le_bytes().to_vec(),
        1 => numbers::double(rng).to_le_bytes().to_vec(),
        2 | 3 => numbers::float(rng).to_le_bytes().to_vec(),
        _ => (numbers::whole(rng) as u32).to_le_bytes().to_vec(),
    };
    let at = if rng.u8(0..4) == 0 { at } else { at - at % word.len() };
    let count = word.len().min(bytes.len().saturating_sub(at));
    bytes[at..at + count].copy_from_slice(&word[..count]);
    if rng.u8(0..8) == 0 {
        bytes[at..at + count].reverse();
    }
}
