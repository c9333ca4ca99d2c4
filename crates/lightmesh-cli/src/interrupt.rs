//! Ctrl-C.

use std::{
    fs,
    path::PathBuf,
    process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use crate::exit::INTERRUPTED;

/// Whether Ctrl-C was pressed.
static PRESSED: AtomicBool = AtomicBool::new(false);
/// Files to remove where the program ends by the watchdog.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
/// How long the work has to end by itself. The whole program ends within a second.
const GRACE: Duration = Duration::from_millis(600);

/// Listens for Ctrl-C (and SIGTERM). The first signal asks the work to stop; if a reader or writer does not listen, the
/// program ends after a grace period. The second signal ends the program at once. On a system without signals this does
/// nothing.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| {
        if PRESSED.swap(true, Ordering::Relaxed) {
            end();
        }
        // The handler itself stays free for the second press.
        let watchdog = thread::Builder::new().spawn(|| {
            thread::sleep(GRACE);
            end();
        });
        if watchdog.is_err() {
            end();
        }
    });
    // Files above a limit of the shell (`ulimit -f`): the write fails, as on a full disk, where the signal would end the
    // program and leave its temporaries.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Returns whether the work should stop.
pub(crate) fn pressed() -> bool {
    PRESSED.load(Ordering::Relaxed)
}

/// Has `path` removed where the program is ended.
pub(crate) fn remove_at_end(path: PathBuf) {
    let mut temporaries = TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner);
    // A file that is written again and again has the same temporary.
    if !temporaries.contains(&path) {
        temporaries.push(path);
    }
}

/// Does what gives these temporaries their names, all of them: the program does not end meanwhile. They need not be
/// removed after that.
pub(crate) fn undisturbed<T>(named: &[PathBuf], work: impl FnOnce() -> T) -> T {
    let mut temporaries = TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner);
    let result = work();
    temporaries.retain(|path| !named.contains(path));
    result
}

/// Removes the temporaries and ends the program.
fn end() -> ! {
    for path in TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner).iter() {
        let _ = fs::remove_file(path);
    }
    process::exit(INTERRUPTED.into())
}
