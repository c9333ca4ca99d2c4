//! The tracers: waves of hits that the mesh or exact shadow rays light, and the path tracer.
//!
//! The reflection model is documented at [`Material`](crate::Material).

mod adaptive;
mod block;
mod emitter_sampling;
mod first_hits;
mod meter_paths;
mod meters;
mod path;
mod points_overlay;
mod wave;

pub(crate) use meter_paths::measure_paths;
pub(crate) use meters::measure_waves;
pub(crate) use path::{render_path, trace_pass};
pub(crate) use points_overlay::{Dots, paint};
pub(crate) use wave::{Lighting, Purpose, WaveFrame, render_waves};
