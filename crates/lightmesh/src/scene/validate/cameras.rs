//! Cameras.

use glam::DVec3;

use super::invalid;
use super::surfaces::FARTHEST;
use crate::Error;
use crate::scene::camera::{Camera, Projection};

/// The largest coordinate of a camera, metres: its rays are made in double precision.
const FARTHEST_CAMERA: f64 = 1e12;

/// Checks a camera of a scene whose world has this origin in the file's coordinates.
pub(crate) fn check_camera(camera: &Camera, origin: DVec3, object: impl Fn() -> String) -> Result<(), Error> {
    match camera.projection {
        Projection::Perspective { yfov, aspect } => {
            if !(yfov > 0.0 && yfov < std::f32::consts::PI) {
                return invalid(object(), format!("its field of view, {yfov} radians, is not between 0 and π"));
            }
            if let Some(aspect) = aspect.filter(|a| !(*a > 0.0 && a.is_finite())) {
                return invalid(object(), format!("its aspect {aspect} is not above 0"));
            }
        }
        Projection::Orthographic { xmag, ymag } => {
            if !(xmag.is_normal() && ymag.is_normal() && xmag.abs().max(ymag.abs()) <= FARTHEST) {
                let what = format!("half its view, {xmag:e} × {ymag:e} m, is 0, not finite or beyond {FARTHEST:e} m");
                return invalid(object(), what);
            }
        }
    }
    // Seen from the scene.
    let place = camera.world_from_camera.translation - origin;
    if !camera.world_from_camera.is_finite() || place.abs().max_element() > FARTHEST_CAMERA {
        let [x, y, z] = place.to_array();
        let what = format!("its place, ({x:e}, {y:e}, {z:e}) m, is not finite or beyond {FARTHEST_CAMERA:e} m");
        return invalid(object(), what);
    }
    Ok(())
}
