//! The states of many lights: runs of lights with one state, in the order of the light tree's leaves.
//!
//! A point is evaluated with the nodes of its own cut through the tree, each of which holds an interval of leaves.
//! Neighbours in that order are neighbours in space and mostly in the same state, so that a point keeps only the leaves
//! at which the state changes, 4 B each: `leaf · 4 + state`, from leaf 0 on. Example: all of leaves 0 to 9 arrives,
//! nothing of 10 and 11, all of 12, and the others do not shine on the point: `2, 41, 50, 52`.

use std::ops::Range;

use super::super::DirectValues;
use super::super::plain_arrays::{check_length, refuse};
use super::{LightState, PointLights};

/// Leaves have numbers below this: a light takes more than 100 B, all of them more than 100 GB.
pub(crate) const MOST_LEAVES: usize = 1 << 29;

/// The runs of the points of a mesh.
#[derive(Debug)]
pub(crate) struct LightRuns {
    /// By point, where its runs end.
    ends: Vec<usize>,
    runs: Vec<u32>,
    /// Leaves of the tree.
    leaves: u32,
}

impl LightRuns {
    /// An estimate of the memory of a point, bytes. Empirical: 555 in a room of 10,000 lights at ε = 0.01.
    pub(crate) const BYTES_PER_POINT: u64 = 1024;

    /// No points, for a tree of `leaves` leaves.
    pub(super) fn new(leaves: u32) -> Self {
        Self { ends: Vec::new(), runs: Vec::new(), leaves }
    }

    /// Returns the memory of `points` points with `runs` runs in all, bytes.
    fn bytes_of(points: usize, runs: usize) -> u64 {
        (points * size_of::<usize>() + runs * size_of::<u32>()) as u64
    }

    /// Returns the memory of all points, bytes.
    pub(super) fn bytes(&self) -> u64 {
        Self::bytes_of(self.ends.len(), self.runs.len())
    }

    /// Returns the memory of all points and of new ones with `runs` runs in all, bytes.
    pub(crate) fn bytes_with(&self, points: usize, runs: usize) -> u64 {
        Self::bytes_of(self.ends.len() + points, self.runs.len() + runs)
    }

    /// Returns the runs of the point whose lights have been traced.
    pub(super) fn evaluate(lights: &PointLights<'_>) -> Vec<u32> {
        let states = lights.lanes().iter().zip(lights.visible());
        Self::pack(states.map(|(&lane, &v)| (lights.leaves(lane), LightState::of_visibility(v))))
    }

    /// Returns the runs of a point at which some intervals of leaves, ascending, have these states and the others are
    /// unknown.
    fn pack(states: impl Iterator<Item = (Range<u32>, LightState)>) -> Vec<u32> {
        // Begin a run at a leaf: drop one that would be empty, and continue one of the same state.
        let mut runs = vec![LightState::Unknown as u32];
        let mut next_leaf = 0;
        let mut begin = |leaf: u32, state: LightState| {
            let last = runs.len() - 1;
            let last_is_empty = runs[last] >> 2 == leaf;
            let continues = |run: u32| state_of(run) == state;
            if last_is_empty && last > 0 && continues(runs[last - 1]) {
                runs.pop();
            } else if last_is_empty {
                runs[last] = leaf << 2 | state as u32;
            } else if !continues(runs[last]) {
                runs.push(leaf << 2 | state as u32);
            }
        };

        // Leaves between the intervals and after the last one are unknown.
        for (leaves, state) in states {
            if leaves.start > next_leaf {
                begin(next_leaf, LightState::Unknown);
            }
            begin(leaves.start, state);
            next_leaf = leaves.end;
        }
        begin(next_leaf, LightState::Unknown);
        runs
    }

    /// Adds a point's runs.
    pub(super) fn push(&mut self, runs: &[u32]) {
        self.runs.extend_from_slice(runs);
        self.ends.push(self.runs.len());
    }

    /// Returns the runs of a point.
    fn of(&self, point: u32) -> &[u32] {
        let point = point as usize;
        let begin = if point > 0 { self.ends[point - 1] } else { 0 };
        &self.runs[begin..self.ends[point]]
    }

    /// Returns the common state of each of some intervals of leaves, ascending, at a point: unknown where they have
    /// none.
    pub(crate) fn states<'a>(
        &'a self,
        point: u32,
        intervals: impl Iterator<Item = Range<u32>> + 'a,
    ) -> impl Iterator<Item = LightState> + 'a {
        let runs = self.of(point);
        let mut run = 0;
        let ends_before = |run: usize, leaf: u32| runs.get(run + 1).is_some_and(|next| next >> 2 < leaf);
        intervals.map(move |leaves| {
            while ends_before(run, leaves.start + 1) {
                run += 1;
            }
            if ends_before(run, leaves.end) { LightState::Unknown } else { state_of(runs[run]) }
        })
    }

    /// Copies some points.
    pub(super) fn snapshot(&self, indices: impl Iterator<Item = u32>) -> DirectValues {
        let (mut ends, mut runs) = (Vec::new(), Vec::new());
        for i in indices {
            runs.extend_from_slice(self.of(i));
            ends.push(runs.len() as u64);
        }
        DirectValues::Runs { ends, runs }
    }

    /// Refuses what cannot be the runs of this number of points of this scene.
    pub(super) fn check(&self, ends: &[u64], runs: &[u32], points: usize) -> Result<(), crate::Error> {
        check_length("direct values' ends", ends.len(), &[points])?;

        // Ends must ascend to the number of runs.
        let mut begin = 0;
        let ascends = ends.iter().all(|&end| {
            let is_next = begin <= end && end <= runs.len() as u64;
            begin = end;
            is_next
        });
        if !ascends || begin != runs.len() as u64 {
            return refuse("direct values' ends", format!("do not ascend to {}, the number of runs", runs.len()));
        }

        // Each point's runs must be as they are packed.
        match (0..points).find(|&i| !are_sound(of_point(ends, runs, i), self.leaves)) {
            Some(point) => {
                refuse(format!("direct values, point {point}"), "its runs are not ascending states of lights")
            }
            None => Ok(()),
        }
    }
}

/// Returns the runs of point i of a snapshot.
pub(super) fn of_point<'a>(ends: &[u64], runs: &'a [u32], i: usize) -> &'a [u32] {
    let begin = if i > 0 { ends[i - 1] as usize } else { 0 };
    &runs[begin..ends[i] as usize]
}

/// Returns the state that holds from the run's leaf on.
fn state_of(run: u32) -> LightState {
    match run & 3 {
        1 => LightState::Occluded,
        2 => LightState::Visible,
        _ => LightState::Unknown,
    }
}

/// Returns whether these are runs as [`LightRuns::pack`] makes them, of a tree with `leaves` leaves.
fn are_sound(runs: &[u32], leaves: u32) -> bool {
    let states = runs.iter().all(|&run| run & 3 < 3 && run >> 2 <= leaves);
    let steps = runs.windows(2).all(|w| w[0] >> 2 < w[1] >> 2 && w[0] & 3 != w[1] & 3);
    runs.first().is_some_and(|first| first >> 2 == 0) && states && steps
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const STATES: [LightState; 3] = [LightState::Unknown, LightState::Occluded, LightState::Visible];

    #[test]
    fn packing_follows_the_example_of_the_module() {
        let [_, occluded, visible] = STATES;
        let states = [(0..4, visible), (4..10, visible), (10..12, occluded), (12..13, visible)];
        assert_eq!(LightRuns::pack(states.into_iter()), [2, 41, 50, 52]);
        assert_eq!(LightRuns::pack(std::iter::empty()), [0]);
        let unsound: [&[u32]; 6] = [&[], &[4], &[3], &[0, 8, 8], &[2, 9, 5], &[2, 54]];
        assert!(unsound.into_iter().all(|runs| !are_sound(runs, 13)));
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
            /// Against a table of every leaf's state, with unrelated intervals on both sides.
            #[test]
            fn states_of_intervals_follow_from_the_states_of_their_leaves(
    points in prop::collection::vec(prop::collection::vec((1..9_u32, 0..4_usize), 0..40), 1..4),
                queries in prop::collection::vec((1..12_u32, prop::bool::ANY), 0..40),
            ) {
                let mut all = LightRuns::new(600);
                let mut tables = Vec::new();
                let mut packed = Vec::new();
                for point in &points {
                    let steps: Vec<u32> = point.iter().map(|(step, _)| *step).collect();
                    // Every fourth interval is not in the cut.
                    let cut = intervals(&steps).into_iter().zip(point).filter(|(_, (_, state))| *state < 3);
                    let cut: Vec<_> = cut.map(|(leaves, (_, state))| (leaves, STATES[*state])).collect();
                    let mut table = [LightState::Unknown; 600];
                    for (leaves, state) in &cut {
                        table[leaves.start as usize..leaves.end as usize].fill(*state);
                    }
                    let runs = LightRuns::pack(cut.into_iter());
                    prop_assert!(runs.windows(2).all(|w| w[0] >> 2 < w[1] >> 2 && w[0] & 3 != w[1] & 3), "{:?}", runs);
                    all.push(&runs);
                    tables.push(table);
                    packed.push(runs);
                }
                let none = LightRuns::new(600);
                prop_assert!(packed.iter().all(|runs| are_sound(runs, 600)));
                prop_assert_eq!(all.bytes(), none.bytes_with(packed.len(), packed.iter().map(Vec::len).sum()));
                let steps: Vec<u32> = queries.iter().map(|(step, _)| *step).collect();
                let queries: Vec<_> =
                    intervals(&steps).into_iter().zip(&queries).filter(|(_, q)| q.1).map(|(leaves, _)| leaves).collect();
                for (point, table) in tables.iter().enumerate() {
                    let states: Vec<_> = all.states(point as u32, queries.iter().cloned()).collect();
                    let expected = queries.iter().map(|leaves| {
                        let states = &table[leaves.start as usize..leaves.end as usize];
                        if states.iter().all(|state| *state == states[0]) { states[0] } else { LightState::Unknown }
                    });
                    prop_assert_eq!(states, expected.collect::<Vec<_>>());
                }
            }
        }
}
