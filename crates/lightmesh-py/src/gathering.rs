//! Points of the indirect mesh that one process gathers light for.

use std::sync::{Arc, Mutex};

use lightmesh::distributed::{BounceValues, GatherBatch};
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use crate::bricks::BrickArrays;
use crate::error::{self, Raise};
use crate::job::{Job, JobError};
use crate::work::{self, AtInterrupt, Watch};
use crate::{arrays, bricks};

/// Points, uint32, (n, 4), and values, float32, (n, sides, 3).
type LevelArrays<'py> = (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray3<f32>>);

/// The light that arrives at points of the indirect mesh after some reflections. Groups exchange levels; a process
/// makes each level once for all of its groups.
///
/// points: uint32, (n, 4), values: float32, (n, 6, 3), or (n, 1, 3) with method "paper": as GatherBatch.bounce gives
/// them, of several groups in any order.
#[pyclass(name = "Level", module = "lightmesh", frozen)]
pub(crate) struct PyLevel {
    values: Arc<BounceValues>,
}

#[pymethods]
impl PyLevel {
    #[new]
    fn new(points: &Bound<'_, PyAny>, values: &Bound<'_, PyAny>) -> PyResult<Self> {
        let addresses = arrays::words(points, "points")?;
        if !matches!(addresses.shape[..], [_, 4]) {
            return Err(arrays::misshapen(points.py(), "points", "(n, 4)", &addresses.shape));
        }
        let numbers: Vec<u32> = addresses.values.iter().map(|&word| u32::try_from(word).unwrap_or(u32::MAX)).collect();
        let values = arrays::floats(values, "values")?.values;
        let level = BounceValues { points: numbers.as_chunks().0.to_vec(), values };
        Ok(Self { values: Arc::new(BounceValues::merge([&level])) })
    }

    /// The number of points.
    fn __len__(&self) -> usize {
        self.values.points.len()
    }
}

/// A group of points of the indirect mesh for which light is gathered: their rays are shot; then they take the direct
/// light where the rays end, and exchange it with other groups reflection after reflection. PictureJob.gather makes it;
/// the same bricks always give the same group.
#[pyclass(name = "Gathering", module = "lightmesh", frozen)]
pub(crate) struct PyGathering {
    job: Arc<Job>,
    threads: Option<usize>,
    gathering: Arc<Mutex<GatherBatch>>,
}

#[pymethods]
impl PyGathering {
    /// Returns the points of the direct and of the indirect mesh that the rays read: two arrays of bricks.
    #[pyo3(signature = ())]
    fn wanted<'py>(&self, py: Python<'py>) -> PyResult<BrickArrays<'py>> {
        let wanted = self
            .run(py, None, |job, gathering, _| job.with_mesh(|mesh| Ok(gathering.requests(&job.built.scene, mesh))))?;
        Ok((bricks::to_array(py, &wanted.direct)?, bricks::to_array(py, &wanted.indirect)?))
    }

    /// Takes the direct light where the rays end, and fills what the direct mesh lacks for that. The rays are freed
    /// then.
    #[pyo3(signature = (*, progress=None))]
    fn light(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.run(py, progress, |job, gathering, watch| {
            job.with_mesh(|mesh| gathering.light(&job.built.scene, &job.options, mesh, watch))
        })
    }

    /// Computes the light that arrives at the points after k reflections or fewer. Returns points, uint32, (n, 4), and
    /// values, float32, (n, 6, 3), lux; (n, 1, 3) with method "paper".
    ///
    /// below: the level after k - 1 reflections, of the points of all groups; ignored if k is 0. Call with k = 0, 1, 2
    /// and so on.
    #[pyo3(signature = (k, below=None))]
    fn bounce<'py>(&self, py: Python<'py>, k: u32, below: Option<PyRef<'py, PyLevel>>) -> PyResult<LevelArrays<'py>> {
        let below = below.map_or_else(Arc::default, |level| Arc::clone(&level.values));
        let level =
            self.run(py, None, move |job, gathering, _| Ok(gathering.bounce(&job.built.scene, k, &below)?))?;
        let n = level.points.len();
        let sides = level.values.len() / (3 * n.max(1));
        let internal = |error: numpy::ndarray::ShapeError| error::internal(&error.to_string());
        let points = Array2::from_shape_vec((n, 4), level.points.into_flattened()).map_err(internal)?;
        let values = Array3::from_shape_vec((n, sides, 3), level.values).map_err(internal)?;
        Ok((points.into_pyarray(py), values.into_pyarray(py)))
    }

    /// Returns the finished points for other processes, after the last reflection: uint8, (n,), for PictureJob.absorb.
    fn contents<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let bytes = self.run(py, None, |job, gathering, _| {
            let contents = job.with_mesh(|mesh| gathering.snapshot(mesh))?;
            Ok(job.to_bytes(contents))
        })?;
        Ok(bytes.into_pyarray(py))
    }

    /// Memory that the group takes, bytes.
    #[getter]
    fn bytes(&self, py: Python<'_>) -> PyResult<u64> {
        self.run(py, None, |_, gathering, _| Ok(gathering.bytes()))
    }

    /// The number of points, without those inside solids.
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.run(py, None, |_, gathering, _| Ok(gathering.len()))
    }
}

impl PyGathering {
    pub(crate) fn new(job: Arc<Job>, threads: Option<usize>, gathering: GatherBatch) -> Self {
        Self { job, threads, gathering: Arc::new(Mutex::new(gathering)) }
    }

    fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        callback: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Job, &mut GatherBatch, &Watch) -> Result<T, JobError> + Send + 'static,
    ) -> PyResult<T> {
        let (job, gathering) = (Arc::clone(&self.job), Arc::clone(&self.gathering));
        let work = move |watch: &Watch| {
            let mut gathering = gathering.try_lock().map_err(|_| JobError::InUse)?;
            work(&job, &mut gathering, watch)
        };
        work::run(py, self.threads, callback, AtInterrupt::Wait, work)?.map_err(|error| error.raise(py))
    }
}
