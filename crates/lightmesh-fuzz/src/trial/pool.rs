//! The inputs that others are made from.

use std::collections::HashSet;

use fastrand::Rng;

/// Sound inputs, and those with which the reader did something that it had not done before.
#[derive(Debug)]
pub(super) struct Pool {
    seeds: Vec<Vec<u8>>,
    found: Vec<Vec<u8>>,
    outcomes: HashSet<String>,
}

/// The most inputs that are kept beside the sound ones, and the longest, bytes.
const MOST: usize = 4096;
const LONGEST: usize = 1 << 14;

impl Pool {
    pub(super) fn new(seeds: Vec<Vec<u8>>) -> Self {
        Self { seeds, found: Vec::new(), outcomes: HashSet::new() }
    }

    /// One of them: a sound one as often as not.
    pub(super) fn pick(&self, rng: &mut Rng) -> &[u8] {
        let inputs = if self.found.is_empty() || rng.bool() { &self.seeds } else { &self.found };
        &inputs[rng.usize(0..inputs.len())]
    }

    /// Keeps an input if its outcome is a new one.
    pub(super) fn add(&mut self, input: Vec<u8>, outcome: String) {
        if self.found.len() < MOST && input.len() <= LONGEST && self.outcomes.insert(outcome) {
            self.found.push(input);
        }
    }

    /// How many outcomes there were.
    pub(super) fn outcomes(&self) -> usize {
        self.outcomes.len()
    }
}
