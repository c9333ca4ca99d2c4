//! Tries the targets on a stable compiler, each in a process of its own and so many at once. `README.md` says how to use
//! it.

use std::process::ExitCode;

use lightmesh_fuzz::trial::{Choices, find_again, supervise, work};

#[expect(clippy::print_stderr, reason = "a program says what it did")]
fn main() -> ExitCode {
    let choices = match Choices::parse(std::env::args().skip(1)) {
        Ok(choices) => choices,
        Err(what) => {
            eprintln!("try_targets: {what}");
            return ExitCode::from(2);
        }
    };
    match (choices.is_worker, choices.input.is_some()) {
        (true, _) => work(&choices),
        (false, true) => find_again(&choices),
        (false, false) => supervise(&choices),
    }
}
