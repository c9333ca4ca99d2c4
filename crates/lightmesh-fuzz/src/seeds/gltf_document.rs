//! A small glTF on its way to a file.

use serde_json::{Value, json};

use crate::mutate::gltf::{data_uri, join};

pub(super) const U8: u32 = 5121;
pub(super) const U16: u32 = 5123;
pub(super) const F32: u32 = 5126;

/// Its JSON and its binary chunk.
#[derive(Clone, Debug)]
pub(super) struct Document {
    pub(super) json: Value,
    binary: Vec<u8>,
}

impl Document {
    /// A square of two triangles that faces a camera and a lamp.
    pub(super) fn square() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0, 1, 2]}],
            "nodes": [
                {"mesh": 0},
                {"camera": 0, "translation": [0, 0, 4]},
                {"translation": [1, 1, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            ],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 50}]}},
            "meshes": [{"primitives": [{"attributes": {}}]}],
            "accessors": [], "bufferViews": [],
        });
        let mut document = Self { json, binary: Vec::new() };
        let corners = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0];
        let position = document.floats("VEC3", &corners);
        let indices = document.accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
        document.attribute("POSITION", position);
        document.primitive()["indices"] = json!(indices);
        document
    }

    /// Its only primitive.
    pub(super) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Gives the primitive an attribute.
    pub(super) fn attribute(&mut self, name: &str, accessor: usize) {
        self.primitive()["attributes"][name] = json!(accessor);
    }

    /// Appends to a list and returns the index.
    pub(super) fn push(&mut self, list: &str, value: Value) -> usize {
        match self.json[list].as_array_mut() {
            Some(list) => {
                list.push(value);
                list.len() - 1
            }
            None => {
                self.json[list] = json!([value]);
                0
            }
        }
    }

    /// A view of new bytes.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// An accessor of new bytes.
    pub(super) fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        self.push("accessors", accessor)
    }

    /// An accessor of floats.
    pub(super) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = if kind == "SCALAR" { 1 } else { usize::from(kind.as_bytes()[3] - b'0') };
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(F32, kind, values.len() / width, &bytes)
    }

    /// Gives the primitive a material.
    pub(super) fn material(&mut self, material: Value) {
        let index = self.push("materials", material);
        self.primitive()["material"] = json!(index);
    }

    /// Adds a texture of an encoded picture and returns its index.
    pub(super) fn texture(&mut self, picture: &[u8]) -> usize {
        let view = self.view(picture);
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}))
    }

    /// Gives the square texture coordinates.
    pub(super) fn uvs(&mut self) {
        let uvs = self.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        self.attribute("TEXCOORD_0", uvs);
    }

    /// The file, binary.
    pub(super) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        join(json.to_string().as_bytes(), Some(&self.binary))
    }

    /// The file as text, its numbers in a URI.
    pub(super) fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.binary.len(), "uri": data_uri(&self.binary)}]);
        json.to_string().into_bytes()
    }
}
