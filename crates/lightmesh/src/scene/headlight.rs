//! A lamp at the camera, for scenes that have none.

use glam::Vec3;

use super::{Camera, Light};
use crate::geometry::Aabb;

/// Luminance that a white, diffuse surface at the headlight's nominal distance gets, cd/m²: that of a lit room.
const LUMINANCE: f32 = 100.0;

/// A white point light at the camera's eye, so that a scene without lights and without emission is not black.
///
/// A white Lambertian surface that faces the lamp from the distance of the middle of `bounds` gets a luminance of
/// 100 cd/m²: E = π · 100 lux there, and the intensity is E · distance². For an eye inside the scene the distance is taken
/// as at least a quarter of the box's diagonal. An automatic exposure makes the rest of it; the value only keeps
/// unexposed pictures of such scenes alike.
pub fn headlight(camera: &Camera, bounds: &Aabb) -> Light {
    let eye = Vec3::from(camera.world_from_camera.translation);
    let distance = eye.distance(bounds.center()).max(0.25 * bounds.size().length()).max(1e-6);
    let intensity = std::f32::consts::PI * LUMINANCE * distance * distance;
    Light::Point { position: eye, intensity_cd: Vec3::splat(intensity), range: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L = albedo/π · I / d² = 100 at the box's centre.
    #[test]
    fn lights_the_middle_of_the_scene_to_its_nominal_luminance() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, 4.0), max: Vec3::new(9.0, 3.0, 6.0) };
        let camera = Camera::framing(&bounds);
        let Light::Point { position, intensity_cd, range: None } = headlight(&camera, &bounds) else {
            panic!("a point light without range");
        };
        let d2 = position.distance_squared(bounds.center());
        let luminance = intensity_cd.x / std::f32::consts::PI / d2;
        assert!((luminance - 100.0).abs() < 1e-2, "{luminance}");
    }

    #[test]
    fn an_eye_in_the_middle_still_gives_light() {
        let bounds = Aabb { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
        let camera = Camera::look_at(Vec3::ZERO, Vec3::X, 1.0);
        let Light::Point { intensity_cd, .. } = headlight(&camera, &bounds) else { panic!("a point light") };
        assert!(intensity_cd.x > 100.0);
    }
}
