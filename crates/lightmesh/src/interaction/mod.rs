//! What a ray meets: the geometry of a hit, the surface there, where it goes on, and how much light passes between two
//! points.

mod fresnel;
mod hit_geometry;
mod meter;
mod mirrored_lights;
#[cfg(test)]
mod offset_tests;
mod ray_footprint;
mod scatter;
mod surface;
pub(crate) mod transmittance;

pub use meter::Meter;
pub(crate) use mirrored_lights::{MirroredLights, MirroredShader};
pub(crate) use scatter::{Lobe, PathRay, SpecularLobe};
pub(crate) use surface::{ShadedHit, ShadingPoint, evaluate, evaluate_footprint, is_back_face, is_opaque};
pub(crate) use transmittance::{VisibilityScratch, visibility};
