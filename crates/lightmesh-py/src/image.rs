//! Pictures.

use std::io::{self, Cursor};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use lightmesh::{Aov, Aovs, Camera, Frame, Image, Layer, Method, RenderOptions, Scene};
use lightmesh_cli::{EmitterArgs, Exposure, SOFTWARE, parse_exposure, settings_json};
use lightmesh_denoise::{Denoiser, DenoisingBytes, Resources, denoise_picture, layers_to_denoise, noisy_layers};
use lightmesh_io::output::{Denoised, Format, Metadata, Precision, StagedFile, write_exr, write_png};
use lightmesh_io::{Encoding, Picture, Units};
use pyo3::exceptions::PyTypeError;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::{self, Raise};
use crate::view::{self, Keeps};
use crate::work::{self, AtInterrupt, Watch};
use crate::{denoise, json, keywords, output, pool};

/// A picture: numpy.asarray(image) is its linear light, float32, (H, W, 3), cd/m² per channel of RGB, without a copy
/// and not to be written to; row 0 is the uppermost. Notebooks show it exposed and tone mapped.
#[pyclass(name = "Image", module = "lightmesh", frozen)]
#[derive(Clone)]
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
    /// `None` for a picture from a file.
    noise: Option<Noise>,
}

/// What is known of a picture's noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    method: Method,
    /// The layers that have it.
    layers: Aovs,
    /// The limit that the picture was rendered with, bytes.
    max_memory: u64,
}

impl Noise {
    /// Returns what is known of pictures with these options.
    pub(crate) fn of(options: &RenderOptions, scene: &Scene) -> Self {
        let layers = noisy_layers(options.method, scene.has_lights_with_size());
        Self { method: options.method, layers, max_memory: options.limits.max_memory }
    }
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
            noise: None,
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

    /// The picture without its noise, by Open Image Denoise (pip install pyoidn), as a new one; an Error where that is not
    /// installed. It is not bit for bit the same on every machine. What has no noise stays as it is: the picture needs the
    /// layers that tell what has, aov=["albedo", "normal", "direct", "indirect"], or is an OptionError; Scene.render with
    /// denoise=True needs none. A picture by a method without noise is returned as it is, with a RuntimeWarning.
    ///
    /// threads: None: as many as renders have.
    #[pyo3(signature = (*, threads=None))]
    fn denoise(&self, py: Python<'_>, threads: Option<usize>) -> PyResult<Self> {
        // Refuse what cannot be denoised.
        let Some(noise) = self.noise else {
            return Err(error::option(
                py,
                "denoise: a picture that was read from a file has no layers to denoise it by",
            ));
        };
        if let Some(denoised) = &self.metadata.denoised {
            return Err(error::option(py, format!("denoise: {} has denoised this picture already", denoised.by)));
        }
        if noise.layers.is_empty() {
            denoise::warn_of_no_noise(py, noise.method)?;
            return Ok(self.clone());
        }
        let has = |aov: Aov| self.layers.iter().any(|layer| layer.aov == aov);
        let needed = layers_to_denoise(noise.layers);
        if !needed.iter().all(has) {
            let spelled = |aovs: &mut dyn Iterator<Item = Aov>| {
                aovs.map(|aov| format!("\"{}\"", aov.name())).collect::<Vec<_>>().join(", ")
            };
            let (missing, all) = (spelled(&mut needed.iter().filter(|&aov| !has(aov))), spelled(&mut needed.iter()));
            let message = format!(
                "denoise: the picture lacks the layers {missing}: render it with aov=[{all}], or with denoise=True"
            );
            return Err(error::option(py, message));
        }

        // Load the library and check memory.
        let denoiser = Denoiser::load_from(&denoise::places(py)?).map_err(|error| error.raise(py))?;
        let bytes =
            DenoisingBytes::of(self.width(), self.height(), self.layers.iter().map(|layer| layer.aov).collect());
        let needed_bytes = bytes.picture.saturating_add(bytes.library);
        if needed_bytes > noise.max_memory {
            let error = lightmesh_denoise::Error::OutOfMemory { needed_bytes, limit_bytes: noise.max_memory };
            return Err(error.raise(py));
        }
        let max_memory = noise.max_memory - bytes.picture;

        // Denoise a copy on a thread of its own.
        let mut image = self.clone();
        let work = move |watch: &Watch| {
            let started = Instant::now();
            let resources = Resources::for_method(noise.method, max_memory);
            denoise_picture(&denoiser, &mut image.picture.image, &image.layers, noise.layers, resources, watch)?;
            let denoised = Denoised { by: denoiser.name(), seconds: started.elapsed().as_secs_f64() };
            Ok::<_, lightmesh_denoise::Error>((image, denoised))
        };
        let (mut image, denoised) =
            work::run(py, threads, None, AtInterrupt::Wait, work)?.map_err(|error| error.raise(py))?;
        image.stats = json::with_denoised(&image.stats, &denoised)?;
        image.metadata.denoised = Some(denoised);
        Ok(image)
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
    pub(crate) fn of_frame(
        frame: Frame,
        metadata: Metadata,
        stats: String,
        scene_files: Arc<[PathBuf]>,
        noise: Noise,
    ) -> Self {
        let metadata = Metadata {
            seconds: frame.stats.seconds.render,
            spp: frame.stats.spp,
            estimated_error: frame.stats.estimated_error,
            ..metadata
        };
        let picture = Picture { image: frame.image, encoding: Encoding::SceneLinear };
        Self { picture, layers: frame.layers, metadata, has_camera: true, stats, scene_files, noise: Some(noise) }
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
