//! Scenes, nodes and what hangs on them.

use serde::Deserialize;

use super::environment::SceneExtensions;

/// `scenes[]`.
#[derive(Debug, Deserialize)]
pub(crate) struct Scene {
    pub(crate) name: Option<String>,
    #[serde(default)]
    pub(crate) nodes: Vec<usize>,
    #[serde(default)]
    pub(crate) extensions: SceneExtensions,
}

/// `nodes[]`. There may be very many: what is rare is boxed.
#[derive(Debug, Deserialize)]
pub(crate) struct Node {
    pub(crate) name: Option<String>,
    #[serde(default)]
    pub(crate) children: Vec<usize>,
    pub(crate) mesh: Option<usize>,
    pub(crate) camera: Option<usize>,
    pub(crate) skin: Option<usize>,
    pub(crate) matrix: Option<Box<[f64; 16]>>,
    pub(crate) translation: Option<Box<[f64; 3]>>,
    pub(crate) rotation: Option<Box<[f64; 4]>>,
    pub(crate) scale: Option<[f32; 3]>,
    #[serde(default)]
    pub(crate) extensions: NodeExtensions,
}

/// `nodes[].extensions`.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) lights_punctual: Option<NodeLight>,
}

/// KHR_lights_punctual on a node.
#[derive(Debug, Deserialize)]
pub(crate) struct NodeLight {
    pub(crate) light: usize,
}

/// `meshes[]`.
#[derive(Debug, Deserialize)]
pub(crate) struct Mesh {
    pub(crate) name: Option<String>,
    pub(crate) primitives: Vec<Primitive>,
}

/// `meshes[].primitives[]`.
#[derive(Debug, Deserialize)]
pub(crate) struct Primitive {
    pub(crate) attributes: Attributes,
    pub(crate) indices: Option<usize>,
    pub(crate) material: Option<usize>,
    pub(crate) mode: Option<u32>,
    #[serde(default)]
    pub(crate) targets: Vec<serde::de::IgnoredAny>,
}

/// The attributes that we read; each an accessor.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) struct Attributes {
    pub(crate) position: Option<usize>,
    pub(crate) normal: Option<usize>,
    pub(crate) tangent: Option<usize>,
    pub(crate) texcoord_0: Option<usize>,
    pub(crate) texcoord_1: Option<usize>,
    pub(crate) color_0: Option<usize>,
}

/// `cameras[]`.
#[derive(Debug, Deserialize)]
pub(crate) struct Camera {
    pub(crate) name: Option<String>,
    pub(crate) perspective: Option<Perspective>,
    pub(crate) orthographic: Option<Orthographic>,
}

/// `cameras[].perspective`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Perspective {
    pub(crate) aspect_ratio: Option<f32>,
    pub(crate) yfov: f32,
}

/// `cameras[].orthographic`.
#[derive(Debug, Deserialize)]
pub(crate) struct Orthographic {
    pub(crate) xmag: f32,
    pub(crate) ymag: f32,
}

/// A light of KHR_lights_punctual.
#[derive(Debug, Deserialize)]
pub(crate) struct Light {
    pub(crate) name: Option<String>,
    #[serde(default = "white")]
    pub(crate) color: [f32; 3],
    #[serde(default = "super::one")]
    pub(crate) intensity: f32,
    pub(crate) range: Option<f32>,
    #[serde(rename = "type")]
    pub(crate) kind: LightKind,
    #[serde(default)]
    pub(crate) spot: Spot,
}

/// A light's `type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LightKind {
    Point,
    Spot,
    Directional,
}

/// A light's `spot`; radians.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Spot {
    pub(crate) inner_cone_angle: f32,
    pub(crate) outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 }
    }
}

fn white() -> [f32; 3] {
    [1.0; 3]
}
