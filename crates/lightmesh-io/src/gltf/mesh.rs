//! Meshes: each glTF primitive becomes a [`TriangleMesh`].

use glam::{Vec2, Vec3, Vec4};
use lightmesh::geometry::TriangleMesh;

use super::attribute::{AttributeReader, PrimitivePlace, Vertices};
use super::buffer::Buffers;
use super::context::{Context, place};
use super::json::{Attributes, Primitive};
use super::topology::Topology;
use super::{Used, normals};
use crate::error::Error;

/// The triangle meshes of mesh `index`, one per primitive that has triangles. `materials` numbers the materials they
/// use; `None` is glTF's default material.
pub(super) fn primitives(
    context: &mut Context<'_>,
    buffers: &Buffers<'_>,
    index: usize,
    materials: &mut Used<Option<usize>>,
) -> Result<Vec<TriangleMesh>, Error> {
    let mesh = context.get(&buffers.document.meshes, "mesh", index, "nodes")?;
    let name = mesh.name.as_deref();
    let mut meshes = Vec::new();
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let at = PrimitivePlace { mesh: place("mesh", index, name), primitive: i };
        if let Some(mut triangles) = read_primitive(context, buffers, primitive, at)? {
            if let Some(material) = primitive.material {
                context.get(&buffers.document.materials, "material", material, at)?;
            }
            triangles.material = materials.number(primitive.material);
            // Every primitive has its own copy of the mesh's name, which may be long.
            let name = name.unwrap_or_default();
            context.spend(at, (name.len() + size_of::<TriangleMesh>()) as u64, 1)?;
            triangles.name = name.to_owned();
            meshes.push(triangles);
        }
    }
    Ok(meshes)
}

/// Reads one primitive without its name and material; `None` if it has nothing to show.
fn read_primitive(
    context: &mut Context<'_>,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    at: PrimitivePlace<'_>,
) -> Result<Option<TriangleMesh>, Error> {
    // Skip points, lines and primitives without positions.
    let topology = match primitive.mode.unwrap_or(4) {
        0 => {
            context.warnings.add(at, "points are not rendered");
            return Ok(None);
        }
        1..=3 => {
            context.warnings.add(at, "lines are not rendered");
            return Ok(None);
        }
        4 => Topology::List,
        5 => Topology::Strip,
        6 => Topology::Fan,
        mode => return Err(context.invalid(at, format!("mode {mode} is none of glTF's 0 to 6"))),
    };
    let attributes = &primitive.attributes;
    let Some(position) = attributes.position else {
        context.warnings.add(at, "it has no POSITION attribute: left out");
        return Ok(None);
    };
    if !primitive.targets.is_empty() {
        context.warnings.add(at, "morph targets are not read: the base shape is shown");
    }

    // Triangles, their indices checked against the number of vertices.
    let reader = AttributeReader { buffers, at };
    let positions = reader.open(context, "POSITION", position, &[3], None)?;
    let vertex_count = positions.count;
    let indices = reader.indices(context, primitive.indices, vertex_count)?;
    context.spend(at, topology.triangle_count(indices.len()) as u64, 12)?;
    let mut triangles = topology.triangles(&indices);
    if topology == Topology::List && indices.len() % 3 != 0 {
        context.warnings.add(at, "its number of indices is no multiple of three: the rest is ignored");
    }
    if triangles.is_empty() {
        context.warnings.add(at, "it has no triangles: left out");
        return Ok(None);
    }

    // Vertices: those that a triangle uses, where many primitives share one large array.
    let vertices = Vertices::used_by(context, at, &mut triangles, vertex_count)?;
    let positions = vertices.collect(context, at, &positions, Vec3::from_array)?;
    if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
        let what = format!(
            "the position of vertex {} is {}, not finite; export the mesh again",
            vertices.original(i),
            positions[i]
        );
        return Err(context.invalid(at, what));
    }
    let flat = triangles.iter().filter(|t| has_no_area(t.map(|i| positions[i as usize]))).count();
    context.warnings.add_many(at, "a triangle has no area and is never hit", flat as u64);

    let mut mesh = TriangleMesh { positions, triangles, ..TriangleMesh::default() };
    read_shading(context, reader, attributes, &vertices, vertex_count, &mut mesh)?;
    Ok(Some(mesh))
}

/// Fills in what shading needs: normals, tangents, texture coordinates, colours; mended where they are not finite.
fn read_shading(
    context: &mut Context<'_>,
    reader: AttributeReader<'_>,
    attributes: &Attributes,
    vertices: &Vertices,
    vertex_count: usize,
    mesh: &mut TriangleMesh,
) -> Result<(), Error> {
    let (at, count) = (reader.at, Some(vertex_count));
    // Read normals, and replace broken ones.
    if let Some(normal) = attributes.normal {
        let accessor = reader.open(context, "NORMAL", normal, &[3], count)?;
        mesh.normals = vertices.collect(context, at, &accessor, Vec3::from_array)?;
        let broken = normals::normalize(&mut mesh.normals);
        if broken > 0 {
            let message = "a normal is zero or not finite: replaced by that of the triangles around it";
            context.warnings.add_many(at, message, broken as u64);
            context.spend(at, broken as u64, normals::REPLACEMENT_BYTES)?;
            normals::replace_zeros(&mut mesh.normals, broken, &mesh.positions, &mesh.triangles);
        }
    }
    // Read tangents; if one is broken, leave all of them out.
    if let Some(tangent) = attributes.tangent {
        let accessor = reader.open(context, "TANGENT", tangent, &[4], count)?;
        let tangents = vertices.collect(context, at, &accessor, unit_tangent)?;
        match tangents.into_iter().collect::<Option<Vec<_>>>() {
            Some(tangents) => mesh.tangents = tangents,
            None => context
                .warnings
                .add(at, "a tangent is zero or not finite: tangents are derived from texture coordinates"),
        }
    }
    // Read both sets of texture coordinates.
    let sets = [("TEXCOORD_0", attributes.texcoord_0), ("TEXCOORD_1", attributes.texcoord_1)];
    for (uvs, (name, accessor)) in mesh.uvs.iter_mut().zip(sets) {
        if let Some(accessor) = accessor {
            let accessor = reader.open(context, name, accessor, &[2], count)?;
            *uvs = vertices.collect(context, at, &accessor, Vec2::from_array)?;
            let mended = mend(uvs, Vec2::is_finite, Vec2::ZERO);
            context.warnings.add_many(at, "a texture coordinate is not finite: taken as zero", mended);
        }
    }
    // Read vertex colours.
    if let Some(color) = attributes.color_0 {
        // Integer colours are normalised by definition, and exporters forget to say so.
        let accessor = reader.open(context, "COLOR_0", color, &[3, 4], count)?.normalize();
        let opaque = accessor.components == 3;
        mesh.colors = vertices.collect(context, at, &accessor, |[r, g, b, a]: [f32; 4]| {
            Vec4::new(r, g, b, if opaque { 1.0 } else { a })
        })?;
        let mended = mend(&mut mesh.colors, Vec4::is_finite, Vec4::ONE);
        context.warnings.add_many(at, "a vertex colour is not finite: taken as white", mended);
        // The specification clamps them.
        mesh.colors.iter_mut().for_each(|color| *color = color.clamp(Vec4::ZERO, Vec4::ONE));
    }
    Ok(())
}

/// Replaces values that are not `good`; returns their number.
fn mend<T: Copy>(values: &mut [T], good: impl Fn(T) -> bool, replacement: T) -> u64 {
    let mut mended = 0;
    for value in values.iter_mut().filter(|value| !good(**value)) {
        *value = replacement;
        mended += 1;
    }
    mended
}

/// Returns whether the corners lie on a line, in double precision so that small triangles do not underflow.
fn has_no_area([a, b, c]: [Vec3; 3]) -> bool {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a) == glam::DVec3::ZERO
}

/// Returns the unit direction and the handedness ±1; `None` if the direction is zero or not finite.
fn unit_tangent([x, y, z, w]: [f32; 4]) -> Option<Vec4> {
    let direction = normals::unit(Vec3::new(x, y, z))?;
    Some(direction.extend(if w < 0.0 { -1.0 } else { 1.0 }))
}
