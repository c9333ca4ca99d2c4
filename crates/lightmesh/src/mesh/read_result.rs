//! How a reader finds the corners that are visible, and what becomes of a read.

use glam::Vec4;

use super::corners::ByCorner;

/// How a vertex finds out which corners are visible from it, where its cell is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CornerVisibility {
    /// It reads all that are visible: pixels are smooth.
    All,
    /// It reads one visible corner, chosen in proportion to the weights: a ray or two. For the many hits of gather
    /// rays, of which only the sum counts.
    Stochastic,
    /// It reads all in front of it, hidden or not: for shading light by light, which traces rays of its own where
    /// corners differ. Only where the usable corners are a minority of those that the vertex should read does each get
    /// a ray. `finer`: on finer levels, too, and not on the first one alone; gather rays must not do so, as the values
    /// that they bring to points must not depend on where the picture refines the mesh.
    Deferred { finer: bool },
}

/// What a reader needs of the corners that a vertex sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Needs {
    /// Their values: corners without are marked.
    Values,
    /// Only to know which they are. Of those without values it visits the packed slot instead of the index: the caller
    /// chooses among them, and marks what it needs.
    Corners,
}

/// How a reader looks at corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    pub visibility: CornerVisibility,
    pub needs: Needs,
}

/// The result of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReadResult {
    /// Every usable point of D_y was visited.
    Value,
    /// No point of D_y can be used.
    Unavailable,
    /// Points are missing; they have been marked. Those that were visited do not count.
    Pending,
}

/// The corners of a cell that are visible from a vertex.
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
    /// No corner of this level.
    pub(super) fn nothing(refined: f32) -> Self {
        Self { mask: 0, weights: [Vec4::ZERO; 2], refined }
    }
}
