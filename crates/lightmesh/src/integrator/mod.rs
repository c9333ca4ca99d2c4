//! Light at surfaces and meters: the four tracers and what they share.
//!
//! The reflection model is documented at [`Material`](crate::Material).

mod accuracy;
mod block;
mod by_light;
mod direct;
mod first_hits;
mod footprint;
mod graded;
mod lamps;
mod lights_at;
mod lit;
mod meter_paths;
mod meters;
mod passes;
mod path;
mod pilot;
mod place;
mod plan;
mod portion;
mod refine;
mod sampling;
mod surface;
mod visibility;
mod watch;
mod wave;

pub(crate) use block::MAX_LAYERS;
pub(crate) use lights_at::LightsAt;
pub(crate) use lit::{DirectLighting, LitVertices};
pub(crate) use meter_paths::measure_paths;
pub(crate) use meters::measure_waves;
pub(crate) use passes::WAVE;
pub(crate) use path::render_path;
pub(crate) use plan::Plan;
pub(crate) use portion::{demand_of_portion, plan_waves, render_portion_on};
pub(crate) use sampling::{basis, film_samples, hash, sample_cosine_hemisphere, seed_of_place};
pub(crate) use surface::{Vertex, evaluate, is_back_face, is_solid};
pub(crate) use visibility::{VisibilityScratch, visibility};
pub(crate) use watch::Watch;
pub(crate) use wave::{Lighting, render_waves};
