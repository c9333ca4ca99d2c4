//! `lightmesh reproduce`.

use std::io::IsTerminal as _;
use std::thread;
use std::time::Duration;

use anyhow::anyhow;
use indicatif::{ProgressBar, ProgressStyle};
use lightmesh_reproduce::{Error, Options, PAGE, Verdict, Watcher, reproduce};

use crate::args::ReproduceArgs;
use crate::exit::Failure;
use crate::{interrupt, terminal, threads};

/// Runs the experiments and says what became of the paper's claims.
pub(crate) fn run(args: &ReproduceArgs) -> Result<(), Failure> {
    // Listen to Ctrl-C, and start the threads.
    interrupt::listen();
    let warn = |message: &str| {
        if !args.quiet {
            terminal::warning(message);
        }
    };
    let pool = threads::start(args.threads, warn)?;

    // Run the experiments.
    let bar = Bar::new(args.quiet);
    let options = Options { quick: args.quick, force: args.force, only: args.only.clone() };
    let report = pool.install(|| reproduce(&args.output, &options, &bar));
    bar.0.finish_and_clear();
    let report = report.map_err(|error| match error {
        _ if error.is_cancelled() => Failure::Interrupted,
        Error::Unknown { .. } => Failure::Input(anyhow!("--only: {error}")),
        Error::File(_) | Error::Io { .. } => Failure::input(error),
        _ => Failure::work(error),
    })?;

    // Sum up the verdicts.
    if !args.quiet {
        let claims: Vec<_> = report.sections.iter().flat_map(|section| &section.claims).collect();
        let count = |verdict| claims.iter().filter(|claim| claim.verdict == verdict).count();
        terminal::note(&format!(
            "{}: {} experiments; of {} claims {} hold, {} hold differently, {} do not hold",
            args.output.join(PAGE).display(),
            report.sections.len(),
            claims.len(),
            count(Verdict::Holds),
            count(Verdict::Differently),
            count(Verdict::Fails)
        ));
    }
    Ok(())
}

/// Shows which experiment runs and how many are done, on stderr if it is a terminal; carries Ctrl-C to the work.
struct Bar(ProgressBar);

impl Bar {
    fn new(quiet: bool) -> Self {
        let bar = if quiet || !std::io::stderr().is_terminal() { ProgressBar::hidden() } else { ProgressBar::new(1) };
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed}\n{prefix}: {msg}") {
            bar.set_style(style);
        }
        if !bar.is_hidden() && thread::Builder::new().spawn(|| {}).is_ok() {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Self(bar)
    }
}

impl Watcher for Bar {
    fn begin(&self, title: &str, done: usize, total: usize) {
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
        self.0.set_prefix(title.to_owned());
        self.0.set_message("");
    }

    fn picture(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    fn cancelled(&self) -> bool {
        interrupt::pressed()
    }
}
