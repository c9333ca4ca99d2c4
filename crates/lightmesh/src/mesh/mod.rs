//! The mesh without its light: where points are, which of them a surface reads, and which of those it sees.

mod ambient_cube;
mod bricks;
pub(crate) mod clearance;
pub(crate) mod corners;
pub(crate) mod lattice;
pub(crate) mod marks;
mod missing_corners;
mod points;
pub(crate) mod probe;
mod read_result;
mod reader;
mod refinement;
pub(crate) mod requests;
mod stencil;
mod usable;

pub(crate) use ambient_cube::AmbientCube;
pub(crate) use bricks::Slot;
pub(crate) use clearance::Clearance;
pub(crate) use corners::{ByCorner, ONES, corners_of};
pub(crate) use lattice::{Coordinate, FinerLevels, Levels, PointBlock};
pub use lattice::{Focus, LatticeShape};
pub(crate) use marks::Marks;
pub(crate) use points::{Address, Costs, Points};
pub(crate) use probe::{PROBE_RAYS, probe, sees};
pub(crate) use read_result::{CornerVisibility, ReadResult};
pub(crate) use reader::{CachedReader, choose};
pub use requests::{BrickMask, PointRequests};
pub(crate) use stencil::Interpolator;
pub(crate) use usable::usable_fraction;
