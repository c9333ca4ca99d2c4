//! What denoising may take of the machine.

use lightmesh::{Method, Quality};

/// What denoising may take of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resources {
    /// Threads, at least 1.
    pub threads: usize,
    /// The memory that the library tries to stay below, bytes; it then works tile by tile, and takes longer.
    pub max_memory: u64,
    /// How much work it may do.
    pub effort: Effort,
}

/// How much work the denoiser does: which of its networks it takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// The best network.
    #[default]
    Full,
    /// The fastest one. Previews of a living room and of Sponza: 7.8 and 5.0% error instead of 7.8 and 4.9%, in a third of the
    /// time. Libraries before 2.3 have none, and do as [`Self::Full`] says.
    Fast,
}

impl Resources {
    /// Returns the threads of the current pool, and the effort that goes with the quality of pictures by a method.
    pub fn for_method(method: Method, max_memory: u64) -> Self {
        let is_preview = method.error().is_some_and(|error| error >= Quality::Preview.error());
        let effort = if is_preview { Effort::Fast } else { Effort::Full };
        Self { threads: rayon::current_num_threads(), max_memory, effort }
    }
}
