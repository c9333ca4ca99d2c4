//! The steps at which writing a file can fail; tests let each of them fail once.

use std::io;

/// Something that the operating system is about to be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// A temporary is made.
    Create,
    /// Bytes go to a temporary or to a pipe or device.
    Write,
    /// The bytes of a temporary go to the disk.
    Sync,
    /// A pipe or device is opened.
    Open,
    /// An old file gets a second name, so that it can be put back.
    Keep,
    /// A temporary gets its file's name.
    Rename,
}

/// Called before each step. Outside of tests it does nothing.
#[cfg(not(test))]
#[inline]
pub(super) fn before(_: Step) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
pub(super) use self::injection::before;
#[cfg(test)]
pub(crate) use self::injection::during;

#[cfg(test)]
mod injection {
    use std::cell::RefCell;

    use super::{Step, io};

    thread_local! {
        static INJECTED: RefCell<Injected> = RefCell::default();
    }

    /// The steps that this thread has taken, and which of them fail.
    #[derive(Debug, Default)]
    struct Injected {
        steps: Vec<Step>,
        fails: Vec<usize>,
    }

    /// Runs `work`, of whose steps those with these numbers fail; returns what it returns, and the steps that it took.
    pub(crate) fn during<T>(fails: &[usize], work: impl FnOnce() -> T) -> (T, Vec<Step>) {
        INJECTED.replace(Injected { steps: Vec::new(), fails: fails.to_vec() });
        let result = work();
        (result, INJECTED.take().steps)
    }

    /// Counts a step; an error if it is the one that fails.
    pub(crate) fn before(step: Step) -> io::Result<()> {
        INJECTED.with_borrow_mut(|injected| {
            injected.steps.push(step);
            match injected.fails.contains(&(injected.steps.len() - 1)) {
                true => Err(io::Error::other(format!("{step:?} fails"))),
                false => Ok(()),
            }
        })
    }
}
