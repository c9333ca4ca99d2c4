//! The arguments of the program.

use std::path::PathBuf;

use crate::Target;

/// What was asked for.
#[derive(Clone, Debug)]
pub struct Choices {
    /// `NAME...`: the targets; all where none is named.
    pub targets: Vec<Target>,
    /// `--seconds N`: how long each is tried; default 10.
    pub seconds: f64,
    /// `--executions N`: after how many inputs it is enough.
    pub executions: u64,
    /// `--seed N`: another seed tries other inputs; default 1.
    pub seed: u64,
    /// `--jobs N`: processes at a time; default 2.
    pub jobs: usize,
    /// `--found DIR`: where inputs are written that something is wrong with; default
    /// `target/fuzz-found` of the repository.
    pub found: PathBuf,
    /// `--input FILE`: try this one alone.
    pub input: Option<PathBuf>,
    /// `--worker`: what [`supervise`](super::supervise) gives its processes.
    pub is_worker: bool,
}

impl Choices {
    /// Reads arguments.
    ///
    /// # Errors
    /// A sentence about the first that is wrong.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut choices = Self {
            targets: Vec::new(),
            seconds: 10.0,
            executions: u64::MAX,
            seed: 1,
            jobs: 2,
            found: concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/fuzz-found").into(),
            input: None,
            is_worker: false,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
            match argument.as_str() {
                "--seconds" => choices.seconds = number(&argument, &value()?)?,
                "--executions" => choices.executions = number(&argument, &value()?)?,
                "--seed" => choices.seed = number(&argument, &value()?)?,
                "--jobs" => choices.jobs = number::<usize>(&argument, &value()?)?.max(1),
                "--found" => choices.found = value()?.into(),
                "--input" => choices.input = Some(value()?.into()),
                "--worker" => choices.is_worker = true,
                name => match Target::named(name) {
                    Some(target) => choices.targets.push(target),
                    None => {
                        let names = Target::ALL.map(Target::name).join(", ");
                        return Err(format!("{name:?} is neither an option nor a target; these are {names}"));
                    }
                },
            }
        }
        if choices.targets.is_empty() {
            choices.targets = Target::ALL.into();
        }
        if choices.input.is_some() && choices.targets.len() != 1 {
            return Err("--input needs the name of its target, and one only".to_owned());
        }
        Ok(choices)
    }

    /// Where this target's inputs are written.
    pub(super) fn folder(&self, target: Target) -> PathBuf {
        self.found.join(target.name())
    }
}

fn number<T: std::str::FromStr>(option: &str, text: &str) -> Result<T, String> {
    text.parse().map_err(|_| format!("{option} needs a number, not {text:?}"))
}
