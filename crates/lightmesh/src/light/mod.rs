//! Everything that shines: emitters, the light samples that stand for them, and the tree over these.

mod contributions;
pub(crate) mod emitters;
mod falloff;
mod light_cut;
mod mirrors;
mod pack;
mod parts;
mod punctual;
pub(crate) mod sample;
mod samples;
mod stratum;
mod tree;

pub(crate) use contributions::{BlockTerms, LightTerms, Receiver};
pub(crate) use emitters::Emitters;
pub(crate) use emitters::sphere::sample_unit_ball;
pub(crate) use light_cut::LightCut;
pub(crate) use mirrors::{PlaneMirror, plane_mirrors};
pub(crate) use parts::{PARTS, SKY, SUNS};
pub(crate) use sample::SampledLight;
pub(crate) use samples::{Directions, LANES, LightSamples, shadow_ray_to};
pub(crate) use stratum::Stratum;
pub(crate) use tree::LightTree;
pub(crate) use tree::bound::Receivers;
pub(crate) use tree::cut::{Refinement, Tolerance};
