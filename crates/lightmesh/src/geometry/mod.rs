//! Nouns of space: rays, boxes, triangles' meshes, spheres and user-defined shapes.

mod aabb;
mod cone;
mod mesh;
mod ray;
mod shape;
mod sphere;

pub use aabb::Aabb;
pub(crate) use cone::Cone;
pub use mesh::TriangleMesh;
pub(crate) use ray::self_distance;
pub use ray::{Ray, offset_origin};
pub use shape::Shape;
pub use sphere::Sphere;
