//! Surface materials.

use glam::Vec3;
use lightmesh::{AlphaMode, Filter, ImageData, Material, SceneData, Texels, Texture, TextureRef, UvTransform, Wrap};
use pyo3::prelude::*;

use crate::{arrays, error};

/// A surface as glTF 2.0 describes it: Lambert and mirror, after metallic-roughness.
///
/// base_color: linear RGB in [0, 1], (3,) or one number.
/// metallic, roughness: in [0, 1]; up to a roughness of 0.25 it is a mirror, above it Lambert.
/// emission: luminance, cd/m² per channel, (3,) or one number.
/// specular: in [0, 1]; 0 is exactly Lambert at any roughness.
/// specular_color: linear RGB from 0 on. ior: index of refraction, 1 or more.
/// transmission: the fraction of light that is not mirrored which goes through, in [0, 1].
/// alpha: in [0, 1]; alpha_mode: "opaque" (alpha is ignored), "mask" (solid where alpha is at least alpha_cutoff) or
/// "blend".
/// double_sided: a thin sheet without an inside. unlit: the base colour is shown as it is.
///
/// Textures multiply the factor beside them and repeat: (H, W, 3) or (H, W, 4), uint8 or float, row 0 at v = 0.
/// base_color_texture and emission_texture are sRGB where they are uint8 and linear where they are float;
/// metallic_roughness_texture (G roughness, B metallic) and normal_texture (tangent space) are linear.
#[pyclass(name = "Material", module = "lightmesh", frozen)]
pub(crate) struct PyMaterial {
    material: Material,
    /// In the order of the constructor.
    images: [Option<ImageData>; 4],
}

#[pymethods]
impl PyMaterial {
    #[new]
    #[pyo3(
        signature = (
            *, base_color=None, metallic=0.0, roughness=1.0, emission=None, specular=1.0, specular_color=None, ior=1.5,
            transmission=0.0, alpha=1.0, alpha_mode="opaque", alpha_cutoff=0.5, double_sided=false, unlit=false,
            base_color_texture=None, metallic_roughness_texture=None, emission_texture=None, normal_texture=None,
            normal_scale=1.0, name=""
        ),
        text_signature = "(*, base_color=1.0, metallic=0.0, roughness=1.0, emission=0.0, specular=1.0, specular_color=1.0, ior=1.5, transmission=0.0, alpha=1.0, alpha_mode='opaque', alpha_cutoff=0.5, double_sided=False, unlit=False, base_color_texture=None, metallic_roughness_texture=None, emission_texture=None, normal_texture=None, normal_scale=1.0, name='')"
    )]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        py: Python<'_>,
        base_color: Option<&Bound<'_, PyAny>>,
        metallic: f32,
        roughness: f32,
        emission: Option<&Bound<'_, PyAny>>,
        specular: f32,
        specular_color: Option<&Bound<'_, PyAny>>,
        ior: f32,
        transmission: f32,
        alpha: f32,
        alpha_mode: &str,
        alpha_cutoff: f32,
        double_sided: bool,
        unlit: bool,
        base_color_texture: Option<&Bound<'_, PyAny>>,
        metallic_roughness_texture: Option<&Bound<'_, PyAny>>,
        emission_texture: Option<&Bound<'_, PyAny>>,
        normal_texture: Option<&Bound<'_, PyAny>>,
        normal_scale: f32,
        name: &str,
    ) -> PyResult<Self> {
        // Read the factors and the alpha mode.
        let color = |value: Option<&Bound<'_, PyAny>>, name, default| {
            value.map_or(Ok(default), |value| arrays::color(value, name))
        };
        let alpha_mode = match alpha_mode {
            "opaque" => AlphaMode::Opaque,
            "mask" if (0.0..=1.0).contains(&alpha_cutoff) => AlphaMode::Mask { cutoff: alpha_cutoff },
            "mask" => return Err(error::scene(py, format!("alpha_cutoff: must be in [0, 1], not {alpha_cutoff}"))),
            "blend" => AlphaMode::Blend,
            other => {
                return Err(error::scene(py, format!("alpha_mode: {other:?} is none of opaque, mask, blend")));
            }
        };
        let material = Material {
            name: name.to_owned(),
            base_color: color(base_color, "base_color", Vec3::ONE)?,
            metallic,
            roughness,
            emission: color(emission, "emission", Vec3::ZERO)?,
            specular,
            specular_color: color(specular_color, "specular_color", Vec3::ONE)?,
            ior,
            transmission,
            alpha,
            alpha_mode,
            double_sided,
            unlit,
            normal_scale,
            ..Material::default()
        };

        // Read the textures.
        let image = |value: Option<&Bound<'_, PyAny>>, name| value.map(|value| image(value, name)).transpose();
        let images = [
            image(base_color_texture, "base_color_texture")?,
            image(metallic_roughness_texture, "metallic_roughness_texture")?,
            image(emission_texture, "emission_texture")?,
            image(normal_texture, "normal_texture")?,
        ];
        Ok(Self { material, images })
    }

    /// Its name; may be empty.
    #[getter]
    fn name(&self) -> &str {
        &self.material.name
    }

    fn __repr__(&self) -> String {
        let [r, g, b] = self.material.base_color.to_array();
        format!("<lightmesh.Material {:?}, base colour ({r}, {g}, {b})>", self.material.name)
    }
}

impl PyMaterial {
    /// Adds it and its textures to a scene; returns its index.
    pub(crate) fn add_to(&self, data: &mut SceneData) -> usize {
        let mut material = self.material.clone();
        let [base_color, metallic_roughness, emission, normal, ..] = material.textures_mut();
        for (place, image) in [base_color, metallic_roughness, emission, normal].into_iter().zip(&self.images) {
            if let Some(image) = image {
                data.images.push(image.clone());
                let image = data.images.len() - 1;
                let (wrap_s, wrap_t) = (Wrap::Repeat, Wrap::Repeat);
                data.textures.push(Texture { image, wrap_s, wrap_t, filter: Filter::Bilinear });
                let texture = data.textures.len() - 1;
                *place = Some(TextureRef { texture, uv_set: 0, transform: UvTransform::default() });
            }
        }
        data.materials.push(material);
        data.materials.len() - 1
    }
}

/// An image from an array of the shape (H, W, 3) or (H, W, 4).
pub(crate) fn image(value: &Bound<'_, PyAny>, name: &str) -> PyResult<ImageData> {
    let py = value.py();
    let texels = arrays::texels(value, name)?;
    let shape = match &texels {
        arrays::Texels::Bytes(numbers) => &numbers.shape,
        arrays::Texels::Floats(numbers) => &numbers.shape,
    };
    let (height, width, channels) = match shape[..] {
        [height, width, channels @ (3 | 4)] if height > 0 && width > 0 => (height, width, channels),
        _ => return Err(arrays::misshapen(py, name, "(H, W, 3) or (H, W, 4)", shape)),
    };
    let side = |n: usize| u32::try_from(n).map_err(|_| error::scene(py, format!("{name}: is too large")));
    let (width, height) = (side(width)?, side(height)?);
    let texels = match texels {
        arrays::Texels::Bytes(numbers) => Texels::Rgba8(rgba(&numbers.values, channels, u8::MAX)),
        arrays::Texels::Floats(numbers) => {
            if let Some(x) = numbers.values.iter().find(|x| !x.is_finite()) {
                return Err(error::scene(py, format!("{name}: {x} is not finite")));
            }
            Texels::Rgba32F(rgba(&numbers.values, channels, 1.0))
        }
    };
    Ok(ImageData { name: name.to_owned(), width, height, texels })
}

/// Texels with an alpha, which is `solid` where there is none.
fn rgba<T: Copy>(values: &[T], channels: usize, solid: T) -> std::sync::Arc<[[T; 4]]> {
    values.chunks_exact(channels).map(|c| [c[0], c[1], c[2], c.get(3).copied().unwrap_or(solid)]).collect()
}
