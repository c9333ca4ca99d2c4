//! What a ray meets: the geometry of a hit, the surface there, and what lies between two points.

mod hit_geometry;
mod meter;
mod ray_footprint;
mod surface;
pub(crate) mod transmittance;

pub use meter::Meter;
pub(crate) use surface::{
    MAX_TRANSPARENT_HITS, ShadedHit, ShadingPoint, evaluate, evaluate_footprint, is_back_face, is_opaque,
};
pub(crate) use transmittance::{VisibilityScratch, visibility};
