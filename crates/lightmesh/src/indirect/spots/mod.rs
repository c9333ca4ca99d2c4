//! Bright spots: what shines or is lit strongly and is small, to which mesh points shoot rays of their own.

mod bright_spots;
mod directions;
mod rectangle;
mod search;
mod sun_patches;

pub(super) use bright_spots::{BrightSpot, BrightSpots, SpotShape};
pub(super) use directions::SpotDirections;
