//! The threads of a program.

use std::thread::available_parallelism;

use anyhow::anyhow;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::exit::Failure;

/// The variable that says how many threads there are where nobody else does.
const VARIABLE: &str = "RAYON_NUM_THREADS";
/// Threads for each core beyond which more are of no use, and take memory each.
const MOST_PER_CORE: usize = 4;
/// So many threads may always be asked for.
const ALWAYS: usize = 64;
/// The stack of a thread, bytes: as large as that of a main thread, since whole commands run on one.
const STACK_BYTES: usize = 8 << 20;

/// How many threads work, and why they are fewer than were asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Threads {
    /// At least 1.
    pub count: usize,
    /// One sentence; `None` if as many work as were asked for.
    pub warning: Option<String>,
}

impl Threads {
    /// Returns as many threads as were asked for, by an option, or else by the environment variable
    /// `RAYON_NUM_THREADS`; one for each core if nobody asks. There are at most four for each core, or 64 where that is
    /// more.
    pub fn new(asked: Option<usize>) -> Self {
        let cores = available_parallelism().map_or(1, usize::from);
        let variable = std::env::var(VARIABLE).ok();
        Self::of(asked, variable.as_deref(), cores)
    }

    fn of(asked: Option<usize>, variable: Option<&str>, cores: usize) -> Self {
        // A number that does not fit is a large one.
        let digits = |text: &&str| !text.is_empty() && text.bytes().all(|c| c.is_ascii_digit());
        let variable = variable.map(str::trim).filter(digits).map(|text| text.parse().unwrap_or(usize::MAX));
        let variable = variable.filter(|&count| count > 0);
        let wanted = asked.or(variable).unwrap_or(cores).max(1);
        let most = ALWAYS.max(MOST_PER_CORE * cores);
        let warning = (wanted > most).then(|| {
            let who = if asked.is_some() { "threads" } else { VARIABLE };
            format!("{who}: {most} threads work instead of {wanted}: this machine has {cores} cores")
        });
        Self { count: wanted.min(most), warning }
    }

    /// Starts them.
    ///
    /// # Errors
    /// A sentence, if the system lets us have no more threads.
    pub fn start(&self) -> Result<ThreadPool, String> {
        let pool = ThreadPoolBuilder::new().num_threads(self.count).stack_size(STACK_BYTES).build();
        pool.map_err(|error| format!("threads: {} threads cannot be started: {error}; ask for fewer", self.count))
    }
}

/// Starts the threads of a command; a warning goes to `warn`.
pub(crate) fn start(asked: Option<u32>, warn: impl Fn(&str)) -> Result<ThreadPool, Failure> {
    let threads = Threads::new(asked.map(|count| count as usize));
    threads.warning.iter().for_each(|warning| warn(warning));
    threads.start().map_err(|what| Failure::Work(anyhow!(what)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_option_counts_before_the_variable_and_the_cores() {
        let count = |asked, variable, cores| Threads::of(asked, variable, cores).count;
        assert_eq!(count(Some(3), Some("5"), 2), 3);
        assert_eq!(count(None, Some("5"), 2), 5);
        assert_eq!(count(None, None, 2), 2);
        for nonsense in ["0", "", "many", "-3", "1.5"] {
            assert_eq!(count(None, Some(nonsense), 7), 7, "{nonsense}");
        }
    }

    #[test]
    fn too_many_are_cut_down_with_a_warning() {
        for (asked, variable, cores, most, who) in [
            (Some(4096), None, 2, 64, "threads: 64"),
            (None, Some("100000"), 2, 64, "RAYON_NUM_THREADS: 64"),
            (None, Some("99999999999999999999999999"), 100, 400, "RAYON_NUM_THREADS: 400"),
        ] {
            let threads = Threads::of(asked, variable, cores);
            assert_eq!(threads.count, most);
            assert!(threads.warning.as_deref().is_some_and(|warning| warning.starts_with(who)), "{threads:?}");
        }
        assert_eq!(Threads::of(Some(64), None, 1), Threads { count: 64, warning: None });
    }
}
