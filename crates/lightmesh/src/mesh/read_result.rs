//! How a reader finds the corners that are visible, and what becomes of a read.

use glam::Vec4;

use super::corners::ByCorner;

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
