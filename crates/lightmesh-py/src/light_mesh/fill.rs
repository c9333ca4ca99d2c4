//! Mesh points that are evaluated before anybody reads them.

use glam::Vec3;
use lightmesh::geometry::Aabb;
use lightmesh_cli::WorkStats;
use pyo3::prelude::*;

use super::PyLightMesh;
use crate::error::Raise;
use crate::listener::Listener;
use crate::scene::{LitScene, relative};
use crate::work::{self, AtInterrupt, Watch};
use crate::{json, shared_mesh};

/// Which mesh points to fill.
pub(crate) enum Target {
    /// Those that meters at these positions read.
    Around(Vec<Vec3>),
    /// Those in a box.
    Box(Aabb),
}

impl PyLightMesh {
    /// Evaluates mesh points; returns the statistics as JSON.
    pub(crate) fn fill_target(
        &self,
        py: Python<'_>,
        target: Target,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let LitScene { keywords, built } = self.own_scene(py)?;
        let (mesh, options) = (self.mesh.clone(), keywords.mesh_options());
        let here = |place: Vec3| relative(built.scene.data(), place);
        let target = match target {
            Target::Around(points) => Target::Around(points.into_iter().map(here).collect()),
            Target::Box(Aabb { min, max }) => Target::Box(Aabb { min: here(min), max: here(max) }),
        };
        let work = move |watch: &Watch| {
            let mut mesh = mesh.lock()?;
            let filled = match &target {
                Target::Around(points) => mesh.prefill_meters(&built.scene, &options, points, watch),
                Target::Box(bounds) => mesh.prefill_box(&built.scene, &options, bounds, watch),
            };
            Some(filled.map(|stats| serde_json::to_string(&WorkStats::new(&options, &stats))))
        };
        let listener = Listener::new(py, progress)?;
        let filled = work::run(py, keywords.threads(), listener.callback(), AtInterrupt::Wait, work);
        let filled = listener.close(filled)?.ok_or_else(|| shared_mesh::in_use(py))?;
        json::written(filled.map_err(|error| error.raise(py))?)
    }
}
