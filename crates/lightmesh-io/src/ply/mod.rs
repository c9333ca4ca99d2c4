//! PLY, text and binary (G. Turk, "The PLY Polygon File Format", 1994).
//!
//! Read are the element `vertex` with `x y z`, `nx ny nz`, `red green blue` and `s t`, `u v` or `texture_u texture_v`,
//! and the element `face` with the list `vertex_indices` or `vertex_index`; polygons are cut into triangles. Colours in
//! integers are sRGB, in floats linear. Everything else is passed over. A PLY has no material: the surface is white
//! Lambert, and the vertex colours are its albedo.
//!
//! Our own parser: `ply-rs-bw` 4.0.1 refuses numbers such as `.5` and `2.`, keeps a map per vertex by default, and
//! makes as many records as a header asks for if they have no properties.

mod body;
mod faces;
mod header;
mod vertices;

#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{Affine3A, DVec3, Vec3};
use lightmesh::geometry::TriangleMesh;
use lightmesh::{Instance, Material, SceneData};

use self::body::Body;
use self::header::{Element, Kind};
use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::load_options::{LoadOptions, Loaded};
use crate::warnings::Warnings;

/// Reads a PLY file that is in memory; `file` is its name for messages. It refers to no other file and has no lights.
///
/// # Errors
/// As [`load`](crate::load).
pub(crate) fn read(
    file: &str,
    bytes: &[u8],
    _folder: Option<&Path>,
    _options: &LoadOptions,
    mut budget: Budget,
) -> Result<Loaded, Error> {
    // Read the elements in the order in which the header announces them.
    let header = header::parse(file, bytes)?;
    let mut body = Body::new(file, bytes, &header);
    let mut warnings = Warnings::default();
    let (mut mesh, mut origin) = (TriangleMesh::default(), DVec3::ZERO);
    let (mut has_vertices, mut has_faces) = (false, false);
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" if !has_vertices => {
                has_vertices = true;
                origin = vertices::read(file, &mut body, element, &mut budget, &mut warnings, &mut mesh)?;
            }
            "face" if !has_faces => {
                has_faces = true;
                if !has_vertices {
                    let what = "faces come before the vertices; export the file again".into();
                    return Err(Error::Invalid { file: one_line(file), place: "element face".into(), what });
                }
                faces::read(file, &mut body, element, &mut budget, &mut warnings, &mut mesh)?;
            }
            name => {
                skip_element(&mut body, element)?;
                warnings.add(format_args!("element {name:?}"), "elements of this name are not read");
            }
        }
    }

    // Refuse a file without a surface, and say what it has instead.
    if mesh.triangles.is_empty() {
        let what = match (mesh.positions.len(), has_faces) {
            (0, _) => "the file has no vertices".into(),
            (n, false) => format!("a point cloud of {n} vertices without faces; reconstruct a surface first"),
            (_, true) => "no face has three corners".into(),
        };
        return Err(Error::Empty { file: one_line(file), what });
    }

    // Place the mesh once, in white.
    Ok(Loaded {
        data: SceneData {
            origin,
            meshes: vec![mesh],
            instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
            materials: vec![Material::lambert(Vec3::ONE)],
            ..SceneData::default()
        },
        warnings: warnings.into_sentences(),
        files: Vec::new(),
    })
}

/// Passes over an element of no use to us.
fn skip_element(body: &mut Body<'_>, element: &Element) -> Result<(), Error> {
    // Records without properties take no bytes, and a header can announce any number of them.
    let count = if element.properties.is_empty() { 0 } else { element.count };
    for _ in 0..count {
        for property in &element.properties {
            match property.kind {
                Kind::Scalar(scalar) => body.skip(scalar, 1)?,
                Kind::List { count, item } => {
                    let length = body.whole(count)?;
                    body.skip(item, length)?;
                }
            }
        }
    }
    Ok(())
}
