//! What shines, ready to be asked: emitters, their light samples and the tree over these.

mod contributions;
mod cut_at;
pub(crate) mod emitters;
pub(crate) mod sample;
mod samples;
mod tree;

pub(crate) use contributions::{BlockTerms, LightTerms, Receiver};
pub(crate) use cut_at::LightCut;
pub(crate) use emitters::Emitters;
pub(crate) use emitters::sphere::sample_ball;
pub(crate) use samples::{Directions, LANES, LightSamples};
pub(crate) use tree::LightTree;
pub(crate) use tree::bound::Receivers;
pub(crate) use tree::cut::{Refinement, Tolerance};
