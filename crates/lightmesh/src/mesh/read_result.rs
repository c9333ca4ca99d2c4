//! What a reader is asked for, and what becomes of it: sight, outcomes, corners that are seen and corners that are known.

use glam::{Vec3, Vec4};

use super::corners::{ByCorner, set_bits};

/// How a vertex finds out which corners it sees, where its cell is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CornerVisibility {
    /// All that it sees: what a pixel shows is smooth.
    All,
    /// One corner, chosen in proportion to the weights among those it sees: a ray or two. For the many hits of gather rays, of
    /// which only the sum counts.
    Stochastic,
    /// All in front of it, hidden or not: for those who ask what corners know of each light, and look themselves where corners
    /// disagree. Only where no more is left than a lesser part of what a vertex wants to read, each is looked at. On finer levels
    /// too, or on the first one alone: what gather rays bring to points must not depend on where the picture needs more of them.
    Deferred { finer: bool },
}

/// What became of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReadResult {
    /// Every point of the neighbourhood that counts was handed out.
    Value,
    /// No point of the neighbourhood can be used.
    Unavailable,
    /// Points are missing; they have been marked. What was handed out does not count.
    Pending,
}

/// Corners that a vertex sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibleCorners {
    /// A bit each; 0 only where the next level takes over.
    pub mask: u8,
    /// φ4 by corner; 0 for the others.
    pub weights: ByCorner,
    /// φ4 of the corners that the next level takes over, together.
    pub refined: f32,
}

impl VisibleCorners {
    pub(super) fn nothing(refined: f32) -> Self {
        Self { mask: 0, weights: [Vec4::ZERO; 2], refined }
    }
}

/// Which corners a field's reader knows the light of: for one normal, as long as the cell stays.
#[derive(Debug, Default)]
pub(crate) struct CornerValues {
    n: Vec3,
    visits: u64,
    corners: u8,
}

impl CornerValues {
    /// Whether the last vertex had this normal in the same visit of a cell, so that it is worth to keep what corners know.
    #[inline(always)]
    pub(crate) fn continues(&mut self, n: Vec3, visits: u64) -> bool {
        let goes_on = self.n == n && self.visits == visits;
        if !goes_on {
            *self = Self { n, visits, corners: 0 };
        }
        goes_on
    }

    /// Whether no corner is known yet.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.corners == 0
    }

    /// The corners of `mask` that are not known yet; from now on they are.
    #[inline(always)]
    pub(crate) fn add(&mut self, mask: u8) -> impl Iterator<Item = usize> + use<> {
        let missing = mask & !self.corners;
        self.corners |= mask;
        set_bits(missing)
    }
}
