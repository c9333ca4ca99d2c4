//! The door for surfaces that are neither triangles nor spheres.

use std::fmt::Debug;

use glam::{Vec2, Vec3};

use super::aabb::Aabb;
use super::ray::Ray;

/// A surface of any kind that rays can be intersected with and that has normals, which is all that the method needs of
/// a surface. Implement it to add a torus, a height field or a signed-distance shape to a scene
/// ([`SceneData::shapes`](crate::scene::SceneData::shapes)); every tracer and the light mesh then treat it like the
/// rest.
///
/// Results must be pure: the same ray has the same result, from any thread.
pub trait Shape: Send + Sync + Debug {
    /// A box in world space (metres) that holds the whole surface. Read once, when the scene is built.
    fn bounds(&self) -> Aabb;

    /// The smallest t in (`ray.t_min`, `ray.t_max`) at which the ray meets the surface, or `None`.
    /// `ray.direction` need not be of unit length.
    fn intersect(&self, ray: &Ray) -> Option<f32>;

    /// The unit normal at a point that [`Shape::intersect`] found; it points out of the front side.
    fn normal(&self, point: Vec3) -> Vec3;

    /// Texture coordinates at such a point.
    fn uv(&self, point: Vec3) -> Vec2 {
        let _ = point;
        Vec2::ZERO
    }
}
