//! Indirect light: formula (4) at mesh points, bounce by bounce, and formula (6) over them.

mod bounce;
mod control_variate;
mod field;
mod final_gather;
mod gather;
mod guided;
mod near_light;
mod probing;
mod shifted_faces;
mod spots;
mod transfers;

pub(crate) use bounce::POINTS_AT_ONCE;
pub(crate) use control_variate::{GatherPaths, GoOn};
pub(crate) use field::{IndirectField, IndirectReading, further_bounces};
pub(crate) use gather::{GatherRays, sphere_directions};
pub(crate) use near_light::{NearPoints, NearRays};
pub(crate) use probing::Marked;
pub(crate) use transfers::PendingLight;
