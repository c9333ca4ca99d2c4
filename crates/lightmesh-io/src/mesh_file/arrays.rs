//! Converts the contents of a mesh to arrays and back.

use std::borrow::Cow;

use lightmesh::{DirectSnapshot, DirectValues, Focus, IndirectSnapshot, LatticeShape, PointSnapshot, Snapshot};

use super::read::{ArrayReader, Shape};
use super::tensor::Tensor;
use crate::error::Error;

/// Converts contents to the arrays of a file.
pub(super) fn to_tensors(contents: &Snapshot) -> Vec<Tensor<'_>> {
    let mut tensors = Vec::new();

    // Push the direct mesh: its points, and values in the encoding of its method.
    let DirectSnapshot { points, values } = &contents.direct;
    push_points(&mut tensors, "direct", points);
    let n = points.addresses.len();
    match values {
        DirectValues::SixAxis(values) => {
            tensors.push(Tensor::new("direct.six_axis".into(), &[n, 6, 2, 3], Cow::Borrowed(values)));
        }
        DirectValues::SixAxisParts(values) => {
            tensors.push(Tensor::new("direct.six_axis_parts".into(), &[n, 3, 6, 2, 3], Cow::Borrowed(values)));
        }
        DirectValues::Scalar(values) => {
            tensors.push(Tensor::new("direct.scalar".into(), &[n, 2, 3], Cow::Borrowed(values)));
        }
        DirectValues::Lights { words, bits } => {
            let shape = [n, 2, *words as usize];
            tensors.push(Tensor::new("direct.light_bits".into(), &shape, Cow::Borrowed(bits)));
        }
        DirectValues::Runs { ends, runs } => {
            tensors.push(Tensor::new("direct.run_ends".into(), &[n], Cow::Borrowed(ends)));
            tensors.push(Tensor::new("direct.runs".into(), &[runs.len()], Cow::Borrowed(runs)));
        }
    }

    // Push the indirect mesh.
    if let Some(indirect) = &contents.indirect {
        let IndirectSnapshot { points, bounces, faces: sides, values, hit_irradiance, hit_count } = indirect;
        push_points(&mut tensors, "indirect", points);
        let shape = [*bounces as usize + 1, points.addresses.len(), *sides as usize, 3];
        tensors.push(Tensor::new("indirect.values".into(), &shape, Cow::Borrowed(values)));
        tensors.push(Tensor::new("indirect.hit_irradiance".into(), &[1], Cow::Owned(vec![*hit_irradiance])));
        tensors.push(Tensor::new("indirect.hit_count".into(), &[1], Cow::Owned(vec![*hit_count])));
    }
    tensors
}

fn push_points<'a>(tensors: &mut Vec<Tensor<'a>>, field: &str, points: &'a PointSnapshot) {
    let PointSnapshot { lattices, focus, addresses, clearances, invalid } = points;
    let name = |array: &str| format!("{field}.{array}");
    let (levels, n, m) = (lattices.len(), addresses.len(), invalid.len());
    let origins: Vec<f32> = lattices.iter().flat_map(|lattice| lattice.origin).collect();
    let spacings: Vec<f32> = lattices.iter().map(|lattice| lattice.spacing).collect();
    let sizes: Vec<u32> = lattices.iter().flat_map(|lattice| lattice.size).collect();
    tensors.push(Tensor::new(name("lattice_origin"), &[levels, 3], Cow::Owned(origins)));
    tensors.push(Tensor::new(name("lattice_spacing"), &[levels], Cow::Owned(spacings)));
    tensors.push(Tensor::new(name("lattice_size"), &[levels, 3], Cow::Owned(sizes)));
    if let Some(Focus { min, max, scale }) = focus {
        tensors.push(Tensor::new(name("focus"), &[2, 3], Cow::Owned([*min, *max].concat())));
        tensors.push(Tensor::new(name("focus_scale"), &[1], Cow::Owned(vec![*scale])));
    }
    tensors.push(Tensor::new(name("addresses"), &[n, 4], Cow::Borrowed(addresses.as_flattened())));
    tensors.push(Tensor::new(name("positions"), &[n, 3], Cow::Owned(points.positions().into_flattened())));
    tensors.push(Tensor::new(name("clearances"), &[n, 6], Cow::Borrowed(clearances.as_flattened())));
    tensors.push(Tensor::new(name("invalid"), &[m, 4], Cow::Borrowed(invalid.as_flattened())));
    let positions = points.invalid_positions().into_flattened();
    tensors.push(Tensor::new(name("invalid_positions"), &[m, 3], Cow::Owned(positions)));
}

/// The contents that a file's arrays are.
pub(super) fn read_contents(arrays: &mut ArrayReader<'_>) -> Result<Snapshot, Error> {
    // Read the direct mesh: its points, and whichever encoding of values the file has.
    let points = read_points(arrays, "direct")?;
    let n = points.addresses.len();
    let given = ["direct.six_axis", "direct.six_axis_parts", "direct.scalar", "direct.light_bits", "direct.run_ends"]
        .into_iter()
        .find(|name| arrays.has(name));
    let values = match given {
        Some(name @ "direct.six_axis_parts") => {
            DirectValues::SixAxisParts(arrays.read(name, &Shape::of([n, 3, 6, 2, 3]))?.0)
        }
        Some("direct.scalar") => DirectValues::Scalar(arrays.read("direct.scalar", &Shape::of([n, 2, 3]))?.0),
        Some("direct.light_bits") => {
            let (bits, shape) = arrays.read("direct.light_bits", &Shape::of([n, 2]).and_any(1))?;
            DirectValues::Lights { words: arrays.small("direct.light_bits", shape[2])?, bits }
        }
        Some("direct.run_ends") => {
            let ends = arrays.read("direct.run_ends", &Shape::of([n]))?.0;
            DirectValues::Runs { ends, runs: arrays.read("direct.runs", &Shape::any(1))?.0 }
        }
        // Where there is none, this one is missed.
        _ => DirectValues::SixAxis(arrays.read("direct.six_axis", &Shape::of([n, 6, 2, 3]))?.0),
    };
    let direct = DirectSnapshot { points, values };

    // Read the indirect mesh, if there is one.
    if !arrays.has("indirect.addresses") && !arrays.has("indirect.values") {
        return Ok(Snapshot { direct, indirect: None });
    }
    let points = read_points(arrays, "indirect")?;
    let name = "indirect.values";
    let (values, shape) = arrays.read(name, &Shape::any(1).and([points.addresses.len()]).and_any(1).and([3]))?;
    let Some(bounces) = shape[0].checked_sub(1) else {
        return Err(arrays.invalid(name, "has not even light without reflections"));
    };
    let one = Shape::of([1]);
    let indirect = IndirectSnapshot {
        points,
        bounces: arrays.small(name, bounces)?,
        faces: arrays.small(name, shape[2])?,
        values,
        hit_irradiance: arrays.read("indirect.hit_irradiance", &one)?.0[0],
        hit_count: arrays.read("indirect.hit_count", &one)?.0[0],
    };
    Ok(Snapshot { direct, indirect: Some(indirect) })
}

fn read_points(arrays: &mut ArrayReader<'_>, field: &str) -> Result<PointSnapshot, Error> {
    let name = |array: &str| format!("{field}.{array}");
    let (spacings, shape) = arrays.read::<f32>(&name("lattice_spacing"), &Shape::any(1))?;
    let levels = shape[0];
    let (origins, _) = arrays.read_rows::<f32, 3>(&name("lattice_origin"), Some(levels))?;
    let (sizes, _) = arrays.read_rows::<u32, 3>(&name("lattice_size"), Some(levels))?;
    let rows = origins.into_iter().zip(spacings).zip(sizes);
    let lattices = rows.map(|((origin, spacing), size)| LatticeShape { origin, spacing, size }).collect();
    let focus = match arrays.has(&name("focus")) {
        true => {
            let (corners, _) = arrays.read_rows::<f32, 3>(&name("focus"), Some(2))?;
            let scale = arrays.read(&name("focus_scale"), &Shape::of([1]))?.0[0];
            Some(Focus { min: corners[0], max: corners[1], scale })
        }
        false => None,
    };
    let (addresses, n) = arrays.read_rows::<i32, 4>(&name("addresses"), None)?;
    let (clearances, _) = arrays.read_rows::<u8, 6>(&name("clearances"), Some(n))?;
    let (invalid, _) = arrays.read_rows::<i32, 4>(&name("invalid"), None)?;
    Ok(PointSnapshot { lattices, focus, addresses, clearances, invalid })
}
