//! Which transmissive surfaces bound a solid, and which are sheets that stand for a thin pane.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::scene::SceneData;

/// A part is closed where its vector area, which is zero over the boundary of a solid, is less than this share of its
/// area: cracks and missing caps are forgiven. A judgement.
const CLOSED: f64 = 0.02;

/// Two sheets that face apart are one pane where they are nearer than this share of the root of their area. A
/// judgement: a pane is thinner than it is wide.
const PANE: f64 = 0.25;

/// Says of each instance which of its triangles belong to sheets: surfaces of transmissive material that enclose
/// nothing, and so stand for both faces of a thin pane. `None` where there are none.
///
/// Triangles that share corners are one part, whatever the meshes they come from. The vector area Σ ½ (b − a) × (c − a)
/// of a closed part is zero, by Gauss's theorem, even where its corners do not meet exactly. Two open parts of opposite
/// vector area close to each other are the faces of a pane without its edges, and count as a solid.
pub(super) fn sheets(data: &SceneData) -> Vec<Option<Box<[bool]>>> {
    // A mesh that is closed by itself needs no neighbours.
    let is_glass = |mesh: usize| data.materials[data.meshes[mesh].material].transmission > 0.0;
    let open: Vec<bool> = (0..data.meshes.len())
        .map(|mesh| {
            let corners = |i: u32| data.meshes[mesh].positions[i as usize];
            let triangles = data.meshes[mesh].triangles.iter().map(|t| t.map(corners));
            is_glass(mesh) && Parts::of(triangles.collect()).open().iter().any(|&open| open)
        })
        .collect();

    // Join the others in world space.
    let glass: Vec<usize> = (0..data.instances.len()).filter(|&i| open[data.instances[i].mesh]).collect();
    let mut triangles = Vec::new();
    for &i in &glass {
        let instance = &data.instances[i];
        let (mesh, m) = (&data.meshes[instance.mesh], &instance.world_from_object);
        let mirrors = m.matrix3.determinant() < 0.0;
        triangles.extend(mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| m.transform_point3(mesh.positions[i as usize]));
            if mirrors { [a, c, b] } else { [a, b, c] }
        }));
    }
    let open = Parts::of(triangles).open();

    // Hand the verdicts back.
    let mut sheets = vec![None; data.instances.len()];
    let mut first = 0;
    for &i in &glass {
        let count = data.meshes[data.instances[i].mesh].triangles.len();
        let own = &open[first..first + count];
        sheets[i] = own.iter().any(|&open| open).then(|| own.into());
        first += count;
    }
    sheets
}

/// Triangles, grouped by shared corners.
struct Parts {
    /// Of each triangle.
    part: Vec<usize>,
    shapes: Vec<PartShape>,
}

/// Sums over the triangles of a part.
#[derive(Clone, Copy, Default)]
struct PartShape {
    area: f64,
    vector_area: DVec3,
    /// The integral of the position over the area.
    moment: DVec3,
}

impl Parts {
    fn of(triangles: Vec<[Vec3; 3]>) -> Self {
        // Union the corners of each triangle by position.
        let mut corners = HashMap::new();
        let mut parent: Vec<usize> = Vec::new();
        let mut firsts = Vec::with_capacity(triangles.len());
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|p| {
                // Adding zero makes −0 the same as 0.
                let key = (p + Vec3::ZERO).to_array().map(f32::to_bits);
                *corners.entry(key).or_insert_with(|| {
                    parent.push(parent.len());
                    parent.len() - 1
                })
            });
            for other in [b, c] {
                let (x, y) = (root(&mut parent, a), root(&mut parent, other));
                parent[x.max(y)] = x.min(y);
            }
            firsts.push(a);
        }

        // Number the parts and sum over each.
        let (mut number, mut shapes) = (HashMap::new(), Vec::new());
        let mut part = Vec::with_capacity(triangles.len());
        for (first, triangle) in firsts.into_iter().zip(&triangles) {
            let index = *number.entry(root(&mut parent, first)).or_insert_with(|| {
                shapes.push(PartShape::default());
                shapes.len() - 1
            });
            let [a, b, c] = triangle.map(Vec3::as_dvec3);
            let vector_area = 0.5 * (b - a).cross(c - a);
            let area = vector_area.length();
            let shape: &mut PartShape = &mut shapes[index];
            shape.area += area;
            shape.vector_area += vector_area;
            shape.moment += (a + b + c) * (area / 3.0);
            part.push(index);
        }
        Self { part, shapes }
    }

    /// Says of each triangle whether its part encloses nothing.
    fn open(&self) -> Vec<bool> {
        let mut open: Vec<bool> = self.shapes.iter().map(|s| s.vector_area.length() > CLOSED * s.area).collect();

        // Find the two faces of panes among the open parts, from left to right.
        let centre = |i: usize| self.shapes[i].moment / self.shapes[i].area;
        let mut order: Vec<usize> = (0..open.len()).filter(|&i| open[i]).collect();
        order.sort_by(|&i, &j| centre(i).x.total_cmp(&centre(j).x).then(i.cmp(&j)));
        for (k, &i) in order.iter().enumerate() {
            let reach = PANE * self.shapes[i].area.sqrt();
            for &j in order[k + 1..].iter().take_while(|&&j| centre(j).x - centre(i).x < reach) {
                let sum = self.shapes[i].vector_area + self.shapes[j].vector_area;
                let faces_apart = sum.length() < CLOSED * (self.shapes[i].area + self.shapes[j].area);
                // Outwards: a pane's faces look away from each other.
                let apart = centre(j) - centre(i);
                if faces_apart && apart.length() < reach && apart.dot(self.shapes[j].vector_area) > 0.0 {
                    (open[i], open[j]) = (false, false);
                }
            }
        }
        self.part.iter().map(|&part| open[part]).collect()
    }
}

/// The representative of a union-find set, with paths halved.
fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::scene::{Instance, Material};

    /// A square of edge 2 in the plane z, seen from +z, or from −z if it is turned.
    fn square(z: f32, turned: bool) -> TriangleMesh {
        let positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, z)).to_vec();
        let triangles = if turned { vec![[0, 2, 1], [0, 3, 2]] } else { vec![[0, 1, 2], [0, 2, 3]] };
        TriangleMesh { positions, triangles, ..TriangleMesh::default() }
    }

    fn verdicts(meshes: Vec<TriangleMesh>) -> Vec<bool> {
        let instances =
            (0..meshes.len()).map(|mesh| Instance { mesh, world_from_object: Affine3A::IDENTITY }).collect();
        let materials = vec![Material { transmission: 1.0, ..Material::default() }];
        let data = SceneData { meshes, instances, materials, ..SceneData::default() };
        sheets(&data).iter().map(Option::is_some).collect()
    }

    /// A single square is a sheet; two that look away from each other close by are a pane, towards each other or far
    /// apart they are not.
    #[test]
    fn two_faces_make_a_pane() {
        assert_eq!(verdicts(vec![square(0.0, false)]), [true]);
        assert_eq!(verdicts(vec![square(0.1, false), square(0.0, true)]), [false, false]);
        assert_eq!(verdicts(vec![square(0.0, false), square(0.1, true)]), [true, true]);
        assert_eq!(verdicts(vec![square(3.0, false), square(0.0, true)]), [true, true]);
    }

    /// A tetrahedron whose faces are four meshes is closed; without one of them it is a sheet.
    #[test]
    fn faces_of_several_meshes_close_a_solid() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let face = |t: [usize; 3]| TriangleMesh {
            positions: t.map(|i| corners[i]).to_vec(),
            triangles: vec![[0, 1, 2]],
            ..TriangleMesh::default()
        };
        let mut faces: Vec<_> = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].into_iter().map(face).collect();
        assert_eq!(verdicts(faces.clone()), [false; 4]);
        faces.pop();
        assert_eq!(verdicts(faces), [true; 3]);
    }
}
