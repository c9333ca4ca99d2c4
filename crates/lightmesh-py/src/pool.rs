//! The threads that work on pictures, also in a process that was forked.
//!
//! All calls share one pool, that of rayon, unless they say how many threads they want. A fork copies the memory of that
//! pool and none of its threads, so that whoever gives it work waits for ever: a forked process gets a pool of its own.

use std::ffi::CString;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use lightmesh_cli::Threads;
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyDict};
use rayon::ThreadPool;

use crate::error;

/// The process that has imported lightmesh, where rayon's own pool works.
static FIRST_PROCESS: OnceLock<u32> = OnceLock::new();
/// How many forks lie between that process and this one, as far as Python knows.
static FORKS: AtomicU32 = AtomicU32::new(0);

/// A process that was forked: its forks and its number.
type Forked = (u32, u32);

/// The pool of a forked process.
static OWN_POOL: Mutex<Option<(Forked, Arc<ThreadPool>)>> = Mutex::new(None);

/// Notes which process this is, and has Python say when it is forked.
pub(crate) fn watch_forks(py: Python<'_>) -> PyResult<()> {
    FIRST_PROCESS.get_or_init(std::process::id);
    let os = py.import("os")?;
    // Windows has no forks.
    if let Some(register) = os.getattr_opt("register_at_fork")? {
        let note = PyCFunction::new_closure(py, None, None, |_, _| FORKS.fetch_add(1, Ordering::Relaxed))?;
        let hooks = PyDict::new(py);
        hooks.set_item("after_in_child", note)?;
        register.call((), Some(&hooks))?;
    }
    Ok(())
}

/// Returns the pool to work in: of so many threads, if that is said; else the one that all calls of this process share,
/// `None` where that is rayon's own.
pub(crate) fn of(py: Python<'_>, threads: Option<usize>) -> PyResult<Option<Arc<ThreadPool>>> {
    if threads.is_some() {
        return start(py, threads).map(Some);
    }
    let this = (FORKS.load(Ordering::Relaxed), std::process::id());
    if this.0 == 0 && FIRST_PROCESS.get() == Some(&this.1) {
        return start_rayon(py).map(|()| None);
    }
    // Whoever had it locked at the fork is not here to unlock it: a pool for this call alone will do.
    let Ok(mut own) = OWN_POOL.try_lock() else { return start(py, None).map(Some) };
    if let Some((_, pool)) = own.as_ref().filter(|(whose, _)| *whose == this) {
        return Ok(Some(Arc::clone(pool)));
    }
    let pool = start(py, None)?;
    // One of the process before has no threads that could be told to end.
    std::mem::forget(own.replace((this, Arc::clone(&pool))));
    Ok(Some(pool))
}

/// Starts rayon's own pool, with no more threads than are of use.
fn start_rayon(py: Python<'_>) -> PyResult<()> {
    static STARTED: OnceLock<(Threads, Result<(), String>)> = OnceLock::new();
    // Whoever waits for another thread here does so without the interpreter's lock.
    let (threads, started) = py.detach(|| {
        STARTED.get_or_init(|| {
            let threads = Threads::new(None);
            let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.count);
            let started = builder.build_global().map_err(|error| format!("threads: {error}"));
            (threads, started)
        })
    });
    warn(py, threads)?;
    started.as_ref().map_err(|what| error::general(py, what)).copied()
}

/// Starts a pool.
fn start(py: Python<'_>, threads: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    let threads = Threads::new(threads);
    warn(py, &threads)?;
    threads.start().map(Arc::new).map_err(|what| error::general(py, what))
}

/// Warns where fewer threads work than were asked for; Python says it once.
fn warn(py: Python<'_>, threads: &Threads) -> PyResult<()> {
    match threads.warning.as_ref().and_then(|warning| CString::new(warning.as_str()).ok()) {
        Some(warning) => PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &warning, 1),
        None => Ok(()),
    }
}

/// Does something short without the interpreter's lock, in the pool that all calls share.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = of(py, None)?;
    Ok(py.detach(|| match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }))
}
