//! The geometry of a hit, before the material is looked up: position, normals, texture coordinates, tangents.

use glam::{Vec2, Vec3, Vec4};

use crate::Instance;
use crate::bvh::{Hit, Target};
use crate::geometry::{Ray, TriangleMesh, self_distance};
use crate::scene::Footprint;
use crate::world::Scene;

/// How much worse than a triangle's a user-defined shape's arithmetic may be: 64 makes it 2⁻¹⁴ of its size. A judgement.
const SHAPE_ERROR: f32 = 64.0;

/// The cosine between shading and geometric normal above which a surface counts as flat.
const FLAT: f32 = 1.0 - 1e-6;

/// The geometry of a hit, in world space.
pub(super) struct SurfaceInteraction<'a> {
    pub position: Vec3,
    /// Unit geometric normal, on the viewer's side.
    pub ng: Vec3,
    /// Unit interpolated normal, on the same side.
    pub n: Vec3,
    /// How far off the surface its rays start, metres.
    pub offset: f32,
    /// From the point to the curved surface that smooth normals pretend, metres; zero where that is flat or hollow.
    pub bulge: Vec3,
    /// Whether the ray met the front side.
    pub front: bool,
    /// Whether it is a sheet that stands for both faces of a thin pane ([`Scene::is_sheet`]).
    pub sheet: bool,
    /// Texture coordinates of both sets.
    pub uvs: [Vec2; 2],
    /// The part of the textures that the ray's cone covers, in both sets.
    pub footprints: [Footprint; 2],
    /// Linear RGBA of the vertices.
    pub color: Vec4,
    /// Index of the material.
    pub material: usize,
    /// Tangent and bitangent for the normal map, if there is one.
    pub tangents: Option<(Vec3, Vec3)>,
    /// What was hit, if it is a triangle.
    pub triangle: Option<PlacedTriangle<'a>>,
}

/// A triangle in world space.
#[derive(Clone, Copy)]
pub(super) struct PlacedTriangle<'a> {
    pub mesh: &'a TriangleMesh,
    /// The indices of its corners.
    pub corners: [usize; 3],
    /// From the first corner to the others, metres.
    pub edges: [Vec3; 2],
    /// Their cross product.
    pub normal: Vec3,
}

/// Returns `n` or its opposite, whichever is on the side of `reference`.
pub(crate) fn facing(n: Vec3, reference: Vec3) -> Vec3 {
    if n.dot(reference) < 0.0 { -n } else { n }
}

/// Returns a vector of unit length, also where the square of its length leaves the range of 32-bit floats.
fn unit(v: Vec3) -> Option<Vec3> {
    v.try_normalize().or_else(|| (v / v.abs().max_element()).try_normalize())
}

/// Evaluates the geometry that `ray` hit; footprints are left out.
pub(super) fn intersect_geometry<'a>(scene: &'a Scene, ray: &Ray, hit: &Hit) -> SurfaceInteraction<'a> {
    match hit.target {
        Target::Triangle { instance, triangle } => triangle_interaction(scene, ray, hit, instance, triangle),
        Target::Sphere(i) => {
            let sphere = &scene.data().spheres[i as usize];
            // Back onto the surface: o + t·d is off by the rounding of t.
            let position = sphere.center + sphere.normal(ray.at(hit.t)) * sphere.radius;
            let offset = self_distance(sphere.center.abs().max_element() + sphere.radius, sphere.radius);
            smooth_interaction(ray, position, sphere.normal(position), sphere.uv(position), offset, sphere.material)
        }
        Target::Shape(i) => {
            let entry = &scene.data().shapes[i as usize];
            let position = ray.at(hit.t);
            let coordinate = position.abs().max(ray.origin.abs()).max_element();
            let size = entry.shape.bounds().size().max_element().min(coordinate);
            let offset = self_distance(coordinate, SHAPE_ERROR * size);
            let (n, uv) = (entry.shape.normal(position), entry.shape.uv(position));
            smooth_interaction(ray, position, n, uv, offset, entry.material)
        }
    }
}

/// A sphere or user-defined shape: the normal is exact, so it is geometric and shading normal in one.
fn smooth_interaction(
    ray: &Ray,
    position: Vec3,
    outward: Vec3,
    uv: Vec2,
    offset: f32,
    material: usize,
) -> SurfaceInteraction<'static> {
    let front = outward.dot(ray.direction) < 0.0;
    let n = if front { outward } else { -outward };
    SurfaceInteraction {
        position,
        ng: n,
        n,
        offset,
        bulge: Vec3::ZERO,
        front,
        sheet: false,
        uvs: [uv; 2],
        footprints: [Footprint::POINT; 2],
        color: Vec4::ONE,
        material,
        tangents: None,
        triangle: None,
    }
}

fn triangle_interaction<'a>(
    scene: &'a Scene,
    ray: &Ray,
    hit: &Hit,
    instance: u32,
    triangle: u32,
) -> SurfaceInteraction<'a> {
    let placed = &scene.data().instances[instance as usize];
    let mesh = &scene.data().meshes[placed.mesh];
    let frame = scene.instance_frame(instance);
    let corners = mesh.triangles[triangle as usize].map(|i| i as usize);
    let b = [1.0 - hit.u - hit.v, hit.u, hit.v];

    // Compute the point from the corners: closer to the surface than o + t·d is.
    let mut p = corners.map(|i| mesh.positions[i]);
    if !frame.is_identity {
        p = p.map(|p| placed.world_from_object.transform_point3(p));
    }
    let position = p[0] * b[0] + p[1] * b[1] + p[2] * b[2];
    let edges = [p[1] - p[0], p[2] - p[0]];
    let size = edges[0].abs().max(edges[1].abs()).max_element();
    let offset = self_distance(rounded_coordinate(scene, instance, corners, position), size);

    // Turn the geometric normal to the viewer.
    let normal = edges[0].cross(edges[1]);
    let outward = unit(normal * frame.handedness).unwrap_or_else(|| -ray.direction.normalize());
    let front = outward.dot(ray.direction) < 0.0;
    let ng = if front { outward } else { -outward };

    // Interpolate normal, colour and texture coordinates.
    let (mut n, mut bulge) = (ng, Vec3::ZERO);
    if !mesh.normals.is_empty() {
        let mut normals = corners.map(|i| mesh.normals[i]);
        if !frame.is_identity {
            normals = normals.map(|n| frame.normal_from_object * n * frame.handedness);
        }
        let interpolated = normals[0] * b[0] + normals[1] * b[1] + normals[2] * b[2];
        n = facing(interpolated.normalize_or(ng), -ray.direction);
        if n.dot(ng) <= FLAT {
            bulge = height_of_bulge(position, p, normals.map(|n| facing(n, ng)), b);
        }
    }
    let color = if mesh.colors.is_empty() {
        Vec4::ONE
    } else {
        mesh.colors[corners[0]] * b[0] + mesh.colors[corners[1]] * b[1] + mesh.colors[corners[2]] * b[2]
    };
    let uvs = [0, 1].map(|set| interpolate(&mesh.uvs[set], corners, b));
    let mut interaction = SurfaceInteraction {
        position,
        ng,
        n,
        offset,
        bulge,
        front,
        sheet: scene.is_sheet(instance, triangle),
        uvs,
        footprints: [Footprint::POINT; 2],
        color,
        material: mesh.material,
        tangents: None,
        triangle: Some(PlacedTriangle { mesh, corners, edges, normal }),
    };

    // Find the tangents that a normal map needs.
    if let Some(map) = scene.data().materials[mesh.material].normal_texture {
        let outward = if front { n } else { -n };
        let frame = if mesh.tangents.is_empty() {
            tangents_from_uvs(p, &mesh.uvs[map.uv_set], corners, outward)
        } else {
            tangents_from_mesh(mesh, corners, b, placed, outward)
        };
        // Seen from behind, the whole frame is turned over (glTF 2.0 §3.9.6).
        interaction.tangents = frame.map(|(t, b)| if front { (t, b) } else { (-t, -b) });
    }
    interaction
}

/// The largest coordinate that was rounded on the way to a point of a triangle, metres: of the point itself where the
/// ray met corners in world space. A mesh with a tree of its own met a ray in object space, so there it is that of the
/// corners before the translation, times how much the two transforms may amplify what they round.
fn rounded_coordinate(scene: &Scene, instance: u32, corners: [usize; 3], position: Vec3) -> f32 {
    let frame = scene.instance_frame(instance);
    if frame.amplification == 0.0 {
        return position.abs().max_element();
    }
    let placed = &scene.data().instances[instance as usize];
    let [a, b, c] = corners.map(|i| scene.data().meshes[placed.mesh].positions[i].abs());
    let m = placed.world_from_object.matrix3.abs();
    let moved = m * glam::Vec3A::from(a.max(b).max(c)) + placed.world_from_object.translation.abs();
    moved.max_element() * frame.amplification
}

/// Returns how far a point of a triangle is from the curved surface that its corners' normals pretend: by the planes
/// through the corners that are above it, weighted as the corners are (Hanika, "Hacking the Shadow Terminator", Ray
/// Tracing Gems II, 2021, ch. 4, listing 4-1).
fn height_of_bulge(point: Vec3, corners: [Vec3; 3], normals: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    let above = |i: usize| {
        // Of any length: a root for each hit took time.
        let n = normals[i];
        n * ((point - corners[i]).dot(n).min(0.0) * -weights[i] / n.length_squared().max(f32::MIN_POSITIVE))
    };
    above(0) + above(1) + above(2)
}

fn interpolate(values: &[Vec2], corners: [usize; 3], b: [f32; 3]) -> Vec2 {
    if values.is_empty() {
        return Vec2::ZERO;
    }
    values[corners[0]] * b[0] + values[corners[1]] * b[1] + values[corners[2]] * b[2]
}

/// The mesh's own tangents: bitangent = (n × t) · w.
fn tangents_from_mesh(
    mesh: &TriangleMesh,
    corners: [usize; 3],
    b: [f32; 3],
    placed: &Instance,
    outward: Vec3,
) -> Option<(Vec3, Vec3)> {
    let t = mesh.tangents[corners[0]] * b[0] + mesh.tangents[corners[1]] * b[1] + mesh.tangents[corners[2]] * b[2];
    let mirrored = placed.world_from_object.matrix3.determinant() < 0.0;
    let sign = if mirrored { -t.w } else { t.w };
    orthogonal(placed.world_from_object.transform_vector3(t.truncate()), outward, sign)
}

/// The directions in which u grows and v falls (normal maps have y up, v points down), from a triangle's corners `p`:
/// edge = Δu ∂P/∂u + Δv ∂P/∂v, solved for ∂P/∂u.
fn tangents_from_uvs(p: [Vec3; 3], uvs: &[Vec2], corners: [usize; 3], outward: Vec3) -> Option<(Vec3, Vec3)> {
    let [a, b, c] = corners.map(|i| uvs.get(i).copied());
    let (e1, e2) = (b? - a?, c? - a?);
    let determinant = e1.perp_dot(e2);
    let tangent = ((p[1] - p[0]) * e2.y - (p[2] - p[0]) * e1.y) * determinant.signum();
    // ∂P/∂u × ∂P/∂v points along the triangle's own normal where the determinant is positive.
    let own_normal = (p[1] - p[0]).cross(p[2] - p[0]);
    let agrees = (determinant > 0.0) == (own_normal.dot(outward) > 0.0);
    orthogonal(tangent, outward, if agrees { -1.0 } else { 1.0 })
}

/// `tangent` made orthogonal to the normal, and the bitangent on the side that `sign` says.
fn orthogonal(tangent: Vec3, normal: Vec3, sign: f32) -> Option<(Vec3, Vec3)> {
    let tangent = (tangent - normal * normal.dot(tangent)).try_normalize()?;
    Some((tangent, normal.cross(tangent) * sign.signum()))
}
