//! The memory that reading a file may take.

use std::fmt::Display;

use crate::Error;
use crate::error::one_line;

/// Counts bytes before they are allocated.
///
/// Nothing is ever given back, not even for buffers that are dropped again: so the limit bounds the work too, and a
/// small file that asks for the same bytes a million times ends early.
#[derive(Debug)]
pub(crate) struct Budget {
    limit: u64,
    left: u64,
}

impl Budget {
    pub(crate) fn new(limit: u64) -> Self {
        Self { limit, left: limit }
    }

    /// Bytes not yet spent.
    pub(crate) fn left(&self) -> u64 {
        self.left
    }

    /// Spends `count` items of `item_bytes` each, or says that they do not fit.
    pub(crate) fn take(&mut self, file: &str, place: impl Display, count: u64, item_bytes: u64) -> Result<(), Error> {
        let needed = count.saturating_mul(item_bytes);
        match self.left.checked_sub(needed) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(Error::OutOfMemory {
                file: one_line(file),
                place: one_line(place),
                needed_bytes: needed,
                left_bytes: self.left,
                limit_bytes: self.limit,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spends_up_to_the_limit_and_survives_overflow() {
        let mut budget = Budget::new(100);
        assert!(budget.take("f", "x", 10, 9).is_ok());
        assert!(budget.take("f", "x", 11, 1).is_err());
        assert!(budget.take("f", "x", u64::MAX, 16).is_err());
        assert!(budget.take("f", "x", 10, 1).is_ok());
        assert_eq!(budget.left(), 0);
    }
}
