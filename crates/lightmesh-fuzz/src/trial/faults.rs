//! Panics, caught and told apart by their place.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    /// Where and with what words this thread panicked last.
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
    /// Whether it works for [`catch`].
    static IS_CAUGHT: Cell<bool> = const { Cell::new(false) };
}

/// Keeps panics of what [`catch`] does silent, and remembers them.
pub(super) fn listen() {
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !IS_CAUGHT.get() {
            return usual(info);
        }
        let place = info.location().map(|at| format!("{}:{}", at.file(), at.line())).unwrap_or_default();
        let payload = info.payload();
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let words = text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or_default();
        LAST.set(Some(format!("{place}: {words}")));
    }));
}

/// Does some work; an error is the place and the words of its panic.
pub(super) fn catch<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    IS_CAUGHT.set(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    IS_CAUGHT.set(false);
    result.map_err(|_| LAST.take().unwrap_or_else(|| "a panic of another thread".to_owned()))
}

/// The same for all panics at one place: what differs from input to input is left out.
pub(super) fn kind(panic: &str) -> String {
    let (place, words) = panic.split_once(": ").unwrap_or((panic, ""));
    let words: String = words.chars().filter(|c| !c.is_ascii_digit()).take(40).collect();
    format!("{place}: {words}")
}
