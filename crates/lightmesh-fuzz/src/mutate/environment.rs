//! Environment maps, by their formats.

use fastrand::Rng;

use super::{LONGEST, exr, few_times, radiance};

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut map = input.to_vec();
    let change = if map.starts_with(b"#?") { radiance::change } else { exr::change };
    few_times(rng, |rng| change(&mut map, rng));
    map.truncate(LONGEST);
    map
}
