//! Materials and their extensions.

use serde::Deserialize;

use super::one;
use super::unread::Effect;

/// `materials[]`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Material {
    pub(crate) name: Option<String>,
    pub(crate) pbr_metallic_roughness: MetallicRoughness,
    pub(crate) normal_texture: Option<Box<TextureInfo>>,
    pub(crate) emissive_texture: Option<Box<TextureInfo>>,
    pub(crate) emissive_factor: [f32; 3],
    pub(crate) alpha_mode: AlphaMode,
    pub(crate) alpha_cutoff: Option<f32>,
    pub(crate) double_sided: bool,
    pub(crate) extensions: MaterialExtensions,
}

/// `alphaMode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum AlphaMode {
    #[default]
    Opaque,
    Mask,
    Blend,
}

/// `pbrMetallicRoughness`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct MetallicRoughness {
    pub(crate) base_color_factor: [f32; 4],
    pub(crate) base_color_texture: Option<Box<TextureInfo>>,
    pub(crate) metallic_factor: f32,
    pub(crate) roughness_factor: f32,
    pub(crate) metallic_roughness_texture: Option<Box<TextureInfo>>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

/// A use of a texture.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: usize,
    #[serde(default)]
    pub(crate) tex_coord: u32,
    /// The scale of a normal map; other textures have none.
    pub(crate) scale: Option<f32>,
    #[serde(default)]
    pub(crate) extensions: TextureInfoExtensions,
}

/// Extensions of a texture's use.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(crate) transform: Option<TextureTransform>,
}

/// KHR_texture_transform.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct TextureTransform {
    pub(crate) offset: [f32; 2],
    pub(crate) rotation: f32,
    pub(crate) scale: [f32; 2],
    pub(crate) tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

/// `materials[].extensions`.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(crate) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_unlit")]
    pub(crate) unlit: Option<serde::de::IgnoredAny>,
    #[serde(rename = "KHR_materials_specular")]
    pub(crate) specular: Option<Box<Specular>>,
    #[serde(rename = "KHR_materials_ior")]
    pub(crate) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(crate) transmission: Option<Box<Transmission>>,
    // What is not read.
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    specular_glossiness: Option<serde::de::IgnoredAny>,
    #[serde(rename = "KHR_materials_clearcoat", default)]
    clearcoat: Effect,
    #[serde(rename = "KHR_materials_sheen", default)]
    sheen: Effect,
    #[serde(rename = "KHR_materials_volume", default)]
    volume: Effect,
    #[serde(rename = "KHR_materials_iridescence", default)]
    iridescence: Effect,
    #[serde(rename = "KHR_materials_anisotropy", default)]
    anisotropy: Effect,
    #[serde(rename = "KHR_materials_dispersion", default)]
    dispersion: Effect,
    #[serde(rename = "KHR_materials_diffuse_transmission", default)]
    diffuse_transmission: Effect,
}

impl MaterialExtensions {
    /// The extensions that are not read, and whether this surface would look different with them.
    pub(crate) fn unread(&self) -> [(&'static str, bool); 8] {
        [
            ("KHR_materials_pbrSpecularGlossiness", self.specular_glossiness.is_some()),
            ("KHR_materials_clearcoat", self.clearcoat.0),
            ("KHR_materials_sheen", self.sheen.0),
            ("KHR_materials_volume", self.volume.0),
            ("KHR_materials_iridescence", self.iridescence.0),
            ("KHR_materials_anisotropy", self.anisotropy.0),
            ("KHR_materials_dispersion", self.dispersion.0),
            ("KHR_materials_diffuse_transmission", self.diffuse_transmission.0),
        ]
    }
}

/// KHR_materials_emissive_strength.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct EmissiveStrength {
    #[serde(default = "one")]
    pub(crate) emissive_strength: f32,
}

/// KHR_materials_specular.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Specular {
    pub(crate) specular_factor: f32,
    pub(crate) specular_texture: Option<Box<TextureInfo>>,
    pub(crate) specular_color_factor: [f32; 3],
    pub(crate) specular_color_texture: Option<Box<TextureInfo>>,
}

impl Default for Specular {
    fn default() -> Self {
        Self {
            specular_factor: 1.0,
            specular_texture: None,
            specular_color_factor: [1.0; 3],
            specular_color_texture: None,
        }
    }
}

/// KHR_materials_ior.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub(crate) struct Ior {
    pub(crate) ior: f32,
}

impl Default for Ior {
    fn default() -> Self {
        Self { ior: 1.5 }
    }
}

/// KHR_materials_transmission.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Transmission {
    pub(crate) transmission_factor: f32,
    pub(crate) transmission_texture: Option<Box<TextureInfo>>,
}
