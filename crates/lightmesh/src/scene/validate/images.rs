//! Images, textures and materials.

use glam::Vec3;

use super::invalid;
use crate::Error;
use crate::scene::data::SceneData;
use crate::scene::material::Material;
use crate::scene::texture::{ImageData, Texels};

/// The largest luminance, cd/m²: sums over the largest map, 2²⁸ texels, and squares stay in the range of f32; the sun has
/// 1.6·10⁹.
pub(super) const BRIGHTEST: f32 = 1e18;

/// The largest scale of a normal map, either sign.
const MOST_NORMAL_SCALE: f32 = 1e6;

pub(super) fn check_images(data: &SceneData) -> Result<(), Error> {
    for (index, image) in data.images.iter().enumerate() {
        check_texel_count(image, || format!("image {index} \"{}\"", image.name))?;
    }
    for (index, texture) in data.textures.iter().enumerate() {
        if texture.image >= data.images.len() {
            return invalid(format!("texture {index}"), format!("image {} does not exist", texture.image));
        }
    }
    Ok(())
}

pub(super) fn check_texel_count(image: &ImageData, object: impl Fn() -> String) -> Result<(), Error> {
    let texels = match &image.texels {
        Texels::Rgba8(t) => t.len(),
        Texels::Rgba32F(t) => t.len(),
    };
    if texels == 0 || texels as u64 != u64::from(image.width) * u64::from(image.height) {
        let what = format!("{} × {} texels announced, {texels} given", image.width, image.height);
        return invalid(object(), what);
    }
    Ok(())
}

pub(super) fn check_material(index: usize, m: &Material, textures: usize) -> Result<(), Error> {
    let object = || format!("material {index} \"{}\"", m.name);
    for texture in m.textures().into_iter().flatten() {
        if texture.texture >= textures || texture.uv_set > 1 {
            let what = format!("texture {} or its uv set {} does not exist", texture.texture, texture.uv_set);
            return invalid(object(), what);
        }
    }
    for texture in m.textures().into_iter().flatten() {
        let transform = &texture.transform;
        if !(transform.matrix.is_finite() && transform.offset.is_finite()) {
            return invalid(object(), "a texture's transform is not finite");
        }
    }
    // Check the factors' ranges.
    let factors = [m.alpha, m.metallic, m.roughness, m.specular, m.transmission];
    if !factors.iter().chain(&m.base_color.to_array()).all(|x| (0.0..=1.0).contains(x)) {
        return invalid(object(), "a factor is outside [0, 1]");
    }
    let positive = |v: Vec3| v.is_finite() && v.min_element() >= 0.0;
    if !positive(m.emission) || !positive(m.specular_color) {
        return invalid(object(), "emission or specular colour is negative or not finite");
    }
    if m.emission.max_element() > BRIGHTEST {
        return invalid(object(), format!("its emission {} is above {BRIGHTEST:e} cd/m²", m.emission));
    }
    if m.normal_scale.is_nan() || m.normal_scale.abs() > MOST_NORMAL_SCALE {
        let what = format!("the scale {} of its normal map is beyond {MOST_NORMAL_SCALE:e}", m.normal_scale);
        return invalid(object(), what);
    }
    if !(1.0..=Material::MOST_IOR).contains(&m.ior) {
        let what = format!("index of refraction {} is not between 1 and {:e}", m.ior, Material::MOST_IOR);
        return invalid(object(), what);
    }
    Ok(())
}
