//! Long work on a thread of its own, while the calling one listens: Ctrl-C ends it, and its progress goes to a
//! callback.

use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use lightmesh::{Progress, Stage};
use pyo3::prelude::*;

use crate::{error, pool};

/// How often signals and progress are looked at.
const PERIOD: Duration = Duration::from_millis(50);
/// The stack of a work thread, as large as that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// What happens to work that is interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtInterrupt {
    /// It is told to stop and does so within milliseconds; the caller waits for it.
    Wait,
    /// It cannot be told to stop: it runs to its end, and its result is dropped.
    Abandon,
}

/// The connection of the work to its caller: the work reports progress to it, and asks it whether to stop.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    cancelled: AtomicBool,
    /// The newest report of each stage that the callback has not heard of; `None`: nobody listens.
    reports: Mutex<Option<Vec<Report>>>,
}

/// The progress of a stage.
#[derive(Clone, Copy, Debug)]
struct Report {
    stage: &'static str,
    done: u64,
    total: u64,
    rays: u64,
}

impl Progress for Watch {
    fn report(&self, stage: Stage, done: u64, total: u64, rays: u64) {
        self.note(Report { stage: stage_name(stage), done, total, rays });
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Watch {
    /// Reports how many bytes of a file are written.
    pub(crate) fn saved(&self, done: u64, total: u64) {
        self.note(Report { stage: "save", done, total, rays: 0 });
    }

    fn note(&self, report: Report) {
        if let Some(reports) = locked(&self.reports).as_mut() {
            match reports.last_mut() {
                Some(last) if last.stage == report.stage => *last = report,
                _ => reports.push(report),
            }
        }
    }

    /// Passes new reports to the callback, without holding the lock.
    fn pass_on(&self, callback: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Some(callback) = callback else { return Ok(()) };
        let reports = locked(&self.reports).as_mut().map(std::mem::take).unwrap_or_default();
        for Report { stage, done, total, rays } in reports {
            callback.call1((stage, done, total, rays))?;
        }
        Ok(())
    }
}

/// Returns the name of a stage for callbacks.
fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::CoarsePreview => "sketch",
        Stage::Check => "check",
        Stage::Render => "render",
        Stage::EmitterEdges => "outlines",
        Stage::Resample => "resample",
        Stage::Demand => "demand",
        Stage::Measure => "measure",
        Stage::Fill => "fill",
        _ => "work",
    }
}

/// The place where the thread puts its result.
struct Slot<T> {
    result: Mutex<Option<thread::Result<T>>>,
    filled: Condvar,
    watch: Watch,
}

/// Runs `work` on a thread of its own, in a pool of `threads` or in the shared one, and returns its result.
///
/// # Errors
/// `KeyboardInterrupt`, and whatever the callback or a signal's handler raises: the work is cancelled then.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    callback: Option<&Bound<'_, PyAny>>,
    at_interrupt: AtInterrupt,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    // Find the threads to work on.
    let pool = pool::of(py, threads)?;

    // Start the work on a thread of its own.
    let watch = Watch { reports: Mutex::new(callback.map(|_| Vec::new())), ..Watch::default() };
    let slot = Arc::new(Slot { result: Mutex::new(None), filled: Condvar::new(), watch });
    let theirs = Arc::clone(&slot);
    let body = move || {
        let work = || match pool {
            Some(pool) => pool.install(|| work(&theirs.watch)),
            None => work(&theirs.watch),
        };
        let result = panic::catch_unwind(AssertUnwindSafe(work));
        *locked(&theirs.result) = Some(result);
        theirs.filled.notify_one();
    };
    let thread = thread::Builder::new().name("lightmesh".to_owned()).stack_size(STACK_BYTES).spawn(body);
    thread.map_err(|cause| error::general(py, format!("no thread could be started: {cause}")))?;

    // Listen until it is done; what is raised first is what counts.
    let mut raised = None;
    loop {
        let result = py.detach(|| {
            let unfilled = |result: &mut Option<_>| result.is_none();
            let waited = slot.filled.wait_timeout_while(locked(&slot.result), PERIOD, unfilled);
            waited.unwrap_or_else(PoisonError::into_inner).0.take()
        });
        if raised.is_none() {
            raised = py.check_signals().and_then(|()| slot.watch.pass_on(callback)).err();
            if raised.is_some() {
                slot.watch.cancelled.store(true, Ordering::Relaxed);
            }
        }
        match (result, raised.take()) {
            (Some(_), Some(error)) => return Err(error),
            (Some(Ok(result)), None) => return Ok(result),
            (Some(Err(panic)), None) => return Err(error::internal(panic_message(&*panic))),
            (None, Some(error)) if at_interrupt == AtInterrupt::Abandon => return Err(error),
            (None, error) => raised = error,
        }
    }
}

/// Returns the message of a panic.
fn panic_message(panic: &(dyn std::any::Any + Send)) -> &str {
    let said = panic.downcast_ref::<&str>().copied();
    said.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Locks a mutex whose content is only ever replaced as a whole, so that a panic elsewhere cannot leave it half done.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
