//! The element `vertex`.

use glam::{DVec3, Vec2, Vec3, Vec4};
use lightmesh::geometry::TriangleMesh;

use super::body::Body;
use super::header::{Element, Kind, Property, Scalar};
use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::srgb::linear_from_srgb;
use crate::warnings::Warnings;
use crate::world_origin::{WorldOrigin, relative};

/// The attribute, and its component, that a scalar property of a vertex fills.
#[derive(Clone, Copy, PartialEq)]
enum Target {
    Position(usize),
    Normal(usize),
    Color(usize),
    Uv(usize),
}

/// The target of a property of this name.
fn target(name: &str) -> Option<Target> {
    Some(match name {
        "x" => Target::Position(0),
        "y" => Target::Position(1),
        "z" => Target::Position(2),
        "nx" => Target::Normal(0),
        "ny" => Target::Normal(1),
        "nz" => Target::Normal(2),
        "red" | "r" | "diffuse_red" => Target::Color(0),
        "green" | "g" | "diffuse_green" => Target::Color(1),
        "blue" | "b" | "diffuse_blue" => Target::Color(2),
        "s" | "u" | "texture_u" => Target::Uv(0),
        "t" | "v" | "texture_v" => Target::Uv(1),
        _ => return None,
    })
}

/// The linear value of a colour's component: integers are sRGB from 0 to their type's largest, floats linear.
fn linear_color(value: f64, scalar: Scalar) -> f32 {
    let largest = match scalar {
        Scalar::I8 => f64::from(i8::MAX),
        Scalar::U8 => f64::from(u8::MAX),
        Scalar::I16 => f64::from(i16::MAX),
        Scalar::U16 => f64::from(u16::MAX),
        Scalar::I32 => f64::from(i32::MAX),
        Scalar::U32 => f64::from(u32::MAX),
        Scalar::F32 | Scalar::F64 => return value as f32,
    };
    linear_from_srgb((value / largest).clamp(0.0, 1.0) as f32)
}

/// Fills the mesh's vertex arrays, and returns the origin to which its positions are relative.
pub(super) fn read(
    file: &str,
    body: &mut Body<'_>,
    element: &Element,
    budget: &mut Budget,
    warnings: &mut Warnings,
    mesh: &mut TriangleMesh,
) -> Result<DVec3, Error> {
    // Find out which attributes there are.
    let place = "element vertex";
    let target_of = |p: &Property| match p.kind {
        Kind::Scalar(_) => target(&p.name),
        Kind::List { .. } => None,
    };
    let targets: Vec<Option<Target>> = element.properties.iter().map(target_of).collect();
    // An attribute is there if all its components are.
    let has = |all: &[Target]| all.iter().all(|&t| targets.contains(&Some(t)));
    let positions = has(&[0, 1, 2].map(Target::Position));
    let normals = has(&[0, 1, 2].map(Target::Normal));
    let colors = has(&[0, 1, 2].map(Target::Color));
    let uvs = has(&[0, 1].map(Target::Uv));
    // Refuse what is no surface or too large, and pay for the arrays.
    if !positions {
        let what = "has no x, y and z; the file holds no surface that we can read".into();
        return Err(Error::Invalid { file: one_line(file), place: place.into(), what });
    }
    if element.count > u64::from(u32::MAX) {
        let what = format!("{} vertices, but at most {} can be read", element.count, u32::MAX);
        return Err(Error::Invalid { file: one_line(file), place: place.into(), what });
    }
    let bytes = 36 + if normals { 12 } else { 0 } + if colors { 16 } else { 0 } + if uvs { 8 } else { 0 };
    budget.take(file, place, element.count, bytes)?;
    let count = element.count as usize;
    let mut places: Vec<DVec3> = Vec::with_capacity(count);
    mesh.normals.reserve_exact(if normals { count } else { 0 });
    mesh.colors.reserve_exact(if colors { count } else { 0 });
    mesh.uvs[0].reserve_exact(if uvs { count } else { 0 });

    // Read each vertex: its properties by their targets, then what they mean.
    for index in 0..count {
        let (mut place, mut normal, mut color, mut uv) = (DVec3::ZERO, Vec3::ZERO, Vec4::ONE, Vec2::ZERO);
        for (property, target) in element.properties.iter().zip(&targets) {
            let scalar = match property.kind {
                Kind::Scalar(scalar) => scalar,
                Kind::List { count, item } => {
                    let length = body.whole(count)?;
                    body.skip(item, length)?;
                    continue;
                }
            };
            let value = body.number(scalar)?;
            match *target {
                Some(Target::Position(i)) => place[i] = value,
                Some(Target::Normal(i)) => normal[i] = value as f32,
                Some(Target::Color(i)) => color[i] = linear_color(value, scalar),
                Some(Target::Uv(i)) => uv[i] = value as f32,
                None => {}
            }
        }
        // Beyond f32 a position is infinite: the same answer as for NaN.
        if !(place.as_vec3().is_finite() && uv.is_finite() && color.is_finite()) {
            let what = "a coordinate or colour is not a finite 32-bit number; the file is damaged".into();
            return Err(Error::Invalid { file: one_line(file), place: format!("vertex {index}"), what });
        }
        places.push(place);
        if normals {
            let unit = normal.try_normalize();
            if unit.is_none() {
                warnings.add(format_args!("vertex {index}"), "normals without a direction were replaced by +Z");
            }
            mesh.normals.push(unit.unwrap_or(Vec3::Z));
        }
        if colors {
            mesh.colors.push(color.clamp(Vec4::ZERO, Vec4::ONE));
        }
        if uvs {
            // PLY counts v from the image's lower edge, we from its upper one.
            mesh.uvs[0].push(Vec2::new(uv.x, 1.0 - uv.y));
        }
    }

    // Move them next to the origin.
    let mut origin = WorldOrigin::default();
    origin.add(&places, 1.0);
    let origin = origin.choose();
    mesh.positions = places.iter().map(|&place| relative(place, origin)).collect();
    Ok(origin)
}
