//! Tries one target in this process.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Seek, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use fastrand::Rng;

use super::choices::Choices;
use super::pool::Pool;
use super::report::{Fault, Report};
use super::{LONGEST_S, faults};
use crate::{Depth, Target, take_thread_pool};

/// The exit code where an input took too long.
pub(super) const TOO_LONG: u8 = 97;

/// The file with the input that is tried, should the process die of it.
pub(super) const CURRENT: &str = "current";

/// What takes so long is kept as the file `slowest`, milliseconds; it is no fault.
const SLOW_MS: u64 = 1000;

/// When the present input began, milliseconds after the start; 0 before the first.
static BEGAN_MS: AtomicU64 = AtomicU64::new(0);

/// Tries the first target chosen, and prints a report as the last line.
pub fn work(choices: &Choices) -> ExitCode {
    match try_target(choices.targets[0], choices) {
        Ok(report) => {
            println!("{}", report.to_line());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{}: {error}", choices.found.display());
            ExitCode::FAILURE
        }
    }
}

fn try_target(target: Target, choices: &Choices) -> io::Result<Report> {
    let folder = choices.folder(target);
    fs::create_dir_all(&folder)?;
    let mut current = File::create(folder.join(CURRENT))?;
    take_thread_pool();
    faults::listen();
    let start = Instant::now();
    std::thread::spawn(move || watch(start));

    let rng = &mut Rng::with_seed(choices.seed);
    let mut pool = Pool::new(target.seeds().into_iter().map(|seed| seed.bytes).collect());
    let mut kinds: BTreeMap<String, Fault> = BTreeMap::new();
    let mut report = Report::default();
    while report.executions < choices.executions && start.elapsed().as_secs_f64() < choices.seconds {
        // Make an input, and keep it in case that it is the last one.
        let input = target.mutate(pool.pick(rng), rng.u64(..));
        current.rewind()?;
        current.write_all(&input)?;
        current.set_len(input.len() as u64)?;

        // Say how far it is, should this one be the last.
        let began = start.elapsed();
        if began.as_secs_f64() > report.seconds + 1.0 {
            report.seconds = began.as_secs_f64();
            report.outcomes = pool.outcomes() as u64;
            report.faults = kinds.values().cloned().collect();
            println!("{}", report.to_line());
        }

        // Try it.
        BEGAN_MS.store(1 + began.as_millis() as u64, Relaxed);
        let outcome = faults::catch(|| target.run(&input, Depth::of(&input)));
        let took_ms = (start.elapsed() - began).as_millis() as u64;
        if took_ms > report.slowest_ms {
            report.slowest_ms = took_ms;
            if took_ms >= SLOW_MS {
                fs::write(folder.join("slowest"), &input)?;
            }
        }
        report.executions += 1;
        match outcome {
            Ok(outcome) => pool.add(input, outcome),
            Err(panic) => {
                let fault = kinds.entry(faults::kind(&panic)).or_default();
                fault.count += 1;
                if fault.count == 1 {
                    let file = folder.join(format!("{:08x}", crc32fast::hash(&input)));
                    fs::write(&file, &input)?;
                    (fault.panic, fault.file) = (panic, file.display().to_string());
                }
            }
        }
    }
    fs::remove_file(folder.join(CURRENT))?;
    report.seconds = start.elapsed().as_secs_f64();
    report.outcomes = pool.outcomes() as u64;
    report.faults = kinds.into_values().collect();
    Ok(report)
}

/// Ends the process where an input takes too long: there is no other way to stop it.
fn watch(start: Instant) {
    loop {
        std::thread::sleep(Duration::from_millis(500));
        let began = BEGAN_MS.load(Relaxed);
        if began > 0 && start.elapsed().as_millis() as u64 > began + 1000 * LONGEST_S {
            std::process::exit(i32::from(TOO_LONG));
        }
    }
}
