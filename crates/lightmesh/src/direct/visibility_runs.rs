//! What mesh points know of many lights: runs of lights, in the order of the light tree's leaves, of which all of the light arrives,
//! none of it, or neither is known.
//!
//! A point looks at the nodes of its own cut, of which each holds an interval of leaves. Neighbours in that order are neighbours in space and
//! mostly in the same state, so that a point keeps but the places where the state changes, 4 B each: leaf · 4 + state, from leaf 0 on.
//! A point that sees leaves 0 to 9, not 10 to 11, and 12 again, of more that do not shine on it: `2, 41, 50, 52`.

use std::ops::Range;

/// Leaves have numbers below this: a light takes more than 100 B, all of them more than 100 GB.
pub(super) const MOST_LEAVES: usize = 1 << 29;

/// What a point knows of a light: the rows of the table in `light_bits.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// Some arrives, or the light does not shine on the point.
    Unknown = 0,
    /// Nothing arrives.
    Closed = 1,
    /// All of it arrives.
    Seen = 2,
}

impl State {
    pub(crate) fn of(run: u32) -> Self {
        match run & 3 {
            1 => Self::Closed,
            2 => Self::Seen,
            _ => Self::Unknown,
        }
    }
}

/// The runs of the points of a mesh.
#[derive(Debug, Default)]
pub(crate) struct LightRuns {
    /// By point, where its runs end.
    ends: Vec<usize>,
    runs: Vec<u32>,
}

impl LightRuns {
    /// Memory of a point, bytes, where a guess must do. Empirical: 555 in a room of 10,000 lights at ε = 0.01.
    pub(crate) const BYTES_PER_POINT: u64 = 1024;

    /// Memory of so many points with so many runs, bytes.
    pub(super) fn bytes_of(points: usize, runs: usize) -> u64 {
        (points * size_of::<usize>() + runs * size_of::<u32>()) as u64
    }

    /// Memory of all points, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        Self::bytes_of(self.ends.len(), self.runs.len())
    }

    /// The same with points that have such runs.
    pub(crate) fn bytes_with<'a>(&self, points: impl Iterator<Item = &'a [u32]>) -> u64 {
        let (mut count, mut runs) = (self.ends.len(), self.runs.len());
        for point in points {
            count += 1;
            runs += point.len();
        }
        Self::bytes_of(count, runs)
    }

    /// The runs of a point that knows the states of some leaves, ascending, and nothing of the others.
    pub(super) fn pack(known: impl Iterator<Item = (Range<u32>, State)>) -> Vec<u32> {
        let mut runs = vec![State::Unknown as u32];
        let mut next = 0;
        let mut begin = |leaf: u32, state: State| {
            let last = runs.len() - 1;
            let of_none = runs[last] >> 2 == leaf;
            let goes_on = |run: u32| State::of(run) == state;
            if of_none && last > 0 && goes_on(runs[last - 1]) {
                runs.pop();
            } else if of_none {
                runs[last] = leaf << 2 | state as u32;
            } else if !goes_on(runs[last]) {
                runs.push(leaf << 2 | state as u32);
            }
        };
        for (leaves, state) in known {
            if leaves.start > next {
                begin(next, State::Unknown);
            }
            begin(leaves.start, state);
            next = leaves.end;
        }
        begin(next, State::Unknown);
        runs
    }

    /// Adds a point's runs.
    pub(crate) fn push(&mut self, runs: &[u32]) {
        self.runs.extend_from_slice(runs);
        self.ends.push(self.runs.len());
    }

    /// Whether these are runs as [`LightRuns::pack`] makes them, of so many leaves.
    pub(crate) fn are_sound(runs: &[u32], leaves: u32) -> bool {
        let states = runs.iter().all(|&run| run & 3 < 3 && run >> 2 <= leaves);
        let steps = runs.windows(2).all(|w| w[0] >> 2 < w[1] >> 2 && w[0] & 3 != w[1] & 3);
        runs.first().is_some_and(|first| first >> 2 == 0) && states && steps
    }

    /// The runs of a point.
    pub(crate) fn of(&self, point: u32) -> &[u32] {
        let point = point as usize;
        let begin = if point > 0 { self.ends[point - 1] } else { 0 };
        &self.runs[begin..self.ends[point]]
    }

    /// What a point says of intervals of leaves, ascending, one after the other: their common state, unknown where they have none.
    pub(super) fn ask<'a>(
        &'a self,
        point: u32,
        intervals: impl Iterator<Item = Range<u32>> + 'a,
    ) -> impl Iterator<Item = State> + 'a {
        let runs = self.of(point);
        let mut at = 0;
        let ends_before = |at: usize, leaf: u32| runs.get(at + 1).is_some_and(|next| next >> 2 < leaf);
        intervals.map(move |leaves| {
            while ends_before(at, leaves.start + 1) {
                at += 1;
            }
            if ends_before(at, leaves.end) { State::Unknown } else { State::of(runs[at]) }
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const STATES: [State; 3] = [State::Unknown, State::Closed, State::Seen];

    #[test]
    fn runs_are_as_the_head_of_the_file_says() {
        let known = [(0..4, State::Seen), (4..10, State::Seen), (10..12, State::Closed), (12..13, State::Seen)];
        assert_eq!(LightRuns::pack(known.into_iter()), [2, 41, 50, 52]);
        assert_eq!(LightRuns::pack(std::iter::empty()), [0]);
        let unsound: [&[u32]; 6] = [&[], &[4], &[3], &[0, 8, 8], &[2, 9, 5], &[2, 54]];
        assert!(unsound.into_iter().all(|runs| !LightRuns::are_sound(runs, 13)));
    }

    /// Intervals between ascending leaves.
    fn intervals(steps: &[u32]) -> Vec<Range<u32>> {
        let ends = steps.iter().scan(0, |end, step| {
            let begin = *end;
            *end += step;
            Some(begin..*end)
        });
        ends.collect()
    }

    proptest! {
        /// Against a table of every leaf's state, for intervals of both sides that have nothing to do with each other.
        #[test]
        fn asking_is_as_good_as_knowing_every_leaf(
            points in prop::collection::vec(prop::collection::vec((1..9_u32, 0..4_usize), 0..40), 1..4),
            asked in prop::collection::vec((1..12_u32, prop::bool::ANY), 0..40),
        ) {
            let mut all = LightRuns::default();
            let mut tables = Vec::new();
            let mut packed = Vec::new();
            for point in &points {
                let steps: Vec<u32> = point.iter().map(|known| known.0).collect();
                // Every fourth interval is not in the cut.
                let known = intervals(&steps).into_iter().zip(point).filter(|(_, known)| known.1 < 3);
                let known: Vec<_> = known.map(|(leaves, known)| (leaves, STATES[known.1])).collect();
                let mut table = [State::Unknown; 600];
                for (leaves, state) in &known {
                    table[leaves.start as usize..leaves.end as usize].fill(*state);
                }
                let runs = LightRuns::pack(known.into_iter());
                prop_assert!(runs.windows(2).all(|w| w[0] >> 2 < w[1] >> 2 && w[0] & 3 != w[1] & 3), "{:?}", runs);
                all.push(&runs);
                tables.push(table);
                packed.push(runs);
            }
            let none = LightRuns::default();
            prop_assert!(packed.iter().all(|runs| LightRuns::are_sound(runs, 600)));
            prop_assert_eq!(all.bytes(), none.bytes_with(packed.iter().map(Vec::as_slice)));
            let steps: Vec<u32> = asked.iter().map(|asked| asked.0).collect();
            let asked: Vec<_> =
                intervals(&steps).into_iter().zip(&asked).filter(|(_, a)| a.1).map(|(leaves, _)| leaves).collect();
            for (point, table) in tables.iter().enumerate() {
                let said: Vec<_> = all.ask(point as u32, asked.iter().cloned()).collect();
                let expected = asked.iter().map(|leaves| {
                    let states = &table[leaves.start as usize..leaves.end as usize];
                    if states.iter().all(|state| *state == states[0]) { states[0] } else { State::Unknown }
                });
                prop_assert_eq!(said, expected.collect::<Vec<_>>());
            }
        }
    }
}
