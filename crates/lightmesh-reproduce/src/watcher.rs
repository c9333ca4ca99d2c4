//! Progress of the experiments.

/// Hears how far the experiments are, and may stop them.
pub trait Watcher: Sync {
    /// An experiment begins; `done` of `total` are finished.
    fn begin(&self, title: &str, done: usize, total: usize) {
        let _ = (title, done, total);
    }

    /// A picture of it begins.
    fn picture(&self, what: &str) {
        let _ = what;
    }

    /// Returns whether the work should stop; called every few milliseconds.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Ignores everything.
impl Watcher for () {}
