//! How a long computation reports and is stopped.

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stage {
    /// Building the acceleration structures.
    Build,
    /// Tracing and shading pictures samples; counts samples.
    Render,
}

/// Receives reports and may cancel. Called from worker threads, at most a few hundred times a second.
pub trait Progress: Sync {
    /// `done` of `total` units of `stage` are finished; `rays` were traced since the stage began.
    fn report(&self, stage: Stage, done: u64, total: u64, rays: u64) {
        let _ = (stage, done, total, rays);
    }

    /// Whether the work should stop; asked every few milliseconds.
    fn cancelled(&self) -> bool {
        false
    }
}

/// No reports, no cancelling.
impl Progress for () {}
