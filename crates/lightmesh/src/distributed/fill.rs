//! A light mesh that several processes fill together, before each of them reads it.
//!
//! 1. [`demand`] says which points the samples of a picture's waves read; each process does so for some waves, and the answers are
//!    [joined](PointRequests::merge).
//! 2. Points of the indirect mesh are gathered for in groups ([`GatherBatch`]); their rays ask for further points of both meshes, until there are no
//!    new ones.
//! 3. Points of the direct mesh are filled brick by brick ([`fill_direct`]).
//! 4. Groups take the direct light where their rays end, and exchange what arrives at their points, reflection after reflection.
//!
//! Nothing of a picture depends on it: what is missing when a picture is made is filled then.

use std::ops::Range;
use std::time::Instant;

pub use super::gather_batch::{BounceValues, GatherBatch};
use super::partial_image::{PictureSamples, Prepared, check_waves, film_of};
use super::waves::demand_of_portion;
use crate::film::RenderClock;
use crate::light_mesh::take_requests;
use crate::mesh::requests;
pub use crate::mesh::{BrickMask, PointRequests};
use crate::progress::Reporter;
use crate::{Camera, Error, LightMesh, Progress, RayCounts, RenderOptions, Scene, Stage};

/// The mesh points that the samples of some waves read and that are empty. Nothing for the methods without a mesh. Where meshes have finer
/// levels, ask again when these points are there, [`LightMesh::level_count`] times in all.
///
/// # Errors
/// As [`portions::render`](super::partial_image::render()).
pub fn demand(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    (prepared, samples, waves): (&Prepared, PictureSamples<'_>, Range<u64>),
    progress: &dyn Progress,
) -> Result<PointRequests, Error> {
    if !options.method.has_mesh() {
        return Ok(PointRequests::default());
    }
    prepared.check(mesh)?;
    mesh.check_compatible(options)?;
    let mut film = film_of(scene, camera, options, samples)?;
    check_waves(&film, &waves)?;
    film.begin_portion(waves);
    let mut watch = RenderClock::new(progress, None, Instant::now(), None);
    let marks = demand_of_portion(scene, &mut film, options, (mesh, prepared.plan), &mut watch)?;
    Ok(marks.map_or_else(PointRequests::default, take_requests))
}

/// Evaluates points of the direct mesh, those that are there already left out. The rays that it took.
///
/// # Errors
/// [`Error::InvalidBricks`] for bricks that the mesh does not have, [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn fill_direct(
    scene: &Scene,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    bricks: &[BrickMask],
    progress: &dyn Progress,
) -> Result<RayCounts, Error> {
    options.validate()?;
    mesh.check_compatible(options)?;
    if !options.method.has_mesh() {
        return Ok(RayCounts::default());
    }
    let points = bricks.iter().map(|brick| u64::from(brick.len())).sum();
    let reporter = Reporter::new(progress, Stage::Fill, points);
    let mut rays = RayCounts::default();
    let mut marks = mesh.direct.marks();
    for some in bricks.chunks(BRICKS_AT_ONCE) {
        requests::mark(mesh.direct.points(), some, &marks)?;
        let took = mesh.direct.fill(scene, &mut marks)?;
        rays += took;
        reporter.add(some.iter().map(|brick| u64::from(brick.len())).sum(), took.total());
        if reporter.cancelled() {
            return Err(Error::Cancelled);
        }
    }
    Ok(rays)
}

/// Bricks between two reports.
const BRICKS_AT_ONCE: usize = 64;
