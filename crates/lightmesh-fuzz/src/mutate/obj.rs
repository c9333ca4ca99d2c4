//! OBJ and its material library, by words and lines.

use fastrand::Rng;

use super::{LONGEST, few_times, text};
use crate::targets::obj::{LIBRARY, split};

const OBJ_WORDS: [&str; 18] = [
    "v",
    "vt",
    "vn",
    "f",
    "o",
    "g",
    "usemtl",
    "mtllib",
    "l",
    "p",
    "s",
    "vp",
    "#",
    "\\\n",
    "library.mtl",
    "glass",
    "curv",
    "1//1",
];
const LIBRARY_WORDS: [&str; 32] = [
    "newmtl",
    "Kd",
    "Ks",
    "Ke",
    "Tf",
    "d",
    "Tr",
    "Ni",
    "illum",
    "map_Kd",
    "map_Ke",
    "map_d",
    "norm",
    "map_Bump",
    "-o",
    "-s",
    "-clamp on",
    "-bm",
    "-mm",
    "-halo",
    "t.png",
    "../t.png",
    "glass",
    "spectral",
    "xyz",
    "Pr",
    "Pm",
    "-t",
    "\"",
    "/etc/passwd",
    "input.obj",
    "-imfchan r",
];

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let (obj, library) = split(input);
    let (mut obj, mut library) = (obj.to_vec(), library.to_vec());
    few_times(rng, |rng| {
        if library.is_empty() || rng.u8(0..3) != 0 {
            text::change(&mut obj, &OBJ_WORDS, rng);
        } else {
            text::change(&mut library, &LIBRARY_WORDS, rng);
        }
    });
    obj.truncate(LONGEST);
    library.truncate(LONGEST);
    if library.is_empty() { obj } else { [&obj, LIBRARY, &library].concat() }
}
