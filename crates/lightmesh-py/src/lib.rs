//! The Python face of lightmesh: thin classes over the library; what the command line has, it takes from there.

#![deny(unsafe_code)]

mod arrays;
mod bricks;
mod built;
mod camera;
mod denoise;
mod error;
mod gathering;
mod image;
mod job;
mod json;
mod keywords;
mod light;
mod light_mesh;
mod listener;
mod material;
mod mesh_files;
mod meters;
mod methods;
mod metrics;
mod output;
mod picture_job;
mod pool;
mod portions;
mod program;
mod render;
mod scene;
mod shared_mesh;
mod view;
mod work;

use pyo3::prelude::*;

/// The compiled part of lightmesh.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::bricks::{join_bricks, subtract_bricks};
    #[pymodule_export]
    use super::camera::PyCamera;
    #[pymodule_export]
    use super::gathering::{PyGathering, PyLevel};
    #[pymodule_export]
    use super::image::PyImage;
    #[pymodule_export]
    use super::keywords::options;
    #[pymodule_export]
    use super::light::PyLight;
    #[pymodule_export]
    use super::light_mesh::PyLightMesh;
    #[pymodule_export]
    use super::material::PyMaterial;
    #[pymodule_export]
    use super::metrics::compare;
    #[pymodule_export]
    use super::output::write_file;
    #[pymodule_export]
    use super::picture_job::PyPictureJob;
    #[pymodule_export]
    use super::program::run_program;
    #[pymodule_export]
    use super::scene::PyScene;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::pool::watch_forks(module.py())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
