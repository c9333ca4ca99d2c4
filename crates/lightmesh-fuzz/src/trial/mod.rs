//! The trial of all targets without cargo fuzz.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program says what it found")]

mod again;
mod choices;
mod faults;
mod pool;
mod report;
mod supervisor;
mod worker;

pub use again::find_again;
pub use choices::Choices;
pub use supervisor::supervise;
pub use worker::work;

/// The longest that an input may take, seconds: a hundred thousand times as long as most.
const LONGEST_S: u64 = 20;
