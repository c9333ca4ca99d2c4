//! Radiance: its header by words, its pixels by bytes.

use fastrand::Rng;

use super::{bytes, text};

const WORDS: [&str; 14] = [
    "#?RADIANCE",
    "FORMAT=32-bit_rle_rgbe",
    "FORMAT=32-bit_rle_xyze",
    "EXPOSURE=1",
    "EXPOSURE=0",
    "EXPOSURE=nan",
    "EXPOSURE=1e-45",
    "COLORCORR=1 1 1",
    "COLORCORR=0 inf 1e38",
    "-Y",
    "+Y",
    "+X",
    "-X",
    "\n",
];

/// Changes one thing.
pub(super) fn change(map: &mut Vec<u8>, rng: &mut Rng) {
    // The line with the size is the one after an empty one.
    let empty = map.windows(2).position(|pair| pair == b"\n\n").map_or(0, |at| at + 2);
    let end = map[empty..].iter().position(|&b| b == b'\n').map_or(map.len(), |at| empty + at + 1);
    let mut pixels = map.split_off(end);
    if rng.u8(0..3) == 0 {
        text::change(map, &WORDS, rng);
    } else {
        bytes::change(&mut pixels, rng);
    }
    map.append(&mut pixels);
}
