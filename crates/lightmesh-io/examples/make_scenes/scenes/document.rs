//! A scene on its way to a glTF 2.0 binary file.

use serde_json::{Value, json};

use super::surface::{Surface, Vec3, cross, normalize, sub};

/// A point light.
pub(crate) struct PointLight {
    /// Metres.
    pub(crate) position: Vec3,
    /// Linear RGB, the largest at most 1 as glTF asks.
    pub(crate) color: Vec3,
    /// Candela.
    pub(crate) intensity: f64,
}

/// Parallel light.
pub(crate) struct Sun {
    /// The way it shines, of any length.
    pub(crate) direction: Vec3,
    /// Linear RGB, the largest at most 1 as glTF asks.
    pub(crate) color: Vec3,
    /// On a surface that faces it, lux.
    pub(crate) illuminance: f64,
}

/// A perspective camera.
pub(crate) struct Camera {
    /// Where it stands, metres.
    pub(crate) eye: Vec3,
    /// What it looks at, metres.
    pub(crate) target: Vec3,
    /// Vertical field of view, radians.
    pub(crate) yfov: f64,
    /// Width over height.
    pub(crate) aspect: f64,
}

/// One part of a mesh: a surface with its material.
struct Primitive {
    surface: Surface,
    material: usize,
}

/// Meshes, their places, lights and one camera.
pub(crate) struct Document {
    name: &'static str,
    camera: Camera,
    materials: Vec<Value>,
    meshes: Vec<(&'static str, Vec<Primitive>)>,
    places: Vec<(usize, Vec3)>,
    lights: Vec<PointLight>,
    suns: Vec<Sun>,
}

impl Document {
    /// An empty scene.
    pub(crate) fn new(name: &'static str, camera: Camera) -> Self {
        let (materials, meshes, places) = (Vec::new(), Vec::new(), Vec::new());
        Self { name, camera, materials, meshes, places, lights: Vec::new(), suns: Vec::new() }
    }

    /// Adds a Lambertian material and returns its index; `sides` = 2 for sheets that are seen from both.
    pub(crate) fn lambert(&mut self, name: &str, albedo: Vec3, sides: u8) -> usize {
        self.materials.push(json!({
            "doubleSided": sides == 2,
            "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [albedo[0], albedo[1], albedo[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0,
            },
        }));
        self.materials.len() - 1
    }

    /// Adds a material that shines with a luminance, cd/m², in a colour, from its front.
    pub(crate) fn emitter(&mut self, name: &str, color: Vec3, luminance: f64) -> usize {
        self.materials.push(json!({
            "emissiveFactor": color,
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": luminance},
                "KHR_materials_specular": {"specularFactor": 0.0},
            },
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.0, 0.0, 0.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0,
            },
        }));
        self.materials.len() - 1
    }

    /// Adds clear glass.
    pub(crate) fn glass(&mut self, name: &str) -> usize {
        self.materials.push(json!({
            "doubleSided": true,
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}},
            "name": name,
            "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.0},
        }));
        self.materials.len() - 1
    }

    /// Adds a mesh that stands where its coordinates say.
    pub(crate) fn place(&mut self, name: &'static str, surface: Surface, material: usize) {
        self.place_copies(name, vec![(surface, material)], &[[0.0; 3]]);
    }

    /// Adds a mesh once and puts it at each of the places.
    pub(crate) fn place_copies(&mut self, name: &'static str, parts: Vec<(Surface, usize)>, at: &[Vec3]) {
        let primitives = parts.into_iter().map(|(surface, material)| Primitive { surface, material }).collect();
        self.meshes.push((name, primitives));
        self.places.extend(at.iter().map(|&translation| (self.meshes.len() - 1, translation)));
    }

    /// Adds a light.
    pub(crate) fn light(&mut self, light: PointLight) {
        self.lights.push(light);
    }

    /// Adds parallel light.
    pub(crate) fn sun(&mut self, sun: Sun) {
        self.suns.push(sun);
    }

    /// The extensions that the file uses, in the order of the alphabet.
    fn extensions(&self) -> Vec<&str> {
        let of_materials = self.materials.iter().filter_map(|material| material["extensions"].as_object());
        let mut used: Vec<&str> = of_materials.flat_map(|extensions| extensions.keys()).map(String::as_str).collect();
        used.push("KHR_lights_punctual");
        used.sort_unstable();
        used.dedup();
        used
    }

    /// Triangles in the world: those of a mesh count at each of its places.
    pub(crate) fn triangle_count(&self) -> usize {
        let of_mesh = |&(mesh, _): &(usize, Vec3)| -> usize {
            self.meshes[mesh].1.iter().map(|p| p.surface.triangles.len()).sum()
        };
        self.places.iter().map(of_mesh).sum()
    }

    /// The file's bytes: header, JSON chunk, binary chunk.
    pub(crate) fn to_glb(&self) -> Vec<u8> {
        let mut binary = Binary::default();
        let meshes: Vec<Value> = self.meshes.iter().map(|(name, parts)| binary.mesh(name, parts)).collect();
        let (nodes, cameras) = (self.nodes(), self.cameras());
        let mut lights: Vec<Value> = self
            .lights
            .iter()
            .map(|l| json!({"color": l.color.map(round), "intensity": round(l.intensity), "type": "point"}))
            .collect();
        lights.extend(self.suns.iter().map(
            |sun| json!({"color": sun.color.map(round), "intensity": round(sun.illuminance), "type": "directional"}),
        ));
        let document = json!({
            "accessors": binary.accessors,
            "asset": {
                "copyright": "CC0-1.0, the Lightmesh developers",
                "extras": {"license": "CC0-1.0"},
                "generator": "lightmesh make_scenes",
                "version": "2.0",
            },
            "bufferViews": binary.views,
            "buffers": [{"byteLength": binary.bytes.len()}],
            "cameras": cameras,
            "extensions": {"KHR_lights_punctual": {"lights": lights}},
            "extensionsUsed": self.extensions(),
            "materials": self.materials,
            "meshes": meshes,
            "nodes": nodes,
            "scene": 0,
            "scenes": [{"name": self.name, "nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        });
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');

        let total = 12 + 8 + text.len() + 8 + binary.bytes.len();
        let mut glb = Vec::with_capacity(total);
        glb.extend(b"glTF");
        let word = |glb: &mut Vec<u8>, value: usize| glb.extend((value as u32).to_le_bytes());
        word(&mut glb, 2);
        word(&mut glb, total);
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &binary.bytes)] {
            word(&mut glb, chunk.len());
            glb.extend(kind);
            glb.extend(chunk);
        }
        glb
    }

    /// Meshes at their places, then the lights, then the camera.
    fn nodes(&self) -> Vec<Value> {
        let place = |&(mesh, translation): &(usize, Vec3)| {
            let name = self.meshes[mesh].0;
            if translation == [0.0; 3] {
                json!({"mesh": mesh, "name": name})
            } else {
                json!({"mesh": mesh, "name": name, "translation": translation})
            }
        };
        let light = |(i, l): (usize, &PointLight)| {
            json!({
                "extensions": {"KHR_lights_punctual": {"light": i}},
                "name": format!("light {i}"),
                "translation": l.position.map(round),
            })
        };
        let mut nodes: Vec<Value> = self.places.iter().map(place).collect();
        nodes.extend(self.lights.iter().enumerate().map(light));
        nodes.extend((self.lights.len()..).zip(&self.suns).map(|(i, sun)| {
            // The shortest turn from −Z to its direction, as a quaternion.
            let [x, y, z] = normalize(sun.direction);
            let turn = [y, -x, 0.0, 1.0 - z];
            let length = turn.iter().map(|c| c * c).sum::<f64>().sqrt();
            json!({
                "extensions": {"KHR_lights_punctual": {"light": i}},
                "name": "sun",
                "rotation": turn.map(|c| round(c / length)),
                "translation": [0.0, 0.0, 0.0],
            })
        }));

        // A camera looks along its own −Z, +Y is up; columns of `matrix` are its axes in the world.
        let back = normalize(sub(self.camera.eye, self.camera.target));
        let right = normalize(cross([0.0, 1.0, 0.0], back));
        let up = cross(back, right);
        let columns = [(right, 0.0), (up, 0.0), (back, 0.0), (self.camera.eye, 1.0)];
        let matrix: Vec<f64> = columns.iter().flat_map(|(v, w)| [v[0], v[1], v[2], *w]).collect();
        nodes.push(json!({"camera": 0, "matrix": matrix, "name": "main"}));
        nodes
    }

    fn cameras(&self) -> Value {
        let Camera { yfov, aspect, .. } = self.camera;
        let lens = json!({"aspectRatio": aspect, "yfov": yfov, "zfar": 1000.0, "znear": 0.01});
        json!([{"name": "main", "perspective": lens, "type": "perspective"}])
    }
}

/// Six decimals: what a reader of the JSON wants to see.
fn round(x: f64) -> f64 {
    libm::round(x * 1e6) / 1e6
}

/// The binary chunk and what describes it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    /// Writes a mesh's arrays and returns its JSON.
    fn mesh(&mut self, name: &str, parts: &[Primitive]) -> Value {
        let primitives: Vec<Value> = parts
            .iter()
            .map(|part| {
                let Surface { positions, normals, triangles } = &part.surface;
                let indices = self.indices(triangles);
                let position = self.vectors(positions);
                let normal = self.vectors(normals);
                json!({
                    "attributes": {"NORMAL": normal, "POSITION": position},
                    "indices": indices,
                    "material": part.material,
                })
            })
            .collect();
        json!({"name": name, "primitives": primitives})
    }

    /// An accessor of three floats per element, with the bounds that positions need.
    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let fold = |start: f32, pick: fn(f32, f32) -> f32| -> [f32; 3] {
            [0, 1, 2].map(|axis| vectors.iter().fold(start, |best, v| pick(best, v[axis])))
        };
        let (min, max) = (fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max));
        let view = self.view(vectors.iter().flatten().flat_map(|x| x.to_le_bytes()), 34962);
        self.accessors.push(json!({
            "bufferView": view, "componentType": 5126, "count": vectors.len(), "max": max, "min": min, "type": "VEC3",
        }));
        self.accessors.len() - 1
    }

    /// An accessor of 16-bit indices.
    fn indices(&mut self, triangles: &[[u16; 3]]) -> usize {
        let view = self.view(triangles.iter().flatten().flat_map(|i| i.to_le_bytes()), 34963);
        let count = 3 * triangles.len();
        self.accessors.push(json!({"bufferView": view, "componentType": 5123, "count": count, "type": "SCALAR"}));
        self.accessors.len() - 1
    }

    /// A view of new bytes, starting and ending on a multiple of four.
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: u32) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": 0, "byteLength": length, "byteOffset": offset, "target": target}));
        self.views.len() - 1
    }
}
