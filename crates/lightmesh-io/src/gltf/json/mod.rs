//! The JSON of a glTF file, as far as we read it.
//!
//! Why not the `gltf` crate? Its JSON layer drops the place of an error, panics on some enumerations unless its
//! validation has passed (which refuses every extension it does not know), and lacks half the material extensions; the
//! typed mirror of what we read is shorter than the code around those would be. Unknown properties are ignored; indices
//! are checked where they are used.

mod data;
mod environment;
mod material;
mod node;
mod unread;

use serde::Deserialize;

pub(crate) use data::{Accessor, Buffer, BufferView, Image, Sampler, Sparse, Texture};
pub(crate) use environment::{ImageBasedLight, LightsImageBased};
pub(crate) use material::{AlphaMode, Material, MaterialExtensions, Specular, TextureInfo, Transmission};
pub(crate) use node::{Attributes, Camera, Light, LightKind, Mesh, Node, Primitive, Scene, Spot};

use crate::error::{Error, one_line};

/// The root object.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Document {
    pub(crate) asset: Asset,
    pub(crate) scene: Option<usize>,
    #[serde(default)]
    pub(crate) scenes: Vec<Scene>,
    #[serde(default)]
    pub(crate) nodes: Vec<Node>,
    #[serde(default)]
    pub(crate) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(crate) cameras: Vec<Camera>,
    #[serde(default)]
    pub(crate) materials: Vec<Material>,
    #[serde(default)]
    pub(crate) textures: Vec<Texture>,
    #[serde(default)]
    pub(crate) samplers: Vec<Sampler>,
    #[serde(default)]
    pub(crate) images: Vec<Image>,
    #[serde(default)]
    pub(crate) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(crate) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(crate) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(crate) animations: Vec<serde::de::IgnoredAny>,
    #[serde(default)]
    pub(crate) extensions_used: Vec<String>,
    #[serde(default)]
    pub(crate) extensions_required: Vec<String>,
    #[serde(default)]
    pub(crate) extensions: RootExtensions,
}

/// `asset`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Asset {
    pub(crate) version: String,
    pub(crate) min_version: Option<String>,
}

/// `extensions` of the root object.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) lights_punctual: Option<LightsPunctual>,
    #[serde(rename = "EXT_lights_image_based")]
    pub(crate) lights_image_based: Option<LightsImageBased>,
}

/// KHR_lights_punctual at the root.
#[derive(Debug, Deserialize)]
pub(crate) struct LightsPunctual {
    #[serde(default)]
    pub(crate) lights: Vec<Light>,
}

/// An upper bound of the memory that [`parse`] takes for a text, in proportion to the things in it and not to its
/// length alone: `{}` is three characters of an array with its comma, and a node of many times as many bytes.
pub(crate) fn parsed_bytes(text: &[u8]) -> u64 {
    let (mut objects, mut others) = (0, 0);
    for &byte in text {
        objects += u64::from(byte == b'{');
        others += u64::from(byte == b',' || byte == b'[');
    }
    objects * GROWTH * LARGEST_ELEMENT + others * GROWTH * size_of::<String>() as u64 + text.len() as u64
}

/// A list that has just doubled lives twice: n elements take up to 2 n, and n more while they are copied; a list of one
/// has room for four.
const GROWTH: u64 = 4;

/// No element of a list is larger, bytes; larger properties are boxed.
const LARGEST_ELEMENT: u64 = 176;

const _: () = {
    const fn fits<T>() {
        assert!(size_of::<T>() as u64 <= LARGEST_ELEMENT);
    }
    fits::<Scene>();
    fits::<Node>();
    fits::<Mesh>();
    fits::<Primitive>();
    fits::<Camera>();
    fits::<Light>();
    fits::<ImageBasedLight>();
    fits::<Material>();
    fits::<Texture>();
    fits::<Sampler>();
    fits::<Image>();
    fits::<Accessor>();
    fits::<BufferView>();
    fits::<Buffer>();
    // These hang on a brace of their own.
    fits::<TextureInfo>();
    fits::<Specular>();
    fits::<Transmission>();
    fits::<Sparse>();
};

/// Parses the text and checks `asset.version`.
pub(crate) fn parse(file: &str, text: &[u8]) -> Result<Document, Error> {
    match serde_json::from_slice::<Document>(text) {
        Ok(document) => check_version(file, &document.asset).map(|()| document),
        Err(_) => Err(explain(file, text)),
    }
}

/// Why the text does not parse. Tracking the place of an error costs time, so only a text that has one is parsed with
/// it.
fn explain(file: &str, text: &[u8]) -> Error {
    // The version first: a glTF 1.0 file differs so much that any other complaint would mislead.
    #[derive(Deserialize)]
    struct OnlyAsset {
        asset: Asset,
    }
    if let Ok(OnlyAsset { asset }) = serde_json::from_slice(text)
        && let Err(error) = check_version(file, &asset)
    {
        return error;
    }
    let mut deserializer = serde_json::Deserializer::from_slice(text);
    let mut advice = "the file is incomplete or damaged";
    let (place, what) = match serde_path_to_error::deserialize::<_, Document>(&mut deserializer) {
        Err(error) if error.path().to_string() != "." => {
            if !error.inner().is_eof() {
                advice = "the file is damaged";
            }
            (format!("JSON, {}", error.path()), error.inner().to_string())
        }
        Err(error) => ("JSON".to_owned(), error.inner().to_string()),
        // An object that parses, and then something behind it.
        Ok(_) => ("JSON".to_owned(), "text follows the end of the glTF object".to_owned()),
    };
    Error::Syntax { file: one_line(file), place: one_line(place), what: one_line(format_args!("{what}; {advice}")) }
}

/// Accepts 2.x that can be read as 2.0.
fn check_version(file: &str, asset: &Asset) -> Result<(), Error> {
    let refuse = |place, version: &str| {
        Err(Error::Version { file: one_line(file), place, version: one_line(version), readable: "glTF 2.0" })
    };
    match &asset.min_version {
        Some(minimum) if minimum != "2.0" => refuse("asset.minVersion", minimum),
        _ if !asset.version.starts_with("2.") => refuse("asset.version", &asset.version),
        _ => Ok(()),
    }
}

/// Defaults that serde asks for by name.
fn one() -> f32 {
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse("f.gltf", text.as_bytes()).map(|_| ()).unwrap_err().to_string()
    }

    #[test]
    fn errors_name_the_place() {
        let m = message(r#"{"asset": {"version": "2.0"}, "nodes": [{}, {"mesh": -1}]}"#);
        assert!(m.starts_with("f.gltf: JSON, nodes[1].mesh: ") && m.contains("-1"), "{m}");
        assert!(message(r#"{"asset": {"version": "2.0"}, "#).contains("f.gltf: JSON"));
    }

    #[test]
    fn versions() {
        assert!(message(r#"{"asset": {"version": "1.0"}, "scenes": {}}"#).contains("version 1.0"));
        assert!(message(r#"{"asset": {"version": "2.1", "minVersion": "2.1"}}"#).contains("minVersion"));
        assert!(parse("f", br#"{"asset": {"version": "2.1", "minVersion": "2.0"}}"#).is_ok());
    }
}
