//! Density that falls with the distance from the eye: the paper's mesh is fine where the picture shows it large.
//!
//! Points nearer to the eye than a distance R give way to the second level, those of it nearer than R/2 to the third, and so on: a
//! cell keeps its size in the picture, and each level has about as many cells as the one before. It is by distance alone, not by what
//! the picture shows, so that mirrored hits are served as well, and no pixel has to be looked at. A few rays find out how many
//! points it might take, so that memory is kept to.
//!
//! Gather hits read the first level alone: what they read goes into the values of points, which must not depend on the camera.

use rayon::prelude::*;

use super::super::wave::{Lighting, WaveFrame};
use super::refine::{MEMORY_SHARE, POINTS_PER_CELL};
use crate::RenderStats;
use crate::film::Film;

/// Pixels whose surfaces are counted, at most.
const PIXELS: u64 = 32768;

/// Refines the meshes of the frame about the eye of the picture on the film, as far as memory allows.
pub(crate) fn refine_by_distance(frame: &mut WaveFrame<'_>, film: &Film, stats: &mut RenderStats) {
    let Some(metres) = frame.options.mesh.lod_distance else { return };
    let (scene, options) = (frame.scene, frame.options);
    let Lighting::Mesh(mesh) = &mut frame.lighting else { return };
    let (rays, width, _) = film.rays_and_size();
    let pixels = film.draw(options.seed, 3, PIXELS);
    let seen: Vec<_> = pixels
        .par_iter()
        .filter_map(|pixel| {
            let ray = rays.ray((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
            scene.bvh().closest(&ray).map(|hit| ray.at(hit.t))
        })
        .collect();
    stats.rays.primary += pixels.len() as u64;
    // Of the limit, not of what is left of it: a frame must not depend on what came before.
    let budget = (MEMORY_SHARE * options.limits.max_memory as f64) as u64;
    let fit = |bytes_per_point: u64| budget / (POINTS_PER_CELL * bytes_per_point);
    let most = fit(mesh.direct.bytes_per_point());
    mesh.direct.points_mut().refine_by_distance(rays.eye(), metres, &seen, most);
    if let Some(field) = &mut mesh.indirect {
        let most = fit(field.bytes_per_point());
        field.points_mut().refine_by_distance(rays.eye(), metres, &seen, most);
    }
}
