//! The seven methods of [`Method`](crate::Method), drawn as pictures and measured by meters.
//!
//! | method | light of a surface | where |
//! |---|---|---|
//! | `path` | paths of its own | `path.rs`, `emitter_sampling.rs`; meters: `meter_paths.rs` |
//! | `standard` | a shadow ray to every light | `wave.rs`, `lighting.rs`; meters: `meters.rs` |
//! | `auto` | by the plan of `adaptive/`: the mesh light by light, shadow, short and gather rays | as `standard` |
//! | `mesh` | read from the light mesh, by mean visibility; with an error as long as that keeps it | as `standard` |
//! | `paper` | read from the light mesh, as in the paper | as `standard` |
//! | `hybrid` | from the mesh light by light, with shadow rays where its points differ | as `standard` |
//! | `unbiased` | the mesh as control variate of shadow and gather rays | as `standard` |
//!
//! [`adapt`] decides how a picture is lit, then [`WaveFrame::draw_picture`] draws it: `wave` sends `block`s of rays,
//! `lighting` lights the points that they hit. The reflection model is documented at [`Material`](crate::Material),
//! and `interaction/scatter.rs` has the choice of where rays go on.

mod adaptive;
mod block;
mod emitter_sampling;
mod first_hits;
mod lighting;
mod meter_paths;
mod meters;
mod path;
mod path_pixels;
mod point_block;
mod points_overlay;
mod truncated_light;
mod wave;

pub(crate) use adaptive::adapt;
pub(crate) use lighting::Lighting;
pub(crate) use meter_paths::measure_paths;
pub(crate) use meters::{MeterIrradiance, measure_waves};
pub(crate) use path::{render_path, trace_pass};
pub(crate) use points_overlay::{Dots, PointCloud, paint_points};
pub(crate) use truncated_light::truncated_light;
pub(crate) use wave::{WaveFrame, WaveSink};
