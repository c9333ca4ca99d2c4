//! Plane mirrors: flat parts of smooth metals, in which lamps are seen as lamps.

use glam::Vec3;

use crate::geometry::Aabb;
use crate::scene::{Light, Material, SceneData};

/// Mirrors that are kept, the largest ones.
const MOST_MIRRORS: usize = 8;

/// A flat part is a plane mirror if it is so large a part of its object, or larger. A box has a sixth on a side, the
/// triangles of a curved surface are less.
const LEAST_PART: f32 = 0.05;

/// Triangles of one plane: their normals' cosine, and how far off their corners are, in units of the object's size.
const SAME_NORMAL: f32 = 0.9999;
const SAME_PLANE: f32 = 1e-3;

/// A plane that reflects, within a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneMirror {
    /// Unit; both sides may reflect.
    pub n: Vec3,
    /// A point of the plane, the ball's middle, metres.
    pub center: Vec3,
    /// Metres.
    pub radius: f32,
    /// Square metres.
    area: f32,
}

impl PlaneMirror {
    /// The mirror image of a point.
    pub(crate) fn image_of(&self, p: Vec3) -> Vec3 {
        p - self.n * (2.0 * self.height(p))
    }

    /// How far a point is before the plane (behind: negative), metres.
    pub(crate) fn height(&self, p: Vec3) -> f32 {
        (p - self.center).dot(self.n)
    }

    /// The mirror image of a direction.
    pub(crate) fn image_of_direction(&self, d: Vec3) -> Vec3 {
        d - self.n * (2.0 * d.dot(self.n))
    }

    /// The mirror image of a lamp.
    pub(crate) fn image_of_light(&self, light: &Light) -> Light {
        let mut image = *light;
        match &mut image {
            Light::Point { position, .. } => *position = self.image_of(*position),
            Light::Spot { position, direction, .. } => {
                *position = self.image_of(*position);
                *direction = self.image_of_direction(*direction);
            }
            Light::Directional { direction, .. } => *direction = self.image_of_direction(*direction),
        }
        image
    }

    /// Whether a point of the plane may lie on the mirror.
    pub(crate) fn may_hold(&self, p: Vec3) -> bool {
        p.distance_squared(self.center) <= self.radius * self.radius
    }
}

/// Finds the largest plane mirrors of a checked scene.
pub(crate) fn plane_mirrors(data: &SceneData) -> Vec<PlaneMirror> {
    let mut mirrors = Vec::new();
    for instance in &data.instances {
        let mesh = &data.meshes[instance.mesh];
        if is_mirror(&data.materials[mesh.material]) {
            let corner = |&i: &u32| instance.world_from_object.transform_point3(mesh.positions[i as usize]);
            let triangles = mesh.triangles.iter().map(|triangle| [0, 1, 2].map(|k| corner(&triangle[k])));
            mirrors.extend(planes_of(triangles.collect()));
        }
    }
    // Stable: equal mirrors keep their order.
    mirrors.sort_by(|a, b| b.area.total_cmp(&a.area));
    mirrors.truncate(MOST_MIRRORS);
    mirrors
}

/// Whether a material is a flat metal mirror, where textures do not say otherwise.
fn is_mirror(material: &Material) -> bool {
    material.metallic >= 0.5
        && material.roughness <= Material::MIRROR_ROUGHNESS
        && material.normal_texture.is_none()
        && !material.unlit
}

/// The planes that are a good part of an object.
fn planes_of(triangles: Vec<[Vec3; 3]>) -> Vec<PlaneMirror> {
    let bounds = Aabb::from_points(triangles.iter().flatten().copied());
    let near = SAME_PLANE * bounds.size().max_element();
    let area = |t: &[Vec3; 3]| 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).length();
    let total: f32 = triangles.iter().map(area).sum();
    let most = (1.0 / LEAST_PART) as usize;

    // Group the triangles by plane, as far as there may be enough in each.
    let mut planes: Vec<(Vec3, Vec<[Vec3; 3]>)> = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle;
        let Some(n) = (b - a).cross(c - a).try_normalize() else { continue };
        let same = |(m, members): &(Vec3, Vec<[Vec3; 3]>)| {
            m.dot(n).abs() > SAME_NORMAL && triangle.iter().all(|&p| (p - members[0][0]).dot(*m).abs() <= near)
        };
        match planes.iter().position(same) {
            Some(k) => planes[k].1.push(triangle),
            None if planes.len() < 4 * most => planes.push((n, vec![triangle])),
            None => {}
        }
    }

    // Keep the large ones.
    let mirror = |(n, members): (Vec3, Vec<[Vec3; 3]>)| {
        let bounds = Aabb::from_points(members.iter().flatten().copied());
        let center = 0.5 * (bounds.min + bounds.max);
        let center = center - n * (center - members[0][0]).dot(n);
        let radius = members.iter().flatten().map(|p| p.distance(center)).fold(0.0, f32::max);
        PlaneMirror { n, center, radius, area: members.iter().map(area).sum() }
    };
    planes.into_iter().map(mirror).filter(|mirror| mirror.area >= LEAST_PART * total && mirror.area > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles is one mirror; images lie as far behind it.
    #[test]
    fn a_square_is_one_mirror() {
        let c = |x: f32, z: f32| Vec3::new(x, 2.0, z);
        let square = vec![[c(0.0, 0.0), c(2.0, 0.0), c(2.0, 2.0)], [c(0.0, 0.0), c(2.0, 2.0), c(0.0, 2.0)]];
        let mirrors = planes_of(square);
        assert_eq!(mirrors.len(), 1);
        assert!((mirrors[0].area - 4.0).abs() < 1e-5 && (mirrors[0].radius - 2.0_f32.sqrt()).abs() < 1e-5);
        assert_eq!(mirrors[0].image_of(Vec3::new(0.5, 1.5, 3.0)), Vec3::new(0.5, 2.5, 3.0));
    }

    /// A fan around a ball's equator is none: no triangle is a good part of it.
    #[test]
    fn curved_surfaces_are_none() {
        let p = |i: u32, y: f32| Vec3::new(libm::cosf(i as f32 * 0.1), y, libm::sinf(i as f32 * 0.1));
        let band =
            (0..62).flat_map(|i| [[p(i, 0.0), p(i + 1, 0.0), p(i, 0.1)], [p(i + 1, 0.0), p(i + 1, 0.1), p(i, 0.1)]]);
        assert_eq!(planes_of(band.collect()), Vec::new());
    }
}
