//! The progress bar.

use std::{
    fmt::Write,
    io::IsTerminal,
    sync::{Mutex, PoisonError},
    thread,
    time::{Duration, Instant},
};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use lightmesh::{Progress, Stage};

use crate::interrupt;

/// Shows the stage, how far it is, rays per second and the time left, on stderr if it is a terminal; carries Ctrl-C to
/// the work.
pub(crate) struct Bar {
    bar: ProgressBar,
    stage: Mutex<Option<(Stage, Instant)>>,
    time_limit: Option<Duration>,
}

impl Bar {
    /// Makes a bar. If stderr is no terminal or `quiet` is set, nothing is shown, and it only passes on Ctrl-C. With a
    /// time limit the bar shows how much of the time is over, instead of the samples.
    pub(crate) fn new(quiet: bool, time_limit: Option<Duration>) -> Self {
        let bar =
            if quiet || !std::io::stderr().is_terminal() { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        Self { bar, stage: Mutex::new(None), time_limit }
    }

    /// Shows work whose length is not known.
    pub(crate) fn spin(&self, what: &'static str) {
        self.bar.set_style(ProgressStyle::default_spinner());
        self.bar.set_message(what);
        // It ticks on a thread, which indicatif takes for granted.
        if !self.bar.is_hidden() && thread::Builder::new().spawn(|| {}).is_ok() {
            self.bar.enable_steady_tick(Duration::from_millis(100));
        }
    }

    /// Takes the bar away; call before anything else is written to stderr.
    pub(crate) fn clear(&self) {
        self.bar.disable_steady_tick();
        self.bar.finish_and_clear();
    }

    /// Does what writes to stderr with the bar out of the way.
    pub(crate) fn set_aside(&self, write: impl FnOnce()) {
        self.bar.suspend(write);
    }

    /// When `stage` began; changes the bar's look where it begins now.
    fn begin(&self, stage: Stage) -> Instant {
        let mut current = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        match *current {
            Some((known, since)) if known == stage => since,
            _ => {
                let now = Instant::now();
                *current = Some((stage, now));
                let template = "{prefix} [{bar:30}] {percent}% {msg}";
                let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
                self.bar.disable_steady_tick();
                self.bar.reset();
                self.bar.set_style(style.progress_chars("=> "));
                self.bar.set_message("");
                self.bar.set_prefix(match stage {
                    Stage::CoarsePreview => "sketching",
                    Stage::Render => "rendering",
                    Stage::Check => "comparing with exact light",
                    Stage::EmitterEdges => "outlines of lamps",
                    Stage::Resample => "samples where there is noise",
                    _ => "working",
                });
                now
            }
        }
    }
}

impl Progress for Bar {
    fn report(&self, stage: Stage, done: u64, total: u64, rays: u64) {
        if self.bar.is_hidden() {
            return;
        }
        let elapsed = self.begin(stage).elapsed();
        let (done, total) = match self.time_limit {
            Some(limit) if stage == Stage::Render => (elapsed.min(limit).as_millis() as u64, limit.as_millis() as u64),
            _ => (done, total),
        };
        let seconds = elapsed.as_secs_f64();
        self.bar.set_length(total);
        self.bar.set_position(done);
        if seconds > 0.1 {
            let mut message = format!("{:.2} million rays/s", rays as f64 / seconds * 1e-6);
            // Before anything is done, nobody knows how long it takes.
            if done > 0 {
                let _ = write!(message, " {:#} left", HumanDuration(self.bar.eta()));
            }
            self.bar.set_message(message);
        }
    }

    fn cancelled(&self) -> bool {
        interrupt::pressed()
    }
}
