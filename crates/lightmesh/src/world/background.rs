//! The background: what camera rays see that leave the scene, where that is not the environment itself.

use glam::{Vec2, Vec3};

use crate::geometry::Ray;

/// A backdrop without an edge between floor and wall, as in a photographer's studio, with the shadow of the scene on its
/// floor. It is seen, but lights nothing, and mirrors show the environment in its place.
#[derive(Clone, Debug)]
pub(crate) struct Background {
    /// Luminance per channel straight up, at the horizon and straight down, cd/m².
    pub colors: [Vec3; 3],
    /// Luminance of a white surface in the light that belongs to it, cd/m².
    pub white_cd_m2: f32,
    /// The floor's shadow; `None`: no floor.
    pub shadow: Option<GroundShadow>,
}

/// The part of the environment's light that reaches a horizontal floor, at points of a grid.
#[derive(Clone, Debug)]
pub(crate) struct GroundShadow {
    /// Height of the floor, metres.
    pub y: f32,
    /// x and z of the grid's first point, and from each point to the next, metres.
    pub first: Vec2,
    pub step: Vec2,
    /// Points along x.
    pub columns: usize,
    /// Row by row along z, in [0, 1]; 1 beyond the grid.
    pub visible: Vec<f32>,
}

impl Background {
    /// Returns the radiance along a ray that has left the scene, cd/m².
    pub(crate) fn radiance(&self, ray: &Ray) -> Vec3 {
        let up = ray.direction.normalize().y;
        let [zenith, horizon, nadir] = self.colors;
        // Smooth at the horizon: no line there.
        let color = |end: Vec3| horizon.lerp(end, up * up * (3.0 - 2.0 * up.abs()));
        if up >= 0.0 {
            return color(zenith);
        }
        color(nadir) * self.shadow.as_ref().map_or(1.0, |shadow| shadow.seen_along(ray))
    }
}

impl GroundShadow {
    /// Returns the light at the place where a ray that goes down meets the floor; 1 where it starts below.
    fn seen_along(&self, ray: &Ray) -> f32 {
        let t = (self.y - ray.origin.y) / ray.direction.y;
        if !(t > 0.0 && t.is_finite()) {
            return 1.0;
        }
        let p = ray.at(t);
        self.at(Vec2::new(p.x, p.z))
    }

    /// Returns the light at (x, z), between four points of the grid.
    fn at(&self, p: Vec2) -> f32 {
        let rows = self.visible.len() / self.columns;
        let p = (p - self.first) / self.step;
        let last = Vec2::new((self.columns - 1) as f32, (rows - 1) as f32);
        if !(p.min_element() >= 0.0 && p.x < last.x && p.y < last.y) {
            return 1.0;
        }
        let (cell, f) = (p.floor(), p - p.floor());
        let at = |x: usize, y: usize| self.visible[(cell.y as usize + y) * self.columns + cell.x as usize + x];
        let row = |y: usize| at(0, y) + (at(1, y) - at(0, y)) * f.x;
        row(0) + (row(1) - row(0)) * f.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 3 × 2 points, half a metre apart: its corners, the middle of a cell, and 1 beyond it.
    #[test]
    fn shadows_are_interpolated_and_end_with_the_grid() {
        let shadow = GroundShadow {
            y: -1.0,
            first: Vec2::new(2.0, 3.0),
            step: Vec2::splat(0.5),
            columns: 3,
            visible: vec![0.0, 0.5, 1.0, 0.5, 0.5, 1.0],
        };
        let background = Background { colors: [Vec3::ONE; 3], white_cd_m2: 1.0, shadow: Some(shadow) };
        let down = |x: f32, z: f32| background.radiance(&Ray::new(Vec3::new(x, 4.0, z), Vec3::NEG_Y)).x;
        assert_eq!([down(2.0, 3.0), down(2.25, 3.25), down(2.75, 3.0)], [0.0, 0.375, 0.75]);
        assert_eq!([down(1.9, 3.1), down(2.1, 3.6), down(3.1, 3.1)], [1.0; 3]);
        // From below the floor, and up: no shadow.
        assert_eq!(background.radiance(&Ray::new(Vec3::new(2.0, -2.0, 3.0), Vec3::NEG_Y)), Vec3::ONE);
        assert_eq!(background.radiance(&Ray::new(Vec3::new(2.0, 0.0, 3.0), Vec3::Y)), Vec3::ONE);
    }
}
