//! Cuts: which nodes stand for all lights.

use super::LightTree;
use super::bound::{Bound, Receivers};
use crate::Falloff;

/// Buffers of [`LightTree::cut`], kept between calls.
#[derive(Debug, Default)]
pub(crate) struct Refinement {
    front: Vec<Entry>,
    next: Vec<Entry>,
}

/// How exact a cut is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// The error allowed, as a part of all light that arrives.
    pub error: f32,
    /// The standard deviation of the visibility of a cluster's lights from that of the one that gets the shadow ray:
    /// noise of so much times the cluster's light, which counts as an error too. 0 where no shadow rays are traced.
    pub shadows: f32,
}

/// A node of a front, with the parts of its error that add up as they are and in squares.
#[derive(Clone, Copy, Debug)]
struct Entry {
    node: u32,
    arriving: f32,
    sum: f32,
    square: f64,
}

impl LightTree {
    /// Chooses the nodes that represent all lights at some receivers, in the order of their blocks, so that their
    /// errors sum up to at most the part `error` of the light that arrives.
    ///
    /// Errors of directional lights all have one sign and are exact, not bounds: they are added as they are. Those of
    /// other lights have both signs, and their bounds are for the worst position of each light and receiver: squares
    /// are added, as if they were independent of each other. That is empirical; docs/many-lights.md has the measured
    /// errors. Added as they are, the bounds may sum up to √n times as much, n the size of the cut. Noise of shadows is
    /// independent. Single lights have neither error nor noise: with `error` 0 the cut is all lights that reach the
    /// receivers.
    ///
    /// Nodes with more than their share of what is allowed, 1/n of the sum or of its square, are replaced by their
    /// children, until the sum fits. While the front grows shares shrink: no node is refined that a cut with the least
    /// largest error would have kept.
    pub(crate) fn cut(
        &self,
        receivers: &Receivers,
        falloff: Falloff,
        tolerance: Tolerance,
        refinement: &mut Refinement,
        cut: &mut Vec<u32>,
    ) {
        let Refinement { front, next } = refinement;
        let entry = |node: u32| {
            let bound = self.bound(node, receivers, falloff);
            let noise = if self.nodes[node as usize].child == 0 { 0.0 } else { tolerance.shadows * bound.arriving };
            let (error, noise) = (bound.error, f64::from(noise));
            let (sum, error) = if node < self.first_direction { (0.0, f64::from(error)) } else { (error, 0.0) };
            (bound != Bound::NOTHING).then_some(Entry {
                node,
                arriving: bound.arriving,
                sum,
                square: error * error + noise * noise,
            })
        };
        // Begin with the roots, and replace nodes until all fit.
        front.clear();
        front.extend(self.roots.iter().filter_map(|&root| entry(root)));
        loop {
            // Share what is allowed among the nodes of each sort; directional lights come last.
            let (placed, distant) = front.split_at(front.partition_point(|entry| entry.node < self.first_direction));
            let shares = [placed, distant].map(|front| Share::of(front, tolerance.error));
            next.clear();
            let mut refined = false;
            for &kept in front.iter() {
                let share = &shares[usize::from(kept.node >= self.first_direction)];
                if kept.sum <= share.sum && kept.square <= share.square {
                    next.push(kept);
                    continue;
                }
                refined = true;
                let child = self.nodes[kept.node as usize].child;
                next.extend([child, child + 1].into_iter().filter_map(entry));
            }
            // Everything fits, up to rounding.
            if !refined {
                break;
            }
            std::mem::swap(front, next);
        }
        cut.clear();
        cut.extend(front.iter().map(|entry| entry.node));
    }
}

/// The largest sum and square that a node of a front may have; infinite where all fit.
struct Share {
    sum: f32,
    square: f64,
}

impl Share {
    /// Shares the limits Σ sum ≤ error · Σ light and √(Σ square) ≤ error · Σ light.
    fn of(front: &[Entry], error: f32) -> Self {
        let (mut sum, mut squares, mut arriving) = (0.0, 0.0, 0.0);
        for entry in front {
            sum += f64::from(entry.sum);
            squares += entry.square;
            arriving += f64::from(entry.arriving);
        }
        let (allowed, n) = (f64::from(error) * arriving, front.len() as f64);
        Self {
            sum: if sum > allowed { (allowed / n) as f32 } else { f32::INFINITY },
            square: if squares > allowed * allowed { allowed * allowed / n } else { f64::INFINITY },
        }
    }
}
