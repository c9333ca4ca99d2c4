//! The points that some waves of a picture read, and filling points of the direct mesh.

use std::time::Instant;

use super::partial_image::WaveRequest;
use super::waves::request_waves;
use crate::film::RenderClock;
use crate::light_mesh::take_requests;
use crate::mesh::{BrickMask, Marks, PointRequests, requests};
use crate::progress::Reporter;
use crate::{Camera, Error, LightMesh, Progress, RayCounts, RenderOptions, Scene, Stage};

/// Finds the mesh points that the samples of some waves read and that are empty; none for the methods without a mesh.
/// Where meshes have finer levels, ask again when these points are filled, [`LightMesh::level_count`] times in all.
///
/// # Errors
/// As [`render_waves`](super::render_waves).
pub fn requested_points(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    mesh: &mut LightMesh,
    request: WaveRequest<'_>,
    progress: &dyn Progress,
) -> Result<PointRequests, Error> {
    if !options.method.has_mesh() {
        return Ok(PointRequests::default());
    }
    request.prepared.check(mesh)?;
    mesh.check_compatible(options)?;
    let plan = request.prepared.plan;
    let mut film = request.film(scene, camera, options)?;
    let mut clock = RenderClock::new(progress, None, Instant::now(), None);
    let marks = request_waves(scene, &mut film, options, mesh, plan, &mut clock)?;
    Ok(take_requests(marks))
}

/// Fills points of the direct mesh, except those that it has already. Returns the rays that it took.
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
    let mut marks = Marks::default();
    for some in bricks.chunks(BRICKS_AT_ONCE) {
        // Mark the points of some bricks, and fill them.
        requests::mark(mesh.direct.points(), some, &marks)?;
        rays += mesh.direct.fill(scene, &mut marks, &reporter)?;
        reporter.add(some.iter().map(|brick| u64::from(brick.len())).sum(), 0);
        if reporter.cancelled() {
            return Err(Error::Cancelled);
        }
    }
    Ok(rays)
}

/// Bricks between two reports.
const BRICKS_AT_ONCE: usize = 64;
