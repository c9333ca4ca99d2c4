//! Runs a process for each target, some at a time, and prints what they found.

use std::fs;
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;

use super::LONGEST_S;
use super::choices::Choices;
use super::report::{Fault, Report};
use super::worker::{CURRENT, TOO_LONG};
use crate::Target;

/// How often a target may end its process before it is enough.
const MOST_DEATHS: u64 = 8;

/// Tries all the targets chosen. The exit code is 1 if anything was found.
pub fn supervise(choices: &Choices) -> ExitCode {
    println!(
        "{:12} {:>11} {:>8} {:>9} {:>9} {:>7} {:>11}",
        "target", "executions", "seconds", "slowest", "outcomes", "panics", "not finite"
    );
    let waiting = Mutex::new(choices.targets.iter());
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..choices.jobs {
            scope.spawn(|| {
                while let Some(&target) = waiting.lock().ok().and_then(|mut waiting| waiting.next()) {
                    let faults = try_target(target, choices);
                    found.lock().expect("no panic").extend(faults.into_iter().map(|fault| (target, fault)));
                }
            });
        }
    });

    // What was found, after the table.
    let found = found.into_inner().expect("no panic");
    for (target, Fault { panic, count, file }) in &found {
        println!("\n{}: {count} input(s): {panic}\n    try_targets {} --input {file}", target.name(), target.name());
    }
    if found.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Tries one target, and prints its line of the table. Where an input ends the process another one goes on, with other
/// inputs.
fn try_target(target: Target, choices: &Choices) -> Vec<Fault> {
    let (mut all, mut left) = (Report::default(), choices.clone());
    for death in 0..=MOST_DEATHS {
        left.seed = choices.seed.wrapping_add(death << 32);
        let (report, fatal) = run_worker(target, &left);
        all.add(report);
        left.seconds = choices.seconds - all.seconds;
        left.executions = choices.executions.saturating_sub(all.executions);
        match fatal {
            Some(what) => all.faults.push(keep_last(target, choices, death, what)),
            None => break,
        }
        if left.seconds <= 0.0 || left.executions == 0 {
            break;
        }
    }
    let Report { executions, seconds, slowest_ms, outcomes, .. } = all;
    println!(
        "{:12} {executions:>11} {seconds:>8.1} {slowest_ms:>6} ms {outcomes:>9} {:>7} {:>11}",
        target.name(),
        all.panics(),
        all.not_finite()
    );
    all.faults
}

/// Runs a process. Returns what it has done, and what has ended it if it was no success.
fn run_worker(target: Target, choices: &Choices) -> (Report, Option<String>) {
    let arguments = [
        ("--seconds", choices.seconds.to_string()),
        ("--executions", choices.executions.to_string()),
        ("--seed", choices.seed.to_string()),
        ("--found", choices.found.display().to_string()),
    ];
    let program = std::env::current_exe().expect("the path of this program");
    let mut command = Command::new(program);
    command.args(["--worker", target.name()]).stdin(Stdio::null()).stderr(Stdio::inherit());
    command.args(arguments.iter().flat_map(|(option, value)| [*option, value]));
    let output = command.output().expect("this program, started again");
    let text = String::from_utf8_lossy(&output.stdout);
    let report = text.lines().rev().find_map(Report::from_line).unwrap_or_default();
    let fatal = match output.status.code() {
        Some(0) => None,
        Some(code) if code == i32::from(TOO_LONG) => Some(format!("took longer than {LONGEST_S} s")),
        _ => Some(format!("ended the process: {}", output.status)),
    };
    (report, fatal)
}

/// Keeps the input that a process has died of.
fn keep_last(target: Target, choices: &Choices, death: u64, panic: String) -> Fault {
    let folder = choices.folder(target);
    let (current, kept) = (folder.join(CURRENT), folder.join(format!("last_{death}")));
    // Where this fails, the file has its first name.
    let file = if fs::rename(&current, &kept).is_ok() { kept } else { current };
    Fault { panic, count: 1, file: file.display().to_string() }
}
