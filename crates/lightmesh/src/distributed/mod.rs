//! One picture by many processes: its waves shared out, its mesh filled together.

pub mod fill;
mod gather_batch;
pub mod partial_image;
mod waves;

pub use gather_batch::{BounceValues, GatherBatch};
