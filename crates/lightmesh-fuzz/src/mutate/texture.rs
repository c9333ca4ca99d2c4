//! Pictures of textures, by their formats.

use fastrand::Rng;

use super::{LONGEST, bytes, few_times, jpeg, png, webp};

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let change = match input {
        [0x89, b'P', ..] => png::change,
        [0xff, 0xd8, ..] => jpeg::change,
        [b'R', b'I', b'F', b'F', ..] => webp::change,
        _ => bytes::change,
    };
    let mut picture = input.to_vec();
    few_times(rng, |rng| {
        if rng.u8(0..32) == 0 {
            bytes::change(&mut picture, rng);
        } else {
            change(&mut picture, rng);
        }
    });
    picture.truncate(LONGEST);
    picture
}
