//! EXT_lights_image_based.

use serde::Deserialize;

/// The extension at the root.
#[derive(Debug, Deserialize)]
pub(crate) struct LightsImageBased {
    #[serde(default)]
    pub(crate) lights: Vec<ImageBasedLight>,
}

/// A light of EXT_lights_image_based.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct ImageBasedLight {
    pub(crate) name: Option<String>,
    pub(crate) rotation: Option<[f32; 4]>,
    #[serde(default = "super::one")]
    pub(crate) intensity: f32,
    /// Nine of red, green and blue.
    #[serde(default)]
    pub(crate) irradiance_coefficients: Vec<[f32; 3]>,
    /// Images of the faces for each level of detail, from the sharpest.
    #[serde(default)]
    pub(crate) specular_images: Vec<Vec<usize>>,
}

/// `scenes[].extensions`.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct SceneExtensions {
    #[serde(rename = "EXT_lights_image_based")]
    pub(crate) lights_image_based: Option<SceneLight>,
}

/// EXT_lights_image_based on a scene.
#[derive(Debug, Deserialize)]
pub(crate) struct SceneLight {
    pub(crate) light: usize,
}
