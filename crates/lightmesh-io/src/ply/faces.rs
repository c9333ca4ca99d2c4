//! The element `face`.

use glam::Vec3;
use lightmesh::geometry::TriangleMesh;

use super::body::Body;
use super::header::{Element, Kind, Property};
use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::polygon::triangulate;
use crate::warnings::Warnings;

/// Fills the mesh's triangles.
pub(super) fn read(
    file: &str,
    body: &mut Body<'_>,
    element: &Element,
    budget: &mut Budget,
    warnings: &mut Warnings,
    mesh: &mut TriangleMesh,
) -> Result<(), Error> {
    // Find the list of corners.
    let is_corners = |p: &&Property| matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    if !element.properties.iter().any(|p| is_corners(&p)) {
        let what = "has no list vertex_indices or vertex_index".into();
        return Err(Error::Invalid { file: one_line(file), place: "element face".into(), what });
    }

    // Read each face and cut it into triangles; pass over its other properties.
    let (mut indices, mut corners): (Vec<u32>, Vec<Vec3>) = (Vec::new(), Vec::new());
    for face in 0..element.count {
        for property in &element.properties {
            let (count, item) = match property.kind {
                Kind::Scalar(scalar) => {
                    body.skip(scalar, 1)?;
                    continue;
                }
                Kind::List { count, item } => (body.whole(count)?, item),
            };
            if !is_corners(&property) {
                body.skip(item, count)?;
                continue;
            }
            // A list cannot be longer than the file: pay for the triangles before they are made.
            if count > body.left() as u64 {
                return Err(body.cut_off());
            }
            budget.take(file, "element face", count.saturating_sub(2), size_of::<[u32; 3]>() as u64)?;
            indices.clear();
            corners.clear();
            for _ in 0..count {
                let place = body.place();
                let index = body.whole(item)?;
                let Some(&position) = mesh.positions.get(index as usize) else {
                    let what = format!(
                        "refers to vertex {index}, but there are {}; the file is damaged",
                        mesh.positions.len()
                    );
                    return Err(Error::Invalid {
                        file: one_line(file),
                        place: format!("face {face} at {place}"),
                        what,
                    });
                };
                indices.push(index as u32);
                corners.push(position);
            }
            if count < 3 {
                warnings.add(format_args!("face {face}"), "faces of fewer than three corners are left out");
            }
            triangulate(&corners, |t| mesh.triangles.push(t.map(|i| indices[i])));
        }
    }
    Ok(())
}
