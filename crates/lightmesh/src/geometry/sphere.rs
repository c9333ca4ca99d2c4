//! The analytic sphere.

use glam::{Vec2, Vec3};

use super::aabb::Aabb;
use super::ray::Ray;

/// A sphere in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sphere {
    /// Centre, metres.
    pub center: Vec3,
    /// Radius, metres, > 0.
    pub radius: f32,
    /// Index into [`SceneData::materials`](crate::scene::SceneData::materials).
    pub material: usize,
}

impl Sphere {
    /// The box around it.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }

    /// The smallest t in (`ray.t_min`, `ray.t_max`) at which the ray meets the surface.
    ///
    /// The discriminant is taken from the distance between centre and ray, which keeps its digits for a small sphere
    /// far away (Haines et al., "Precision improvements for ray/sphere intersection", Ray Tracing Gems, 2019, ch. 7).
    pub fn intersect(&self, ray: &Ray) -> Option<f32> {
        let f = ray.origin - self.center;
        let d = ray.direction;
        let a = d.length_squared();
        let b = -f.dot(d);
        let r2 = self.radius * self.radius;
        let closest = f + d * (b / a);
        let discriminant = r2 - closest.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let c = f.length_squared() - r2;
        let q = b + (a * discriminant).sqrt().copysign(b);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
        let inside = |t: f32| t > ray.t_min && t < ray.t_max;
        [near, far].into_iter().find(|&t| inside(t))
    }

    /// The outward unit normal at a point of the surface.
    pub fn normal(&self, point: Vec3) -> Vec3 {
        (point - self.center).normalize_or(Vec3::Y)
    }

    /// Longitude and latitude of a point of the surface, each in [0, 1]; (·, 0) is the +Y pole.
    pub fn uv(&self, point: Vec3) -> Vec2 {
        let n = self.normal(point);
        let longitude = libm::atan2f(n.x, n.z) / std::f32::consts::TAU + 0.5;
        let latitude = libm::acosf(n.y.clamp(-1.0, 1.0)) / std::f32::consts::PI;
        Vec2::new(longitude, latitude)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Sphere = Sphere { center: Vec3::new(0.0, 0.0, -5.0), radius: 1.0, material: 0 };

    /// |o + t·d − c| = r: t = 4 and 6 for a unit sphere five metres ahead.
    #[test]
    fn meets_the_near_then_the_far_side() {
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_Z);
        assert_eq!(UNIT.intersect(&ray), Some(4.0));
        assert_eq!(UNIT.intersect(&Ray { t_min: 4.5, ..ray }), Some(6.0));
        assert_eq!(UNIT.intersect(&Ray { t_max: 3.5, ..ray }), None);
        assert_eq!(UNIT.intersect(&Ray::new(Vec3::new(1.01, 0.0, 0.0), Vec3::NEG_Z)), None);
    }

    #[test]
    fn t_counts_in_lengths_of_the_direction() {
        assert_eq!(UNIT.intersect(&Ray::new(Vec3::ZERO, Vec3::new(0.0, 0.0, -2.0))), Some(2.0));
    }
}
