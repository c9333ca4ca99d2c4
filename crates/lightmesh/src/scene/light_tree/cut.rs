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
    /// The nodes that stand for all lights at some receivers, in the order of their luminaires' blocks: the root of the sum of
    /// their squared errors is at most the part `error` of the light that arrives. Bounds are rigorous one by one; they
    /// are added as if the errors were independent of each other, which is empirical (docs/many-lights.md has what came of it):
    /// as plain numbers they sum up to √n times as much, n the size of the cut. Single lights have no error: with `error`
    /// 0 the cut is all lights that reach the receivers.
    ///
    /// Nodes whose squared error is more than their share, the n-th part of what is allowed, are replaced by their
    /// children, until the sum fits. While the front grows shares shrink: none is refined that a cut with the least
    /// largest error would have kept.
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
            let (mut squares, mut arriving) = (0.0, 0.0);
            for (_, bound) in front.iter() {
                squares += f64::from(bound.error) * f64::from(bound.error);
                arriving += f64::from(bound.arriving);
            }
            let allowed = (f64::from(error) * arriving).powi(2);
            if squares <= allowed {
                break;
            }
            let share = (allowed / front.len() as f64).sqrt() as f32;
            next.clear();
            let mut refined = false;
            for &entry in front.iter() {
                if entry.1.error <= share {
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
