//! The part of a surface's textures that a cone covers.

use glam::{Vec2, Vec3};

use super::hit_geometry::{PlacedTriangle, SurfaceInteraction};
use crate::bvh::{Hit, Target};
use crate::geometry::{Cone, Ray, Sphere};
use crate::scene::Footprint;
use crate::world::Scene;

/// A cone that grazes a surface is taken to meet it at this cosine at least: 32 times as long as wide. Longer
/// footprints are looked up sparsely anyway; this keeps them on the surface they belong to where it curves away.
const LEAST_COS: f32 = 1.0 / 32.0;

/// The footprints, in both sets of texture coordinates, of the cone about a ray of unit direction that hit a surface.
/// User-defined shapes have none, as they do not give the gradients of their coordinates.
pub(super) fn footprints(
    scene: &Scene,
    ray: &Ray,
    cone: Cone,
    hit: &Hit,
    interaction: &SurfaceInteraction<'_>,
) -> [Footprint; 2] {
    let material = &scene.data().materials[interaction.material];
    if !material.has_averaged_textures() || cone == Cone::POINT {
        return [Footprint::POINT; 2];
    }
    let section = Section::new(ray.direction, interaction.ng, cone, hit.t);
    match (hit.target, &interaction.triangle) {
        (_, Some(triangle)) => {
            let section = section.footprint(barycentric_gradients(triangle));
            [0, 1].map(|set| match triangle.mesh.uvs[set].as_slice() {
                [] => Footprint::POINT,
                uvs => section.mapped(triangle.corners.map(|i| uvs[i])),
            })
        }
        (Target::Sphere(i), None) => {
            [section.footprint(sphere_gradients(&scene.data().spheres[i as usize], interaction.position)); 2]
        }
        _ => [Footprint::POINT; 2],
    }
}

/// Where a cone meets a plane: vectors in the plane that spread as the section does.
struct Section {
    /// What two perpendicular diameters of the cone meet. Which two does not matter to how the section spreads.
    diameters: (Vec3, Vec3),
    /// From the point that the ray hits to the middle.
    offset: Vec3,
}

/// The gradients of two texture coordinates, per metre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Gradients {
    u: Vec3,
    v: Vec3,
}

impl Section {
    /// The section with a plane of unit normal `n`, so many metres along the unit direction `d`.
    pub(crate) fn new(d: Vec3, n: Vec3, cone: Cone, distance: f32) -> Self {
        let cos = n.dot(d);
        let along_d = d * (1.0 / cos.abs().max(LEAST_COS).copysign(cos));
        // Moved along d, what is beside the ray meets the plane.
        let meet = |beside: Vec3| beside - along_d * beside.dot(n);
        let width = cone.width_at(distance);
        let (x, y) = d.any_orthonormal_pair();
        Self { diameters: (meet(x * width), meet(y * width)), offset: meet(cone.offset * width) }
    }

    /// The footprint in the coordinates with these gradients.
    fn footprint(&self, gradients: Gradients) -> Footprint {
        let along = |vector: Vec3| Vec2::new(vector.dot(gradients.u), vector.dot(gradients.v));
        Footprint { sides: [along(self.diameters.0), along(self.diameters.1)], offset: along(self.offset) }
    }
}

/// The gradients of a triangle's second and third barycentric coordinate; 0 where it has no area.
fn barycentric_gradients(triangle: &PlacedTriangle<'_>) -> Gradients {
    let PlacedTriangle { edges: [e1, e2], normal, .. } = *triangle;
    let area2 = normal.length_squared();
    if area2 < f32::MIN_POSITIVE {
        return Gradients::default();
    }
    let per_area = normal * (1.0 / area2);
    Gradients { u: e2.cross(per_area), v: per_area.cross(e1) }
}

/// The gradients of [`Sphere::uv`]: longitude over 2π towards the east, one turn per circle of latitude, and latitude
/// over π towards the south; 0 at a pole, where all longitudes meet.
fn sphere_gradients(sphere: &Sphere, position: Vec3) -> Gradients {
    use std::f32::consts::{PI, TAU};
    let n = sphere.normal(position);
    let parallel = (n.x * n.x + n.z * n.z).sqrt();
    let Some(east) = Vec3::new(n.z, 0.0, -n.x).try_normalize() else { return Gradients::default() };
    Gradients { u: east / (TAU * sphere.radius * parallel), v: east.cross(n) / (PI * sphere.radius) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TriangleMesh;

    /// The section of a cone whose axis is the ray: what a ray beside it, by the cone's width, meets of the plane.
    #[test]
    fn sections_are_what_rays_beside_meet() {
        let n = Vec3::new(0.2, 0.9, -0.4).normalize();
        for d in [Vec3::new(0.5, -0.7, 0.3), Vec3::new(0.9, -0.5, -0.1), -n, n] {
            let d = d.normalize();
            for aside in [d.any_orthonormal_vector(), d.cross(d.any_orthonormal_vector()) * 0.3] {
                let cone = Cone { width: 0.01, spread: 0.02, offset: aside };
                let section = Section::new(d, n, cone, 2.0);
                // The point 0.05 · aside beside the ray, moved along d into the plane.
                let beside = aside * 0.05;
                let met = beside - d * (beside.dot(n) / d.dot(n));
                assert!((section.offset - met).length() < 1e-6, "{} {met}", section.offset);
                // A parallelogram as large as the square of the cone's width, seen at an angle.
                let area = section.diameters.0.cross(section.diameters.1);
                assert!((area.length() * n.dot(d).abs() - 0.0025).abs() < 1e-6 && area.cross(n).length() < 1e-6);
            }
        }
    }

    /// Texture coordinates that are linear functions of the position: their gradients are those of the functions.
    #[test]
    fn gradients_of_linear_coordinates() {
        let mesh = TriangleMesh::default();
        let placed = |p: [Vec3; 3]| {
            let edges = [p[1] - p[0], p[2] - p[0]];
            PlacedTriangle { mesh: &mesh, corners: [0, 1, 2], edges, normal: edges[0].cross(edges[1]) }
        };
        let p = [Vec3::new(0.1, -0.2, 0.4), Vec3::new(-2.0, 0.1, 0.3), Vec3::new(-0.6, 0.5, -1.2)];
        let (u, v) = (Vec3::new(0.4, -0.2, 0.7), Vec3::new(-1.0, 0.3, 0.2));
        let coordinates = |p: Vec3| Vec2::new(p.dot(u), p.dot(v));
        let triangle = placed(p);
        let [e1, e2] = triangle.edges;
        let section = Section { diameters: (e1 * 0.3, e2 - e1), offset: e2 * 0.1 };
        let found = section.footprint(barycentric_gradients(&triangle)).mapped(p.map(coordinates));
        let expected = Footprint {
            sides: [coordinates(section.diameters.0), coordinates(section.diameters.1)],
            offset: coordinates(section.offset),
        };
        for (found, expected) in found.sides.into_iter().zip(expected.sides) {
            assert!((found - expected).length() < 1e-5, "{found} {expected}");
        }
        assert!((found.offset - expected.offset).length() < 1e-5);
        assert_eq!(barycentric_gradients(&placed([Vec3::ZERO, Vec3::X, Vec3::X * 2.0])), Gradients::default());
    }

    /// A small step on a sphere changes its coordinates by as much as the gradients say.
    #[test]
    fn gradients_on_a_sphere() {
        let sphere = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 2.0, material: 0 };
        for n in [Vec3::new(0.3, 0.5, -0.4), Vec3::new(-0.6, -0.2, 0.1)] {
            let at = |n: Vec3| sphere.center + n.normalize() * sphere.radius;
            let (position, step) = (at(n), n.cross(Vec3::new(0.3, 0.1, 0.9)).normalize() * 2e-3);
            let beside = sphere.center + (position + step - sphere.center).normalize() * sphere.radius;
            let change = sphere.uv(beside) - sphere.uv(position);
            let Gradients { u: du, v: dv } = sphere_gradients(&sphere, position);
            assert!((change - Vec2::new(step.dot(du), step.dot(dv))).length() < 1e-5, "{change}");
        }
    }
}
