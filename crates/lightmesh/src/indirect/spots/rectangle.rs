//! A rectangle in space, from whose front it is seen.

use glam::{Vec2, Vec3};

/// A rectangle.
#[derive(Clone, Copy, Debug)]
pub(in crate::indirect) struct Rectangle {
    pub center: Vec3,
    /// Unit; to its front.
    pub n: Vec3,
    /// From the centre to the middles of two sides, at right angles, metres.
    pub half: [Vec3; 2],
}

impl Rectangle {
    /// Square metres.
    pub(in crate::indirect) fn area(&self) -> f32 {
        4.0 * self.half[0].length() * self.half[1].length()
    }

    /// A place in it, by u in [0, 1)².
    pub(in crate::indirect) fn sample(&self, u: Vec2) -> Vec3 {
        self.center + self.half[0] * (2.0 * u.x - 1.0) + self.half[1] * (2.0 * u.y - 1.0)
    }

    /// The density per steradian, in a unit `direction` from `x`, of places that are evenly spread in it.
    #[inline]
    pub(in crate::indirect) fn pdf(&self, x: Vec3, direction: Vec3) -> f32 {
        let cos = -self.n.dot(direction);
        let t = self.n.dot(x - self.center) / cos;
        if cos <= 1e-6 || t <= 0.0 {
            return 0.0;
        }
        let place = x + direction * t - self.center;
        let is_inside = self.half.iter().all(|half| place.dot(*half).abs() <= half.length_squared());
        if is_inside { t * t / (cos * self.area()) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;
    use crate::indirect::gather::sphere_directions;

    const RECTANGLE: Rectangle = Rectangle {
        center: Vec3::new(1.0, 0.0, -0.5),
        n: Vec3::Y,
        half: [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.4, 0.0, -0.3)],
    };

    #[test]
    fn the_density_integrates_to_one() {
        let n = 1 << 18;
        let x = Vec3::new(0.2, 1.0, 0.3);
        let sum: f32 = sphere_directions(n).into_iter().map(|d| RECTANGLE.pdf(x, d)).sum();
        assert!((sum * 4.0 * PI / n as f32 - 1.0).abs() < 0.01, "{sum}");
    }

    #[test]
    fn all_samples_have_a_density_from_the_front() {
        for i in 0..100_u8 {
            let u = Vec2::new((f32::from(i) + 0.5) / 100.0, (f32::from(i) * 0.618 + 0.01).fract());
            let direction = |x: Vec3| (RECTANGLE.sample(u) - x).normalize();
            let (front, back) = (Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, -2.0, 0.0));
            assert!(RECTANGLE.pdf(front, direction(front)) > 0.0 && RECTANGLE.pdf(back, direction(back)) == 0.0);
        }
    }
}
