//! A snapshot of a light mesh as arrays, which is kept until the mesh changes.

use lightmesh::{Cursor, DirectValues, LightMesh, PointSnapshot, Snapshot};
use pyo3::prelude::*;

use crate::view::{self, Keeps};

/// A copy of the points and values of a mesh.
#[pyclass(frozen)]
pub(crate) struct PyMeshArrays {
    counts: Cursor,
    /// Direct and indirect.
    meshes: [MeshArrays; 2],
}

/// One of the two meshes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    Direct,
    Indirect,
}

/// Points that give light first, then those that give none.
struct MeshArrays {
    points: Vec<f32>,
    levels: Vec<u8>,
    valid: Vec<bool>,
    /// NaN where a point gives no light; `None` where points keep no irradiance.
    values: Option<Vec<f32>>,
    /// The shape of the values of a point.
    shape: Vec<usize>,
}

impl MeshArrays {
    fn new(points: &PointSnapshot, values: Option<Vec<f32>>, shape: &[usize]) -> Self {
        let (valid, all) = (points.addresses.len(), points.addresses.len() + points.invalid.len());
        let mut positions = points.positions();
        positions.extend(points.invalid_positions());
        let addresses = points.addresses.iter().chain(&points.invalid);
        let values = values.map(|mut values| {
            values.resize(all * shape.iter().product::<usize>(), f32::NAN);
            values
        });
        Self {
            points: positions.into_flattened(),
            // There are at most a handful of levels.
            levels: addresses.map(|address| address[0] as u8).collect(),
            valid: (0..all).map(|index| index < valid).collect(),
            values,
            shape: shape.to_vec(),
        }
    }
}

/// Sums the values of the parts of the lights.
fn sum_parts(values: &[f32]) -> Vec<f32> {
    const PART: usize = 6 * 2 * 3;
    let sum =
        |point: &[f32]| -> [f32; PART] { std::array::from_fn(|i| point[i] + point[PART + i] + point[2 * PART + i]) };
    values.chunks_exact(3 * PART).flat_map(sum).collect()
}

impl PyMeshArrays {
    /// Copies all points and values of a mesh; of indirect light those after this many bounces.
    pub(crate) fn new(mesh: &LightMesh, bounces: u32) -> Self {
        let Snapshot { direct, indirect } = mesh.snapshot_since(&Cursor::default());
        let (values, shape): (_, &[usize]) = match direct.values {
            DirectValues::SixAxis(values) => (Some(values), &[6, 2, 3]),
            DirectValues::SixAxisParts(values) => (Some(sum_parts(&values)), &[6, 2, 3]),
            DirectValues::Scalar(values) => (Some(values), &[2, 3]),
            DirectValues::Lights { .. } | DirectValues::Runs { .. } => (None, &[]),
        };
        let direct = MeshArrays::new(&direct.points, values, shape);
        let indirect = match indirect {
            None => MeshArrays::new(&PointSnapshot::default(), Some(Vec::new()), &[6, 3]),
            Some(indirect) => {
                let values = indirect.after(bounces).to_vec();
                let shape: &[usize] = if indirect.faces == 1 { &[3] } else { &[6, 3] };
                MeshArrays::new(&indirect.points, Some(values), shape)
            }
        };
        Self { counts: mesh.cursor(), meshes: [direct, indirect] }
    }

    /// Returns whether the mesh has not changed since.
    pub(crate) fn is_current(&self, mesh: &LightMesh) -> bool {
        self.counts == mesh.cursor()
    }

    /// Returns the positions of the points, (n, 3).
    pub(crate) fn points<'py>(slf: &Bound<'py, Self>, part: Part) -> PyResult<Bound<'py, PyAny>> {
        let n = slf.get().of(part).valid.len();
        view::of::<f32, _>(slf, 2 * part as usize, &[n, 3])
    }

    /// Returns the values of the points, (n, ...); `None` where points keep no irradiance.
    pub(crate) fn values<'py>(slf: &Bound<'py, Self>, part: Part) -> PyResult<Option<Bound<'py, PyAny>>> {
        let MeshArrays { valid, values, shape, .. } = slf.get().of(part);
        let shape: Vec<usize> = std::iter::once(valid.len()).chain(shape.iter().copied()).collect();
        values.as_ref().map(|_| view::of::<f32, _>(slf, 2 * part as usize + 1, &shape)).transpose()
    }

    /// Returns which points give light, (n,).
    pub(crate) fn valid<'py>(slf: &Bound<'py, Self>, part: Part) -> PyResult<Bound<'py, PyAny>> {
        view::of::<bool, _>(slf, part as usize, &[slf.get().of(part).valid.len()])
    }

    /// Returns the levels of the points, (n,).
    pub(crate) fn levels<'py>(slf: &Bound<'py, Self>, part: Part) -> PyResult<Bound<'py, PyAny>> {
        view::of::<u8, _>(slf, part as usize, &[slf.get().of(part).levels.len()])
    }

    fn of(&self, part: Part) -> &MeshArrays {
        &self.meshes[part as usize]
    }
}

impl Keeps<f32> for PyMeshArrays {
    /// Points and values of one mesh after the other.
    fn values(&self, which: usize) -> Option<&[f32]> {
        let mesh = self.meshes.get(which / 2)?;
        if which.is_multiple_of(2) { Some(&mesh.points) } else { mesh.values.as_deref() }
    }
}

impl Keeps<bool> for PyMeshArrays {
    fn values(&self, which: usize) -> Option<&[bool]> {
        self.meshes.get(which).map(|mesh| &mesh.valid[..])
    }
}

impl Keeps<u8> for PyMeshArrays {
    fn values(&self, which: usize) -> Option<&[u8]> {
        self.meshes.get(which).map(|mesh| &mesh.levels[..])
    }
}
