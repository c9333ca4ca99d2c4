//! Cuts: which nodes stand for all lights.

use super::LightTree;
use super::bound::{Bound, Receivers};
use crate::Falloff;

/// Buffers of [`LightTree::cut`], kept between calls.
#[derive(Debug, Default)]
pub(crate) struct Refinement {
    front: Vec<(u32, Bound)>,
    next: Vec<(u32, Bound)>,
}

impl LightTree {
    /// The nodes that stand for all lights at some receivers, in the order of their luminaires' blocks: their errors sum up to at most
    /// the part `error` of the light that arrives.
    ///
    /// Errors of directions all have one sign, and their bounds are what they are, not what they may be: they are added as they are.
    /// Those of other lights are of both signs, and their bounds are for the worst place of each light and receiver: squares are
    /// added, as if they were independent of each other. That is empirical; docs/many-lights.md has what came of it. As plain
    /// numbers the bounds may sum up to √n times as much, n the size of the cut. Single lights have no error: with `error` 0 the cut
    /// is all lights that reach the receivers.
    ///
    /// Nodes whose error is more than their share of what is allowed, 1/n of the sum or of its square, are replaced by their
    /// children, until the sum fits. While the front grows shares shrink: none is refined that a cut with the least largest error
    /// would have kept.
    pub(crate) fn cut(
        &self,
        receivers: &Receivers,
        falloff: Falloff,
        error: f32,
        refinement: &mut Refinement,
        cut: &mut Vec<u32>,
    ) {
        let Refinement { front, next } = refinement;
        front.clear();
        let bounded = |node: u32| (node, self.bound(node, receivers, falloff));
        front.extend(self.roots.iter().map(|&root| bounded(root)).filter(|entry| entry.1 != Bound::NOTHING));
        loop {
            // Directions come last.
            let directions = front.partition_point(|entry| entry.0 < self.first_direction);
            let (placed, distant) = front.split_at(directions);
            let shares = [share_of_squares(placed, error), share_of_sum(distant, error)];
            if shares == [None; 2] {
                break;
            }
            next.clear();
            let mut refined = false;
            for &entry in front.iter() {
                let share = shares[usize::from(entry.0 >= self.first_direction)];
                if share.is_none_or(|share| entry.1.error <= share) {
                    next.push(entry);
                    continue;
                }
                refined = true;
                let child = self.nodes[entry.0 as usize].child;
                next.extend([child, child + 1].map(bounded).into_iter().filter(|entry| entry.1 != Bound::NOTHING));
            }
            std::mem::swap(front, next);
            // The sum misses by a rounding.
            if !refined {
                break;
            }
        }
        cut.clear();
        cut.extend(front.iter().map(|entry| entry.0));
    }
}

/// How much error each node of a front may have; `None` where they all fit: √(Σ e²) ≤ error · Σ light.
fn share_of_squares(front: &[(u32, Bound)], error: f32) -> Option<f32> {
    let (squares, allowed) = sums(front, error, |e| e * e);
    (squares > allowed * allowed).then(|| (allowed / (front.len() as f64).sqrt()) as f32)
}

/// The same for Σ e ≤ error · Σ light.
fn share_of_sum(front: &[(u32, Bound)], error: f32) -> Option<f32> {
    let (sum, allowed) = sums(front, error, |e| e);
    (sum > allowed).then(|| (allowed / front.len() as f64) as f32)
}

/// Σ f(error) of a front, and what is allowed.
fn sums(front: &[(u32, Bound)], error: f32, f: impl Fn(f64) -> f64) -> (f64, f64) {
    let (mut errors, mut arriving) = (0.0, 0.0);
    for (_, bound) in front {
        errors += f(f64::from(bound.error));
        arriving += f64::from(bound.arriving);
    }
    (errors, f64::from(error) * arriving)
}
