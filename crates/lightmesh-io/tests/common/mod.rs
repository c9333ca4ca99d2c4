//! A little builder of glTF files.

use std::path::Path;

use lightmesh_io::{Error, LoadOptions, Loaded, load_gltf_bytes};
use serde_json::{Value, json};

/// Component types by their OpenGL numbers.
pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A glTF under construction: its JSON and its binary chunk.
#[derive(Clone, Debug)]
pub(crate) struct Gltf {
    pub(crate) json: Value,
    pub(crate) binary: Vec<u8>,
}

impl Gltf {
    /// An empty scene.
    pub(crate) fn new() -> Self {
        let json =
            json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "buffers": [{"byteLength": 0}]});
        Self { json, binary: Vec::new() }
    }

    /// A scene whose node 0 shows mesh 0, the triangle (0,0,0) (1,0,0) (0,1,0).
    pub(crate) fn triangle() -> Self {
        let mut gltf = Self::new();
        let position = gltf.floats("VEC3", &TRIANGLE);
        gltf.mesh(json!({"attributes": {"POSITION": position}}));
        gltf.node(json!({"mesh": 0}));
        gltf
    }

    /// Appends to a list of the root object; the new element's index.
    pub(crate) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// A buffer view of these bytes.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.binary.len());
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// An accessor of `count` tight elements.
    pub(crate) fn accessor(&mut self, component: u32, element: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "type": element, "count": count});
        self.push("accessors", accessor)
    }

    /// An accessor of floats.
    pub(crate) fn floats(&mut self, element: &str, values: &[f32]) -> usize {
        let components = match element {
            "SCALAR" => 1,
            vector => vector[3..].parse().unwrap(),
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(F32, element, values.len() / components, &bytes)
    }

    /// An accessor of 16-bit indices.
    pub(crate) fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(U16, "SCALAR", indices.len(), &bytes)
    }

    /// A mesh of one primitive.
    pub(crate) fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({"primitives": [primitive]}))
    }

    /// The first primitive of mesh 0.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// A root node of scene 0.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
        index
    }

    /// A light of KHR_lights_punctual on a new node.
    pub(crate) fn light(&mut self, light: Value, mut node: Value) -> usize {
        let lights = &mut self.json["extensions"]["KHR_lights_punctual"]["lights"];
        if lights.is_null() {
            *lights = json!([]);
        }
        let lights = lights.as_array_mut().unwrap();
        lights.push(light);
        node["extensions"]["KHR_lights_punctual"]["light"] = json!(lights.len() - 1);
        self.node(node)
    }

    /// Gives the triangle of [`Gltf::triangle`] texture coordinates and this material.
    pub(crate) fn material(&mut self, material: Value) {
        let uv = self.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        self.primitive()["attributes"]["TEXCOORD_0"] = json!(uv);
        self.primitive()["attributes"]["TEXCOORD_1"] = json!(uv);
        let material = self.push("materials", material);
        self.primitive()["material"] = json!(material);
    }

    /// A texture of an image in a buffer view.
    pub(crate) fn texture(&mut self, image: &[u8]) -> usize {
        let view = self.view(image);
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}))
    }

    /// As a .glb.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend(((28 + json.len() + binary.len()) as u32).to_le_bytes());
        for (kind, data) in [(b"JSON", json), (b"BIN\0", binary)] {
            bytes.extend((data.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(data);
        }
        bytes
    }

    /// What the reader makes of it.
    pub(crate) fn load(&self) -> Result<Loaded, Error> {
        self.load_with(&LoadOptions::default())
    }

    /// [`Gltf::load`] with options.
    pub(crate) fn load_with(&self, options: &LoadOptions) -> Result<Loaded, Error> {
        load_gltf_bytes("test.glb", &self.glb(), None::<&Path>, options)
    }

    /// The message that it is refused with; one line that begins with the file's name.
    pub(crate) fn refusal(&self) -> String {
        let message = self.load().map(|_| ()).expect_err("must be refused").to_string();
        assert!(message.starts_with("test.glb: ") && !message.contains('\n'), "{message}");
        message
    }
}

/// Corners of the builder's triangle.
pub(crate) const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Asserts that `text` holds each of the words.
#[track_caller]
pub(crate) fn assert_says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word:?} is not in {text:?}");
    }
}

/// Asserts that there is one warning and that it holds each of the words.
#[track_caller]
pub(crate) fn assert_warns(loaded: &Loaded, words: &[&str]) {
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    assert_says(&loaded.warnings[0], words);
}

/// The CRC of PNG (ISO 3309), bit by bit.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 })
    })
}
