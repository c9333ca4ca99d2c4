//! Materials.

use glam::Vec3;
use lightmesh::{AlphaMode, Material};

use super::context::{Context, Place, place};
use super::extensions::not_read;
use super::json::{self, Document};
use super::texture::{Encoding, Textures};
use crate::error::Error;

/// Reads material `index` of the file; `None` is glTF's default material (white, metallic, fully rough).
pub(super) fn material(
    context: &mut Context<'_>,
    document: &Document,
    index: Option<usize>,
    textures: &mut Textures,
) -> Result<Material, Error> {
    // Find the material.
    let default;
    let (source, at) = match index {
        Some(index) => {
            let material = context.get(&document.materials, "material", index, "meshes")?;
            (material, place("material", index, material.name.as_deref()))
        }
        None => {
            default = json::Material::default();
            (&default, place("default material", 0, None))
        }
    };
    let (pbr, extensions) = (&source.pbr_metallic_roughness, &source.extensions);
    let name = source.name.clone().unwrap_or_default();
    context.spend(at, name.len() as u64, 1)?;

    // Warn of extensions that are not read.
    for (extension, _) in extensions.unread().into_iter().filter(|(_, has_effect)| *has_effect) {
        context.warnings.add(at, &not_read(extension));
    }

    // Fill in the defaults of the extensions that are.
    let [r, g, b, alpha] = pbr.base_color_factor.map(|value| unit(context, at, value));
    let strength = extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
    let default_specular = json::Specular::default();
    let specular = extensions.specular.as_deref().unwrap_or(&default_specular);
    let default_transmission = json::Transmission::default();
    let transmission = extensions.transmission.as_deref().unwrap_or(&default_transmission);
    let mut refer = |context: &mut Context<'_>, info: &Option<Box<json::TextureInfo>>, encoding| {
        textures.refer(context, document, at, info.as_deref(), encoding)
    };

    // Convert every property, each checked or clamped.
    Ok(Material {
        name,
        base_color: Vec3::new(r, g, b),
        alpha,
        base_color_texture: refer(context, &pbr.base_color_texture, Encoding::Srgb)?,
        alpha_mode: match source.alpha_mode {
            json::AlphaMode::Opaque => AlphaMode::Opaque,
            json::AlphaMode::Mask => AlphaMode::Mask { cutoff: source.alpha_cutoff.unwrap_or(0.5).max(0.0) },
            json::AlphaMode::Blend => AlphaMode::Blend,
        },
        metallic: unit(context, at, pbr.metallic_factor),
        roughness: unit(context, at, pbr.roughness_factor),
        metallic_roughness_texture: refer(context, &pbr.metallic_roughness_texture, Encoding::Linear)?,
        emission: emission(context, at, source.emissive_factor, strength)?,
        emission_texture: refer(context, &source.emissive_texture, Encoding::Srgb)?,
        normal_texture: refer(context, &source.normal_texture, Encoding::Linear)?,
        normal_scale: normal_scale(context, at, source)?,
        specular: unit(context, at, specular.specular_factor),
        specular_texture: refer(context, &specular.specular_texture, Encoding::Linear)?,
        specular_color: specular_color(context, at, specular.specular_color_factor)?,
        specular_color_texture: refer(context, &specular.specular_color_texture, Encoding::Srgb)?,
        ior: ior(context, at, extensions.ior.as_ref().map_or(1.5, |e| e.ior)),
        transmission: unit(context, at, transmission.transmission_factor),
        transmission_texture: refer(context, &transmission.transmission_texture, Encoding::Linear)?,
        double_sided: source.double_sided,
        unlit: extensions.unlit.is_some(),
    })
}

/// Clamps a factor to [0, 1], with a warning.
fn unit(context: &mut Context<'_>, at: Place<'_>, value: f32) -> f32 {
    let clamped = if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) };
    if clamped != value {
        context.warnings.add(at, "a factor lies outside [0, 1]: clamped");
    }
    clamped
}

/// Returns emissiveFactor × emissiveStrength, cd/m².
fn emission(context: &Context<'_>, at: Place<'_>, factor: [f32; 3], strength: f32) -> Result<Vec3, Error> {
    let emission = Vec3::from_array(factor) * strength;
    if emission.is_finite() && emission.min_element() >= 0.0 {
        Ok(emission)
    } else {
        let what =
            format!("emission {factor:?} times {strength} is negative or not finite; check its emission strength");
        Err(context.invalid(at, what))
    }
}

fn normal_scale(context: &Context<'_>, at: Place<'_>, material: &json::Material) -> Result<f32, Error> {
    match material.normal_texture.as_ref().and_then(|n| n.scale).unwrap_or(1.0) {
        scale if scale.is_finite() => Ok(scale),
        _ => Err(context.invalid(at, "the scale of its normal texture is not finite")),
    }
}

fn specular_color(context: &Context<'_>, at: Place<'_>, color: [f32; 3]) -> Result<Vec3, Error> {
    let color = Vec3::from_array(color);
    if color.is_finite() && color.min_element() >= 0.0 {
        Ok(color)
    } else {
        Err(context.invalid(at, format!("specularColorFactor {color} is negative or not finite")))
    }
}

/// KHR_materials_ior allows 1 and more, and 0 for "reflects everything", which an enormous index comes to.
fn ior(context: &mut Context<'_>, at: Place<'_>, ior: f32) -> f32 {
    // F0 = ((n − 1)/(n + 1))² ≈ 1 − 4/n: within 4·10⁻⁶ of 1.
    if ior == 0.0 {
        return Material::MOST_IOR;
    }
    let clamped = if ior.is_nan() { 1.5 } else { ior.clamp(1.0, Material::MOST_IOR) };
    if clamped != ior {
        context.warnings.add(at, "its index of refraction is below 1 or absurd: clamped");
    }
    clamped
}
