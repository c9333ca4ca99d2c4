//! How inputs are damaged, for each kind.

mod bytes;
pub(crate) mod environment;
mod exr;
pub(crate) mod gltf;
mod jpeg;
mod json;
pub(crate) mod mesh_file;
mod numbers;
pub(crate) mod obj;
pub(crate) mod ply;
mod png;
mod radiance;
pub(crate) mod scene_bytes;
mod scene_floats;
mod text;
pub(crate) mod texture;
mod webp;

use fastrand::Rng;

/// The longest input, bytes: longer ones are cut.
const LONGEST: usize = 1 << 14;

/// Does something one to six times, mostly once or twice.
fn few_times(rng: &mut Rng, mut change: impl FnMut(&mut Rng)) {
    let times = 1 + rng.usize(0..3) * rng.usize(0..3);
    for _ in 0..times {
        change(rng);
    }
}
