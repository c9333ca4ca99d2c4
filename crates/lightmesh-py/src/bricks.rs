//! Points by brick as arrays, and other plain numbers that processes hand each other.

use lightmesh::distributed::{BrickMask, PointRequests};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;

use crate::arrays;

/// Points of the direct and of the indirect mesh: uint64, (n, 10) each.
pub(crate) type BrickArrays<'py> = (Bound<'py, PyArray2<u64>>, Bound<'py, PyArray2<u64>>);

/// Numbers per brick: level, packed coordinates, then a bit per place.
const COLUMNS: usize = 10;

/// Converts bricks to an array of uint64, (n, 10): level, packed coordinates, then 512 bits, lowest first.
pub(crate) fn to_array<'py>(py: Python<'py>, bricks: &[BrickMask]) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let key = |brick: &BrickMask| [u64::from(brick.level), brick.brick];
    let numbers: Vec<u64> = bricks.iter().flat_map(|brick| key(brick).into_iter().chain(brick.mask)).collect();
    let array = Array2::from_shape_vec((bricks.len(), COLUMNS), numbers);
    array.map(|array| array.into_pyarray(py)).map_err(|error| crate::error::internal(&error.to_string()))
}

/// Converts the array that [`to_array`] made back.
pub(crate) fn from_array(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<BrickMask>> {
    let numbers = arrays::words(value, name)?;
    if !matches!(numbers.shape[..], [_, COLUMNS]) {
        return Err(arrays::misshapen(value.py(), name, "(n, 10)", &numbers.shape));
    }
    // A level that there is not is refused where the brick is used.
    let brick = |&[level, brick, a, b, c, d, e, f, g, h]: &[u64; COLUMNS]| BrickMask {
        level: u32::try_from(level).unwrap_or(u32::MAX),
        brick,
        mask: [a, b, c, d, e, f, g, h],
    };
    Ok(numbers.values.as_chunks().0.iter().map(brick).collect())
}

/// Converts an array of bricks of one mesh, which is taken for the direct one.
fn wanted(value: &Bound<'_, PyAny>, name: &str) -> PyResult<PointRequests> {
    Ok(PointRequests { direct: from_array(value, name)?, indirect: Vec::new() })
}

/// Joins arrays of bricks. Returns all of their points: uint64, (n, 10), each brick once, in order.
#[pyfunction]
pub(crate) fn join_bricks<'py>(py: Python<'py>, bricks: Vec<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let mut all = PointRequests::default();
    for some in &bricks {
        all.direct.extend(wanted(some, "bricks")?.direct);
    }
    all.merge(&PointRequests::default());
    to_array(py, &all.direct)
}

/// Subtracts one array of bricks from another. Returns the points of the first that the second lacks: uint64, (n, 10).
#[pyfunction]
pub(crate) fn subtract_bricks<'py>(
    bricks: &Bound<'py, PyAny>,
    others: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let (mut rest, mut others) = (wanted(bricks, "bricks")?, wanted(others, "others")?);
    others.merge(&PointRequests::default());
    rest.remove(&others);
    to_array(bricks.py(), &rest.direct)
}
