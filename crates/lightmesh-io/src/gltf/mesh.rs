//! Meshes: each glTF primitive becomes a [`TriangleMesh`].

use std::fmt::{self, Display};

use glam::{Vec2, Vec3, Vec4};
use lightmesh::geometry::TriangleMesh;

use super::accessor::{Accessor, Component};
use super::buffer::Buffers;
use super::context::{Context, Place, place};
use super::json::{Document, Primitive};
use super::topology::Topology;
use super::{Used, normals};
use crate::error::Error;

/// A primitive in a message.
#[derive(Clone, Copy, Debug)]
struct PrimitivePlace<'a> {
    mesh: Place<'a>,
    primitive: usize,
}

impl Display for PrimitivePlace<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, primitive {}", self.mesh, self.primitive)
    }
}

/// The triangle meshes of mesh `index`, one per primitive that has triangles. `materials` numbers the materials they use; `None` is
/// glTF's default material.
pub(super) fn primitives(
    context: &mut Context<'_>,
    document: &Document,
    buffers: &Buffers<'_>,
    index: usize,
    materials: &mut Used<Option<usize>>,
) -> Result<Vec<TriangleMesh>, Error> {
    let mesh = context.get(&document.meshes, "mesh", index, "nodes")?;
    let name = mesh.name.as_deref();
    let mut meshes = Vec::new();
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let at = PrimitivePlace { mesh: place("mesh", index, name), primitive: i };
        if let Some(mut triangles) = read_primitive(context, document, buffers, primitive, at)? {
            if let Some(material) = primitive.material {
                context.get(&document.materials, "material", material, at)?;
            }
            triangles.material = materials.number(primitive.material);
            triangles.name = name.unwrap_or_default().to_owned();
            context.spend(at, (triangles.name.len() + size_of::<TriangleMesh>()) as u64, 1)?;
            meshes.push(triangles);
        }
    }
    Ok(meshes)
}

/// One primitive without its name and material; `None` where it has nothing to show.
fn read_primitive(
    context: &mut Context<'_>,
    document: &Document,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    at: PrimitivePlace<'_>,
) -> Result<Option<TriangleMesh>, Error> {
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
    let reader = AttributeReader { document, buffers, at };
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
    let count = Some(vertex_count);
    let flat = triangles.iter().filter(|t| has_no_area(t.map(|i| positions[i as usize]))).count();
    context.warnings.add_many(at, "a triangle has no area and is never hit", flat as u64);

    let mut mesh = TriangleMesh { positions, triangles, ..TriangleMesh::default() };
    if let Some(normal) = attributes.normal {
        let accessor = reader.open(context, "NORMAL", normal, &[3], count)?;
        mesh.normals = vertices.collect(context, at, &accessor, Vec3::from_array)?;
        let mended = normals::mend(&mut mesh.normals, &mesh.positions, &mesh.triangles);
        context.warnings.add_many(
            at,
            "a normal is zero or not finite: replaced by that of the triangles around it",
            mended,
        );
    }
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
    let sets = [("TEXCOORD_0", attributes.texcoord_0), ("TEXCOORD_1", attributes.texcoord_1)];
    for (uvs, (name, accessor)) in mesh.uvs.iter_mut().zip(sets) {
        if let Some(accessor) = accessor {
            let accessor = reader.open(context, name, accessor, &[2], count)?;
            *uvs = vertices.collect(context, at, &accessor, Vec2::from_array)?;
            let mended = mend(uvs, Vec2::is_finite, Vec2::ZERO);
            context.warnings.add_many(at, "a texture coordinate is not finite: taken as zero", mended);
        }
    }
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
    Ok(Some(mesh))
}

/// Replaces what is not `good`, and counts.
fn mend<T: Copy>(values: &mut [T], good: impl Fn(T) -> bool, replacement: T) -> u64 {
    let mut mended = 0;
    for value in values.iter_mut().filter(|value| !good(**value)) {
        *value = replacement;
        mended += 1;
    }
    mended
}

/// Whether the corners lie on a line, in double precision so that small triangles do not underflow.
fn has_no_area([a, b, c]: [Vec3; 3]) -> bool {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a) == glam::DVec3::ZERO
}

/// Unit direction and handedness ±1.
fn unit_tangent([x, y, z, w]: [f32; 4]) -> Option<Vec4> {
    let direction = Vec3::new(x, y, z).try_normalize()?;
    Some(direction.extend(if w < 0.0 { -1.0 } else { 1.0 }))
}

/// Opens the accessors of one primitive.
struct AttributeReader<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    at: PrimitivePlace<'a>,
}

impl<'a> AttributeReader<'a> {
    /// Accessor `index`, which must have one of the numbers of `components`, and `count` elements if given.
    fn open(
        &self,
        context: &mut Context<'_>,
        name: &str,
        index: usize,
        components: &[usize],
        count: Option<usize>,
    ) -> Result<Accessor<'a>, Error> {
        let referrer = format!("{}, {name}", self.at);
        let accessor = Accessor::open(context, self.document, self.buffers, index, &referrer)?;
        if !components.contains(&accessor.components) {
            let what = format!(
                "accessor {index} has {} components per element, which {name} cannot have",
                accessor.components
            );
            return Err(context.invalid(self.at, what));
        }
        match count {
            Some(count) if count != accessor.count => {
                let what = format!(
                    "accessor {index} of {name} has {} elements for {count} vertices; the file is damaged",
                    accessor.count
                );
                Err(context.invalid(self.at, what))
            }
            _ => Ok(accessor),
        }
    }

    /// The index list, checked; without an accessor every vertex once.
    fn indices(&self, context: &mut Context<'_>, index: Option<usize>, vertex_count: usize) -> Result<Vec<u32>, Error> {
        let Some(index) = index else {
            context.spend(self.at, vertex_count as u64, 4)?;
            return Ok((0..vertex_count as u32).collect());
        };
        let accessor = self.open(context, "indices", index, &[1], None)?;
        if !(accessor.is_plain_integer()
            && matches!(accessor.component, Component::U8 | Component::U16 | Component::U32))
        {
            return Err(context.invalid(self.at, format!("accessor {index} of indices is not of unsigned integers")));
        }
        context.spend(self.at, accessor.count as u64, 4)?;
        let indices: Vec<u32> = (0..accessor.count).map(|i| accessor.index(i)).collect();
        match indices.iter().find(|&&i| i as usize >= vertex_count) {
            None => Ok(indices),
            Some(i) => {
                let what =
                    format!("index {i} is out of range: primitive has {vertex_count} vertices; the file is damaged");
                Err(context.invalid(self.at, what))
            }
        }
    }
}

/// Which elements of the attributes are kept, in order.
#[derive(Debug)]
enum Vertices {
    All,
    /// Sorted; the vertex that is now i was `kept[i]`.
    Kept(Vec<u32>),
}

impl Vertices {
    /// All vertices, unless the triangles are too few to use them all: then those that they use, and the triangles are
    /// renumbered. So a primitive never takes more vertices than it has corners, whatever array it shares with others.
    fn used_by(
        context: &mut Context<'_>,
        at: PrimitivePlace<'_>,
        triangles: &mut [[u32; 3]],
        vertex_count: usize,
    ) -> Result<Self, Error> {
        if triangles.len() * 3 >= vertex_count {
            return Ok(Self::All);
        }
        context.spend(at, triangles.len() as u64, 12)?;
        let mut kept: Vec<u32> = triangles.iter().flatten().copied().collect();
        kept.sort_unstable();
        kept.dedup();
        for corner in triangles.iter_mut().flatten() {
            // Every corner is in the list that was made of them.
            *corner = kept.binary_search(corner).unwrap_or_default() as u32;
        }
        Ok(Self::Kept(kept))
    }

    /// The vertex's number in the file.
    fn original(&self, i: usize) -> usize {
        match self {
            Self::All => i,
            Self::Kept(kept) => kept[i] as usize,
        }
    }

    /// The kept elements of an attribute.
    fn collect<T, const N: usize>(
        &self,
        context: &mut Context<'_>,
        at: PrimitivePlace<'_>,
        accessor: &Accessor<'_>,
        convert: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        let count = match self {
            Self::All => accessor.count,
            Self::Kept(kept) => kept.len(),
        };
        context.spend(at, count as u64, size_of::<T>() as u64)?;
        Ok((0..count).map(|i| convert(accessor.float(self.original(i)))).collect())
    }
}
