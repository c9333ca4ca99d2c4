//! One picture by many processes or machines: the same picture, bit for bit, as [`render`](crate::render()) makes.
//!
//! A picture's samples are taken in waves, 65536 at most and always all of a pixel. Whoever has the scene, the camera
//! and the options can take any waves, in any order and as often as it likes, and gets the same:
//!
//! 1. [`prepare`] adapts lighting and meshes to the whole picture; every process does that for itself.
//! 2. [`render_waves`] makes a [`PartialImage`] of some waves. What the light mesh lacks for them is filled on the way.
//! 3. [`find_emitter_edges`] finds the pixels on edges of emitters, once all waves are there; their samples are taken
//!    anew, as waves too.
//! 4. [`merge_images`] makes the picture.
//!
//! The meshes can be filled together before step 2, so that no process fills what another one does:
//!
//! 1. [`requested_points`] finds the points that the samples of some waves read; each process does so for some waves,
//!    and the requests are [merged](PointRequests::merge).
//! 2. A [`GatherBatch`] gathers light for some points of the indirect mesh; its rays request further points of both
//!    meshes, until there are no new ones.
//! 3. [`fill_direct`] fills points of the direct mesh, brick by brick.
//! 4. Batches take the direct light where their rays end, and exchange what arrives at their points, bounce after
//!    bounce.
//!
//! Nothing of a picture depends on that: points that are missing when a picture is drawn are filled then.

mod fill;
mod gather_batch;
mod partial_image;
mod waves;

pub use fill::{fill_direct, requested_points};
pub use gather_batch::{BounceValues, GatherBatch};
pub use partial_image::{
    EmitterEdges, PartialImage, PictureSamples, Prepared, WaveRequest, find_emitter_edges, merge_images, prepare,
    render_waves, wave_count,
};

pub use crate::mesh::{BrickMask, PointRequests};
