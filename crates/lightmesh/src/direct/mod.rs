//! Direct light: formula (1) at mesh points, formula (3g) over them, and shadow rays where they do not suffice.

mod by_place;
pub(crate) mod encoding;
mod exact;
mod few_rays;
mod field;
mod fill;
mod per_light;
mod plan;
mod point_lights;
mod read;
mod read_lights;
mod region_cuts;
mod region_visibility;
mod shading;
mod sky_views;
mod visibility_estimate;

pub(crate) use by_place::PlacedVertices;
pub use encoding::DirectValues;
pub(crate) use exact::ExactShader;
pub(crate) use few_rays::FewRaysShader;
pub(crate) use field::DirectField;
pub(crate) use per_light::{SamplingPolicy, TrustAgreement};
pub(crate) use plan::{Indirect, LightingPlan, Shading};
pub(crate) use shading::{DirectLighting, ShadingBatch};
