//! Pictures.

use std::io::{self, Cursor};
use std::path::PathBuf;
use std::sync::Arc;

use lightmesh::{Camera, Frame, Image, Layer, RenderOptions};
use lightmesh_cli::{EmitterArgs, Exposure, SOFTWARE, parse_exposure, settings_json};
use lightmesh_io::output::{Format, Metadata, Precision, StagedFile, write_exr, write_png};
use lightmesh_io::{Encoding, Picture, Units};
use pyo3::exceptions::PyTypeError;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{self, Raise};
use crate::view::{self, Keeps};
use crate::work::{self, AtInterrupt, Watch};
use crate::{json, keywords, output, pool};

/// A picture: numpy.asarray(image) is its linear light, float32, (H, W, 3), cd/m² per channel of RGB, without a copy
/// and not to be written to; row 0 is the uppermost. Notebooks show it exposed and tone mapped.
#[pyclass(name = "Image", module = "lightmesh", frozen)]
pub(crate) struct PyImage {
    pub(crate) picture: Picture,
    layers: Vec<Layer>,
    metadata: Metadata,
    /// Whether the camera of the metadata took the picture.
    has_camera: bool,
    /// Statistics as JSON; empty for a picture from a file.
    stats: String,
    /// The files of its scene.
    scene_files: Arc<[PathBuf]>,
}

impl Keeps for PyImage {
    /// 0: the light; then the layers.
    fn values(&self, which: usize) -> Option<&[f32]> {
        match which.checked_sub(1) {
            None => Some(bytemuck::cast_slice(&self.picture.image.pixels)),
            Some(layer) => self.layers.get(layer).map(|layer| &layer.values[..]),
        }
    }
}

#[pymethods]
impl PyImage {
    /// Reads an .exr (linear light), or a .png (light of a display, in [0, 1], already exposed and tone mapped).
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let name = path.display().to_string();
        let read = move |_: &Watch| lightmesh_io::read_picture(&path);
        let picture = work::run(py, None, None, AtInterrupt::Abandon, read)?.map_err(|error| error.raise(py))?;
        let metadata = Metadata {
            software: SOFTWARE.to_owned(),
            method: String::new(),
            scene: name,
            settings: "{}".to_owned(),
            seconds: 0.0,
            estimated_error: None,
            spp: 0,
            denoised: None,
            camera: Camera::look_at(glam::Vec3::Z, glam::Vec3::ZERO, 1.0),
        };
        Ok(Self {
            picture,
            layers: Vec::new(),
            metadata,
            has_camera: false,
            stats: String::new(),
            scene_files: Arc::default(),
        })
    }

    /// (H, W, 3).
    #[getter]
    fn shape(&self) -> (u32, u32, u32) {
        (self.picture.image.height, self.picture.image.width, 3)
    }

    /// Pixels in a row.
    #[getter]
    fn width(&self) -> u32 {
        self.picture.image.width
    }

    /// Rows.
    #[getter]
    fn height(&self) -> u32 {
        self.picture.image.height
    }

    /// Layers beside the light, by name: float32, (H, W, 3), or (H, W) where they have one value a pixel; not to be
    /// written to.
    #[getter]
    fn aovs<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let aovs = PyDict::new(slf.py());
        let (height, width) = slf.get().rows_and_columns();
        for (index, layer) in slf.get().layers.iter().enumerate() {
            let channels = layer.aov.channels().len();
            let shape = if channels == 1 { vec![height, width] } else { vec![height, width, channels] };
            aovs.set_item(layer.aov.name(), view::of(slf, index + 1, &shape)?)?;
        }
        Ok(aovs)
    }

    /// Statistics of the render, with the keys of --stats; empty for a picture that was read from a file.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::parse(py, if self.stats.is_empty() { "{}" } else { &self.stats })
    }

    /// The exposure that suits the picture, EV: its luminance times 2 to this power is what a display shows.
    #[getter]
    fn exposure(&self) -> f64 {
        // A multiple of 0.01 in either precision.
        (f64::from(Exposure::Auto.for_picture(&self.picture.image)) * 100.0).round() / 100.0
    }

    /// Writes the picture: .png, exposed, tone mapped and sRGB, or .exr, linear light and layers. The file appears
    /// whole or not at all; files that the scene was read from are not replaced (OptionError), and an Error says that
    /// another thread or program is writing the same file.
    ///
    /// exposure: EV of a .png, or "auto". half: 16-bit instead of 32-bit floats in an .exr.
    #[pyo3(signature = (path, *, exposure=None, half=false), text_signature = "($self, path, *, exposure='auto', half=False)")]
    fn save(&self, py: Python<'_>, path: PathBuf, exposure: Option<&Bound<'_, PyAny>>, half: bool) -> PyResult<()> {
        let format = Format::of(&path).map_err(|error| error.raise(py))?;
        let exposure = match exposure {
            None => Exposure::Auto,
            Some(value) => {
                let number = || keywords::number(value).map(|number| number.to_string());
                let text: Option<String> = value.extract().ok().or_else(number);
                let text = text.ok_or_else(|| PyTypeError::new_err("exposure: must be a number of EV, or 'auto'"))?;
                parse_exposure(&text).map_err(|what| error::option(py, format!("exposure: {what}")))?
            }
        };
        if format == Format::Exr && !self.has_camera {
            return Err(error::general(
                py,
                "a picture that was read from a file has no camera that an .exr could keep",
            ));
        }
        let precision = if half { Precision::Half } else { Precision::Single };
        output::spare(py, &path, &self.scene_files)?;
        let written = pool::detached(py, || {
            let mut file = StagedFile::create(&path)?;
            let written = match format {
                Format::Png => self.write_png(&mut file, exposure),
                Format::Exr => write_exr(&mut file, &self.picture.image, &self.layers, precision, &self.metadata),
            };
            written.map_err(|cause| file.error(cause))?;
            file.commit()
        })?;
        written.map_err(|error| error.raise(py))
    }

    /// The picture's light as an array; without a copy unless another type or a copy is asked for.
    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (height, width) = slf.get().rows_and_columns();
        let light = view::of(slf, 0, &[height, width, 3])?;
        let is_own = match dtype {
            None => true,
            Some(dtype) => light.getattr("dtype")?.eq(dtype)?,
        };
        match (is_own, copy) {
            (true, Some(true)) => light.call_method0("copy"),
            (true, _) => Ok(light),
            (false, Some(false)) => Err(PyValueError::new_err("another type than float32 takes a copy")),
            (false, _) => light.call_method1("astype", (dtype,)),
        }
    }

    /// The picture as a PNG, exposed automatically and tone mapped.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let png = pool::detached(py, || {
            let mut png = Cursor::new(Vec::new());
            self.write_png(&mut png, Exposure::Auto).map(|()| png.into_inner())
        })?;
        Ok(PyBytes::new(py, &png.map_err(|error| error::internal(&error.to_string()))?))
    }

    fn __repr__(&self) -> String {
        let Metadata { method, scene, .. } = &self.metadata;
        format!("<lightmesh.Image {}x{} of {scene:?} {method}>", self.width(), self.height())
    }
}

impl PyImage {
    /// Wraps a finished picture, with its statistics as JSON.
    pub(crate) fn of_frame(frame: Frame, metadata: Metadata, stats: String, scene_files: Arc<[PathBuf]>) -> Self {
        let metadata = Metadata {
            seconds: frame.stats.seconds.render,
            spp: frame.stats.spp,
            estimated_error: frame.stats.estimated_error,
            ..metadata
        };
        let picture = Picture { image: frame.image, encoding: Encoding::SceneLinear };
        Self { picture, layers: frame.layers, metadata, has_camera: true, stats, scene_files }
    }

    fn rows_and_columns(&self) -> (usize, usize) {
        let Image { width, height, .. } = self.picture.image;
        (height as usize, width as usize)
    }

    fn write_png(&self, out: impl io::Write, exposure: Exposure) -> io::Result<()> {
        let image = &self.picture.image;
        write_png(out, image, exposure.for_picture(image), &self.metadata)
    }
}

/// Describes a picture for its file, without how long it took and how good it is, which [`PyImage::of_frame`] adds.
pub(crate) fn metadata(
    scene: &str,
    options: &RenderOptions,
    emitters: &EmitterArgs,
    units: Units,
    camera: &Camera,
) -> Metadata {
    Metadata {
        software: SOFTWARE.to_owned(),
        method: options.method.to_string(),
        scene: scene.to_owned(),
        settings: settings_json(options, emitters, units, &camera.name),
        seconds: 0.0,
        estimated_error: None,
        spp: options.picture.spp,
        denoised: None,
        camera: camera.clone(),
    }
}
