//! Deciding before a picture is drawn: where the mesh is refined, and how many shadow rays keep an error bound.

pub(super) mod distance_levels;
pub(super) mod error_bound;
pub(super) mod pilot;
pub(super) mod refine;
