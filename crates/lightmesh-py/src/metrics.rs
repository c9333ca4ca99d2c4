//! Distances between pictures.

use glam::Vec3;
use lightmesh::Image;
use lightmesh::metrics::difference;
use lightmesh_io::{Encoding, Picture};
use pyo3::prelude::*;

use crate::image::PyImage;
use crate::{arrays, error, pool};

/// Compares `a` with the reference `b`. Returns relrmse, bias, max and, unless `linear` is set, flip.
///
/// a, b: images, or arrays of linear cd/m² of the shape (H, W, 3).
#[pyfunction(name = "_compare", signature = (a, b, *, linear=false))]
pub(crate) fn compare(
    py: Python<'_>,
    a: &Bound<'_, PyAny>,
    b: &Bound<'_, PyAny>,
    linear: bool,
) -> PyResult<(f64, f64, f64, Option<f64>)> {
    let (a, b) = (Given::new(a, "a")?, Given::new(b, "b")?);
    let (a, b) = (a.picture(), b.picture());
    let size = |picture: &Picture| format!("{}x{}", picture.image.width, picture.image.height);
    if size(a) != size(b) {
        return Err(error::scene(py, format!("sizes differ: a is {}, b is {}", size(a), size(b))));
    }
    pool::detached(py, || {
        let d = difference(&a.image.pixels, &b.image.pixels);
        let flip = (!linear).then(|| lightmesh_cli::visible_difference(a, b));
        (d.relrmse, d.bias, d.max, flip)
    })
}

/// A picture to compare.
enum Given<'py> {
    Image(PyRef<'py, PyImage>),
    Array(Picture),
}

impl<'py> Given<'py> {
    fn new(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        if let Ok(image) = value.cast::<PyImage>() {
            return Ok(Self::Image(image.borrow()));
        }
        let numbers = arrays::floats(value, name)?;
        let [height, width, 3] = numbers.shape[..] else {
            return Err(arrays::misshapen(value.py(), name, "(H, W, 3)", &numbers.shape));
        };
        let side = |n: usize| u32::try_from(n).map_err(|_| error::scene(value.py(), format!("{name}: is too large")));
        let pixels = numbers.values.as_chunks().0.iter().copied().map(Vec3::from_array).collect();
        let image = Image::new(side(width)?, side(height)?, pixels);
        Ok(Self::Array(Picture { image, encoding: Encoding::SceneLinear }))
    }

    fn picture(&self) -> &Picture {
        match self {
            Self::Image(image) => &image.picture,
            Self::Array(picture) => picture,
        }
    }
}
