//! Numbers from Python: anything that NumPy makes an array of, checked for its kind and shape.

use std::fmt::Display;

use glam::{Affine3A, Mat4, Vec2, Vec3, Vec4};
use lightmesh::Meter;
use lightmesh::geometry::Aabb;
use numpy::ndarray::Array2;
use numpy::{Element, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::error;

/// An array of one kind of number, row by row.
pub(crate) struct Numbers<T> {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<T>,
}

/// `numpy.asarray(value)`.
fn array<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    ASARRAY.import(value.py(), "numpy", "asarray")?.call1((value,))
}

/// Returns the kind of number as NumPy abbreviates it: `f`, `i`, `u`, `b` and others.
fn kind(array: &Bound<'_, PyAny>) -> PyResult<String> {
    array.getattr("dtype")?.getattr("kind")?.extract()
}

/// Returns how many dimensions the value has as an array; `None` if it is not an array.
pub(crate) fn dimensions(value: &Bound<'_, PyAny>) -> Option<usize> {
    array(value).ok()?.getattr("ndim").ok()?.extract().ok()
}

/// Converts an array to numbers of one type.
fn convert<T: Element + Copy>(array: &Bound<'_, PyAny>, dtype: &str) -> PyResult<Numbers<T>> {
    let array = array.call_method1("astype", (dtype, "C"))?;
    let array = array.cast::<PyArrayDyn<T>>()?.readonly();
    Ok(Numbers { shape: array.shape().to_vec(), values: array.as_slice()?.to_vec() })
}

/// Real numbers as 32-bit floats.
pub(crate) fn floats(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers<f32>> {
    let array = array(value)?;
    match kind(&array)?.as_str() {
        "f" | "i" | "u" => convert(&array, "float32"),
        _ => Err(wrong(&array, name, "expected real numbers")),
    }
}

/// Whole numbers from 0 on.
pub(crate) fn words(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers<u64>> {
    let array = array(value)?;
    match kind(&array)?.as_str() {
        "u" => convert(&array, "uint64"),
        _ => Err(wrong(&array, name, "expected unsigned whole numbers")),
    }
}

/// Bytes, in one row.
pub(crate) fn bytes(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<u8>> {
    let array = array(value)?;
    let size: usize = array.getattr("dtype")?.getattr("itemsize")?.extract()?;
    match (kind(&array)?.as_str(), size) {
        ("u", 1) => Ok(convert(&array, "uint8")?.values),
        _ => Err(wrong(&array, name, "expected uint8")),
    }
}

/// Bytes or real numbers as they are.
pub(crate) enum Texels {
    Bytes(Numbers<u8>),
    Floats(Numbers<f32>),
}

/// Texels of an image: bytes, or floats.
pub(crate) fn texels(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Texels> {
    let array = array(value)?;
    let size: usize = array.getattr("dtype")?.getattr("itemsize")?.extract()?;
    match (kind(&array)?.as_str(), size) {
        ("u", 1) => Ok(Texels::Bytes(convert(&array, "uint8")?)),
        ("f", _) => Ok(Texels::Floats(convert(&array, "float32")?)),
        _ => Err(wrong(&array, name, "expected uint8 or floats")),
    }
}

/// Rows of `N` numbers, as an array of the shape (n, N).
fn rows<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f32; N]>> {
    let numbers = floats(value, name)?;
    match numbers.shape[..] {
        [_, columns] if columns == N => Ok(numbers.values.as_chunks().0.to_vec()),
        _ => Err(misshapen(value.py(), name, &format!("(n, {N})"), &numbers.shape)),
    }
}

/// Points or vectors, (n, 3).
pub(crate) fn vec3s(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vec3>> {
    Ok(rows::<3>(value, name)?.into_iter().map(Vec3::from_array).collect())
}

/// Finite points, (n, 3).
pub(crate) fn finite_vec3s(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vec3>> {
    let points = vec3s(value, name)?;
    match points.iter().position(|point| !point.is_finite()) {
        None => Ok(points),
        Some(index) => {
            Err(error::scene(value.py(), format!("{name}: {} of index {index} is not finite", points[index])))
        }
    }
}

/// Meters: positions (n, 3), metres, and a normal for each, (n, 3), or one for all, (3,).
pub(crate) fn meters(positions: &Bound<'_, PyAny>, normals: &Bound<'_, PyAny>) -> PyResult<Vec<Meter>> {
    let positions = vec3s(positions, "positions")?;
    if dimensions(normals) == Some(1) {
        let normal = vec3(normals, "normals")?;
        return Ok(positions.into_iter().map(|position| Meter { position, normal }).collect());
    }
    let normals = vec3s(normals, "normals").and_then(|vectors| match vectors.len() == positions.len() {
        true => Ok(vectors),
        false => {
            let expected = format!("({}, 3) of positions or (3,)", positions.len());
            Err(misshapen(normals.py(), "normals", &expected, &[vectors.len(), 3]))
        }
    })?;
    Ok(positions.into_iter().zip(normals).map(|(position, normal)| Meter { position, normal }).collect())
}

/// A box: its least and its largest corner, (2, 3), metres.
pub(crate) fn region(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Aabb> {
    let corners = vec3s(value, name)?;
    let &[min, max] = &corners[..] else {
        return Err(misshapen(value.py(), name, "(2, 3)", &[corners.len(), 3]));
    };
    let bounds = Aabb { min, max };
    if !min.is_finite() || !max.is_finite() || bounds.is_empty() {
        return Err(error::scene(value.py(), format!("{name}: must be the least and the largest corner of a box")));
    }
    Ok(bounds)
}

/// Converts RGB colours to a new array, (n, 3).
pub(crate) fn from_colors(py: Python<'_>, colors: Vec<Vec3>) -> PyResult<Bound<'_, PyAny>> {
    let rows: Vec<[f32; 3]> = colors.into_iter().map(|color| color.to_array()).collect();
    let array = Array2::from_shape_vec((rows.len(), 3), rows.into_flattened());
    let array = array.map_err(|error| error::internal(&error.to_string()))?;
    Ok(PyArray2::from_owned_array(py, array).into_any())
}

/// Texture coordinates, (n, 2).
pub(crate) fn vec2s(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vec2>> {
    Ok(rows::<2>(value, name)?.into_iter().map(Vec2::from_array).collect())
}

/// Linear RGB or RGBA, (n, 3) or (n, 4).
pub(crate) fn colors(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vec4>> {
    let numbers = floats(value, name)?;
    match numbers.shape[..] {
        [_, 3] => Ok(numbers.values.as_chunks::<3>().0.iter().map(|&c| Vec3::from_array(c).extend(1.0)).collect()),
        [_, 4] => Ok(numbers.values.as_chunks::<4>().0.iter().map(|&c| Vec4::from_array(c)).collect()),
        _ => Err(misshapen(value.py(), name, "(n, 3) or (n, 4)", &numbers.shape)),
    }
}

/// Three indices a triangle, (n, 3) whole numbers from 0 on.
pub(crate) fn triangles(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[u32; 3]>> {
    let array = array(value)?;
    match kind(&array)?.as_str() {
        "i" => corners::<i64>(&array, "int64", name),
        "u" => corners::<u64>(&array, "uint64", name),
        _ => Err(wrong(&array, name, "expected whole numbers")),
    }
}

/// The triangles of an array of whole numbers, which is converted to numbers of type T, `dtype` for NumPy.
fn corners<T: Element + Copy + Display + TryInto<u32>>(
    array: &Bound<'_, PyAny>,
    dtype: &str,
    name: &str,
) -> PyResult<Vec<[u32; 3]>> {
    let numbers: Numbers<T> = convert(array, dtype)?;
    if !matches!(numbers.shape[..], [_, 3]) {
        return Err(misshapen(array.py(), name, "(n, 3)", &numbers.shape));
    }
    let index = |&i: &T| {
        let message = || error::scene(array.py(), format!("{name}: index {i} is no index of a corner"));
        i.try_into().map_err(|_| message())
    };
    let indices = numbers.values.iter().map(index).collect::<PyResult<Vec<u32>>>()?;
    Ok(indices.as_chunks().0.to_vec())
}

/// A point or a vector: three numbers.
pub(crate) fn vec3(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec3> {
    let numbers = floats(value, name)?;
    match (&numbers.shape[..], &numbers.values[..]) {
        ([3], &[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err(misshapen(value.py(), name, "(3,)", &numbers.shape)),
    }
}

/// A colour: three numbers, or one for grey.
pub(crate) fn color(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec3> {
    let numbers = floats(value, name)?;
    match (&numbers.shape[..], &numbers.values[..]) {
        ([], &[grey]) => Ok(Vec3::splat(grey)),
        ([3], &[r, g, b]) => Ok(Vec3::new(r, g, b)),
        _ => Err(misshapen(value.py(), name, "(3,) or one number", &numbers.shape)),
    }
}

/// A unit vector from three numbers that are not all 0.
pub(crate) fn direction(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec3> {
    let direction = vec3(value, name)?.try_normalize();
    direction.ok_or_else(|| error::scene(value.py(), format!("{name}: has no direction")))
}

/// An affine transform of column vectors: (4, 4), the last row 0, 0, 0, 1.
pub(crate) fn affine(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Affine3A> {
    let numbers = floats(value, name)?;
    let Some(values) = numbers.values.first_chunk::<16>().filter(|_| numbers.shape == [4, 4]) else {
        return Err(misshapen(value.py(), name, "(4, 4)", &numbers.shape));
    };
    let matrix = Mat4::from_cols_array(values).transpose();
    if values[12..] != [0.0, 0.0, 0.0, 1.0] || !matrix.is_finite() {
        return Err(error::scene(value.py(), format!("{name}: must be finite, and its last row 0, 0, 0, 1")));
    }
    Ok(Affine3A::from_mat4(matrix))
}

/// The exception for an array of a wrong shape.
pub(crate) fn misshapen(py: Python<'_>, name: &str, expected: &str, shape: &[usize]) -> PyErr {
    let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    error::scene(py, format!("{name}: expected the shape {expected}, not ({}{comma})", shape.join(", ")))
}

/// The exception for an array of a wrong type.
fn wrong(array: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    let dtype = array.getattr("dtype").map_or_else(|_| "another type".to_owned(), |dtype| dtype.to_string());
    error::scene(array.py(), format!("{name}: {expected}, not {dtype}"))
}
