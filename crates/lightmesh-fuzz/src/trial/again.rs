//! One input once more.

use std::process::ExitCode;
use std::time::Instant;

use super::choices::Choices;
use super::faults;
use crate::{Depth, take_thread_pool};

/// Tries one file as far as a picture, and prints what becomes of it. The exit code is 1 for a panic.
pub fn find_again(choices: &Choices) -> ExitCode {
    let (target, Some(path)) = (choices.targets[0], &choices.input) else { return ExitCode::from(2) };
    let input = match std::fs::read(path) {
        Ok(input) => input,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            return ExitCode::from(2);
        }
    };
    take_thread_pool();
    faults::listen();
    let start = Instant::now();
    let outcome = faults::catch(|| target.run(&input, Depth::Render));
    let milliseconds = start.elapsed().as_millis();
    match outcome {
        Ok(outcome) => {
            println!("{milliseconds} ms: {outcome}");
            ExitCode::SUCCESS
        }
        Err(panic) => {
            println!("{milliseconds} ms: panic: {panic}");
            ExitCode::FAILURE
        }
    }
}
