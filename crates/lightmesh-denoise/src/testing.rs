//! What tests of several modules need.

use crate::Denoiser;

/// Runs a test of the library where there is one, and says so where there is none.
#[expect(clippy::print_stderr, reason = "a test that did not run is to be seen")]
pub(crate) fn with_library(test: impl FnOnce(&Denoiser)) {
    match Denoiser::load() {
        Ok(denoiser) => test(&denoiser),
        Err(error) => eprintln!("skipped: {error}"),
    }
}

/// A number in [0, 1), another one for each index.
pub(crate) fn random(index: usize) -> f32 {
    let x = (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((x ^ (x >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93) >> 40) as f32 / (1 << 24) as f32
}
