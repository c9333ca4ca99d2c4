//! Warnings of what was left out or mended, one per kind.

use std::fmt::Display;

use crate::error::one_line;

/// Collects warnings; the same message at many places becomes one sentence with a count.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    kinds: Vec<Kind>,
}

#[derive(Debug)]
struct Kind {
    message: String,
    first_place: String,
    count: u64,
}

impl Warnings {
    /// Notes that `message` holds at `place`. There are few messages and maybe many places: keep places out of
    /// messages.
    pub(crate) fn add(&mut self, place: impl Display, message: &str) {
        self.add_many(place, message, 1);
    }

    /// [`Warnings::add`] for `count` things at one place; zero adds nothing.
    pub(crate) fn add_many(&mut self, place: impl Display, message: &str, count: u64) {
        if count == 0 {
            return;
        }
        match self.kinds.iter_mut().find(|kind| kind.message == message) {
            Some(kind) => kind.count += count,
            None => {
                let kind = Kind { message: message.to_owned(), first_place: one_line(place), count };
                self.kinds.push(kind);
            }
        }
    }

    /// Returns one sentence per message, in the order of their first appearance.
    pub(crate) fn into_sentences(self) -> Vec<String> {
        let sentence = |kind: Kind| match kind.count {
            1 => format!("{}: {}", kind.first_place, kind.message),
            n => format!("{}: {} ({n} times in the file)", kind.first_place, kind.message),
        };
        self.kinds.into_iter().map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_are_counted() {
        let mut warnings = Warnings::default();
        warnings.add("node 1", "odd");
        warnings.add("node 2", "even");
        warnings.add_many("node 3", "odd", 2);
        warnings.add_many("node 4", "never", 0);
        assert_eq!(warnings.into_sentences(), ["node 1: odd (3 times in the file)", "node 2: even"]);
    }
}
