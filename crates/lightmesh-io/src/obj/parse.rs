//! The text of an OBJ file.

use std::collections::BTreeMap;

use glam::{DVec3, Vec2, Vec3};

use super::Context;
use crate::error::Error;
use crate::srgb::linear_from_srgb;

/// One corner of a face: indices into the file's positions, texture coordinates and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: Option<u32>,
    pub(super) normal: Option<u32>,
}

/// The faces of one group (or object) and one material.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Name of the group.
    pub(super) name: String,
    /// Name of the material; empty if none was chosen.
    pub(super) material: String,
    /// Corners of all faces, one face after the other.
    pub(super) corners: Vec<Corner>,
    /// The end of each face in `corners`.
    pub(super) ends: Vec<usize>,
}

/// The contents of the file.
#[derive(Debug, Default)]
pub(super) struct Obj {
    /// In the file's coordinates, metres.
    pub(super) positions: Vec<DVec3>,
    /// Linear, for the vertices up to the last that has a colour; others are white.
    pub(super) colors: Vec<Vec3>,
    /// (0, 0) the image's upper left corner.
    pub(super) uvs: Vec<Vec2>,
    /// Unit; zero where the file's has no direction.
    pub(super) normals: Vec<Vec3>,
    /// Parts in the order in which they begin.
    pub(super) parts: Vec<Part>,
    /// The rest of each `mtllib` line.
    pub(super) libraries: Vec<String>,
}

/// Parses the text.
pub(super) fn parse(context: &mut Context<'_>, bytes: &[u8]) -> Result<Obj, Error> {
    let mut obj = Obj::default();
    let (mut group, mut material) = (String::new(), String::new());
    let mut part_of: BTreeMap<(String, String), usize> = BTreeMap::new();
    let mut current = None;

    let mut lines = bytes.split(|&b| b == b'\n').enumerate();
    while let Some((number, line)) = lines.next() {
        let number = number + 1;
        // A backslash at the end joins the next line.
        let mut text = String::from_utf8_lossy(line).trim_end().to_owned();
        while text.ends_with('\\') {
            text.pop();
            let Some((_, more)) = lines.next() else { break };
            text.push_str(String::from_utf8_lossy(more).trim_end());
        }
        let text = text.trim_start();
        let (key, rest) = text.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((text, ""));
        let rest = rest.trim();
        match key {
            "" => {}
            _ if key.starts_with('#') => {}
            "v" => position(context, &mut obj, number, rest)?,
            "vt" => {
                context.spend(number, 1, size_of::<Vec2>())?;
                let values = numbers(context, number, rest)?;
                let Some(&u) = values.first() else {
                    return Err(context.syntax(number, "a texture coordinate without numbers"));
                };
                // OBJ counts v from the image's lower edge, we from its upper one.
                obj.uvs.push(Vec2::new(u, 1.0 - values.get(1).copied().unwrap_or(0.0)));
            }
            "vn" => {
                context.spend(number, 1, size_of::<Vec3>())?;
                let values = numbers(context, number, rest)?;
                let &[x, y, z, ..] = &values[..] else {
                    return Err(context.syntax(number, "a normal needs three numbers"));
                };
                let unit = Vec3::new(x, y, z).try_normalize();
                if unit.is_none() {
                    context.warnings.add(format_args!("line {number}"), "normals without a direction are not used");
                }
                obj.normals.push(unit.unwrap_or(Vec3::ZERO));
            }
            "f" | "fo" => {
                let index = *current.get_or_insert_with(|| {
                    *part_of.entry((group.clone(), material.clone())).or_insert_with(|| {
                        obj.parts.push(Part { name: group.clone(), material: material.clone(), ..Part::default() });
                        obj.parts.len() - 1
                    })
                });
                face(context, &mut obj, index, number, rest)?;
            }
            "o" | "g" => {
                context.spend(number, 1, size_of::<Part>() + 3 * rest.len())?;
                (group, current) = (rest.to_owned(), None);
            }
            "usemtl" => {
                context.spend(number, 1, size_of::<Part>() + 3 * rest.len())?;
                (material, current) = (rest.to_owned(), None);
            }
            "mtllib" => obj.libraries.push(rest.to_owned()),
            "p" | "l" => context.warnings.add(format_args!("line {number}"), "points and lines are not rendered"),
            "curv" | "curv2" | "surf" => {
                let what = "free-form curves and surfaces are not read; export polygons";
                context.warnings.add(format_args!("line {number}"), what);
            }
            // Smoothing groups, display settings and what belongs to free-form surfaces.
            _ => {}
        }
    }
    Ok(obj)
}

/// `v x y z`, `v x y z w` or `v x y z r g b`. The weight w only matters to free-form curves; colours are sRGB.
fn position(context: &mut Context<'_>, obj: &mut Obj, line: usize, rest: &str) -> Result<(), Error> {
    context.spend(line, 1, size_of::<DVec3>())?;
    let values = doubles(context, line, rest)?;
    let &[x, y, z, ..] = &values[..] else {
        return Err(context.syntax(line, "a vertex needs three numbers"));
    };
    if obj.positions.len() >= u32::MAX as usize {
        return Err(context.invalid(line, "more vertices than 32-bit indices can count"));
    }
    obj.positions.push(DVec3::new(x, y, z));
    if let &[_, _, _, r, g, b, ..] = &values[..] {
        // Vertices before this one that had no colour are white.
        let missing = obj.positions.len() - obj.colors.len();
        context.spend(line, missing, size_of::<Vec3>())?;
        obj.colors.resize(obj.positions.len() - 1, Vec3::ONE);
        obj.colors.push(DVec3::new(r, g, b).as_vec3().clamp(Vec3::ZERO, Vec3::ONE).map(linear_from_srgb));
    }
    Ok(())
}

/// At most eight numbers in single precision.
fn numbers(context: &Context<'_>, line: usize, rest: &str) -> Result<Vec<f32>, Error> {
    Ok(doubles(context, line, rest)?.into_iter().map(|value| value as f32).collect())
}

/// At most eight numbers that are finite in single precision.
fn doubles(context: &Context<'_>, line: usize, rest: &str) -> Result<Vec<f64>, Error> {
    let parse = |word: &str| match word.parse::<f64>() {
        Ok(value) if (value as f32).is_finite() => Ok(value),
        Ok(_) => Err(context.invalid(line, format_args!("{word} is not a finite 32-bit number; the file is damaged"))),
        Err(_) => Err(context.syntax(line, format_args!("{word:?} is no number"))),
    };
    // A comment may follow.
    rest.split_ascii_whitespace().take_while(|word| !word.starts_with('#')).take(8).map(parse).collect()
}

/// `f` with corners `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn face(context: &mut Context<'_>, obj: &mut Obj, part: usize, line: usize, rest: &str) -> Result<(), Error> {
    // Read the corners.
    let start = obj.parts[part].corners.len();
    for word in rest.split_ascii_whitespace().take_while(|word| !word.starts_with('#')) {
        context.spend(line, 1, size_of::<Corner>() + size_of::<usize>())?;
        let mut fields = word.split('/');
        let (v, vt, vn) = (fields.next().unwrap_or(""), fields.next().unwrap_or(""), fields.next().unwrap_or(""));
        let position = match index(context, line, v, obj.positions.len())? {
            Index::At(position) => position,
            Index::Missing => return Err(context.syntax(line, format_args!("{word:?} is no corner of a face"))),
            Index::Outside => {
                let what =
                    format!("refers to vertex {v}, but there are {} so far; the file is damaged", obj.positions.len());
                return Err(context.invalid(line, what));
            }
        };
        // Some exporters miscount what only a part of the meshes has: the shape is good all the same.
        let mut optional = |word, count, what| {
            Ok(match index(context, line, word, count)? {
                Index::At(i) => Some(i),
                Index::Missing => None,
                Index::Outside => {
                    context.warnings.add(format_args!("line {line}"), what);
                    None
                }
            })
        };
        let uv =
            optional(vt, obj.uvs.len(), "a corner refers to a texture coordinate that is not there: taken as (0, 0)")?;
        let normal =
            optional(vn, obj.normals.len(), "a corner refers to a normal that is not there: taken from the face")?;
        obj.parts[part].corners.push(Corner { position, uv, normal });
    }

    // Close the face, or drop it if it has too few of them.
    let part = &mut obj.parts[part];
    if part.corners.len() < start + 3 {
        part.corners.truncate(start);
        context.warnings.add(format_args!("line {line}"), "faces of fewer than three corners are left out");
    } else {
        part.ends.push(part.corners.len());
    }
    Ok(())
}

/// The target of a field of a corner.
enum Index {
    /// An item, counted from 0.
    At(u32),
    /// The field is empty.
    Missing,
    /// No item so far.
    Outside,
}

/// An index from 1, or from −1 backwards, among `count` items so far.
fn index(context: &Context<'_>, line: usize, word: &str, count: usize) -> Result<Index, Error> {
    if word.is_empty() {
        return Ok(Index::Missing);
    }
    let Ok(number) = word.parse::<i64>() else {
        return Err(context.syntax(line, format_args!("{word:?} is no index")));
    };
    let from_start = if number < 0 { number.checked_add(count as i64) } else { number.checked_sub(1) };
    let inside = from_start.and_then(|i| usize::try_from(i).ok()).filter(|&i| i < count);
    Ok(inside.and_then(|i| u32::try_from(i).ok()).map_or(Index::Outside, Index::At))
}
