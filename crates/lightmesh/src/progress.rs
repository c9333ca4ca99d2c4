//! Progress reports of long computations, and how to cancel them.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::Viewer;

/// A stage of a computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stage {
    /// Rendering a coarse preview for a [`Viewer`]; counts samples.
    CoarsePreview,
    /// Comparing pixels with their exact light, to keep to
    /// the error of [`Method::Mesh`](crate::Method::Mesh); counts samples.
    Check,
    /// Finding the mesh points that a picture's samples read; counts samples.
    Demand,
    /// Tracing and shading a picture's samples; counts samples. With a time limit the total may not be reached.
    Render,
    /// Sampling pixels on emitter edges again, with more samples; counts samples.
    EmitterEdges,
    /// Taking more samples of the pixels with most noise; counts samples.
    Resample,
    /// Measuring with meters; counts samples: one for each meter, with [`Method::Path`](crate::options::Method::Path)
    /// [`PictureOptions::spp`](crate::PictureOptions::spp).
    Measure,
    /// Evaluating mesh points before they are read; counts the requested points.
    Fill,
}

/// Receives reports and may cancel. Reports come from worker threads: one when a stage begins, one when it ends, and
/// between them some twenty a second at most.
pub trait Progress: Sync {
    /// `done` of `total` units of `stage` are finished; `rays` were traced since the stage began.
    fn report(&self, stage: Stage, done: u64, total: u64, rays: u64) {
        let _ = (stage, done, total, rays);
    }

    /// Whether the work should stop; called every few milliseconds.
    fn cancelled(&self) -> bool {
        false
    }

    /// The viewer of the picture while it is rendered, if there is one. Called once, when a render begins.
    fn viewer(&self) -> Option<&dyn Viewer> {
        None
    }
}

/// No reports, no cancelling.
impl Progress for () {}

/// Milliseconds between two reports.
const PERIOD_MS: u64 = 50;

/// Counts the work of a stage from many threads and reports it at intervals.
pub(crate) struct Reporter<'a> {
    progress: &'a dyn Progress,
    stage: Stage,
    total: u64,
    started: Instant,
    done: AtomicU64,
    rays: AtomicU64,
    /// When the next report is due, milliseconds after the start.
    due_ms: AtomicU64,
}

impl<'a> Reporter<'a> {
    /// Begins a stage.
    pub(crate) fn new(progress: &'a dyn Progress, stage: Stage, total: u64) -> Self {
        progress.report(stage, 0, total, 0);
        let zero = || AtomicU64::new(0);
        let due_ms = AtomicU64::new(PERIOD_MS);
        Self { progress, stage, total, started: Instant::now(), done: zero(), rays: zero(), due_ms }
    }

    /// Adds finished work.
    pub(crate) fn add(&self, done: u64, rays: u64) {
        let done = self.done.fetch_add(done, Ordering::Relaxed) + done;
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        let now = self.started.elapsed().as_millis() as u64;
        let due = self.due_ms.load(Ordering::Relaxed);
        // Of the threads that find a report due, one makes it.
        let next = now + PERIOD_MS;
        if now >= due && self.due_ms.compare_exchange(due, next, Ordering::Relaxed, Ordering::Relaxed).is_ok() {
            self.progress.report(self.stage, done, self.total, rays);
        }
    }

    /// Whether the work should stop.
    pub(crate) fn cancelled(&self) -> bool {
        self.progress.cancelled()
    }
}

/// The stage ends: finished, out of time, cancelled or failed.
impl Drop for Reporter<'_> {
    fn drop(&mut self) {
        self.progress.report(self.stage, *self.done.get_mut(), self.total, *self.rays.get_mut());
    }
}
