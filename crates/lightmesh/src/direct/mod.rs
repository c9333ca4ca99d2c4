//! Direct light: formula (1) at mesh points, formula (3g) over them, and shadow rays where they do not suffice.

mod evaluate;
mod exact;
mod field;
mod fill;
mod per_light;
mod plan;
mod read;
mod read_lights;
mod region_cuts;
mod region_visibility;
mod shading;
mod visibility_bits;
mod visibility_estimate;
mod visibility_runs;

pub(crate) use exact::Scratch;
pub(crate) use field::{DirectEncoding, DirectField};
pub(crate) use per_light::{SamplingPolicy, TrustAgreement};
pub(crate) use plan::{Indirect, LightingPlan, Shading};
pub(crate) use shading::{DirectLighting, ShadingBatch};
pub(crate) use visibility_runs::LightRuns;
