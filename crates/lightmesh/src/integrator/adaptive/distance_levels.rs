//! Density that falls with the distance from the eye: the paper's mesh is fine where the picture shows it large.
//!
//! Points nearer to the eye than a distance R give way to the second level, those of it nearer than R/2 to the third,
//! and so on: a cell keeps its size in the picture, and each level has about as many cells as the one before. Distance
//! alone decides, not what the picture shows, so that mirrored hits are served as well, and no pixel has to be lit. A
//! few rays estimate how many points the picture may fill, so that they fit into memory.
//!
//! Gather hits read the first level alone: what they read goes into the values of points, which must not depend on the
//! camera.

use rayon::prelude::*;

use super::{cells_that_fit, refinement_memory};
use crate::RenderStats;
use crate::film::Film;
use crate::integrator::lighting::Lighting;
use crate::integrator::wave::WaveFrame;

/// Pixels whose surfaces are counted, at most.
const PIXELS: u64 = 32768;

/// Refines the meshes of the frame about the eye of the picture on the film, as far as memory allows.
pub(super) fn refine_by_distance(frame: &mut WaveFrame<'_>, film: &Film, stats: &mut RenderStats) {
    let Some(metres) = frame.options.mesh.lod_distance else { return };
    let (scene, options) = (frame.scene, frame.options);
    let Lighting::Mesh { mesh, .. } = &mut frame.lighting else { return };

    // Find where the picture's surfaces are.
    let view = film.view();
    let pixels = film.draw(options.seed, 3, PIXELS);
    let visible: Vec<_> = pixels
        .par_iter()
        .filter_map(|&pixel| {
            let ray = view.pixel_ray(pixel);
            scene.bvh().closest(&ray).map(|hit| ray.at(hit.t))
        })
        .collect();
    stats.rays.primary += pixels.len() as u64;

    // Refine both meshes.
    let budget = refinement_memory(scene, options);
    let most = cells_that_fit(budget, mesh.direct.bytes_per_point());
    mesh.direct.points_mut().refine_by_distance(view.rays.eye(), metres, &visible, most);
    if let Some(field) = &mut mesh.indirect {
        let most = cells_that_fit(budget, field.bytes_per_point());
        field.points_mut().refine_by_distance(view.rays.eye(), metres, &visible, most);
    }
}
