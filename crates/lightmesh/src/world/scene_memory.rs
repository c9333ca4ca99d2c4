//! How much memory a scene takes, held and while it is built.

use std::collections::HashMap;

use super::scene::Scene;
use crate::bvh::flattened_meshes;
use crate::geometry::TriangleMesh;
use crate::options::Limits;
use crate::scene::{EmitterOptions, ImageData, Instance, SceneData, Texels};
use crate::{Error, Light};

/// The most that the tree over a triangle takes while it is built, bytes: its corners, its box and a part's, two nodes of
/// each of three trees, and the blocks. Measured: 390 to 490, with few and many triangles, small and large ones
/// (lightmesh-io, tests/memory.rs).
const BUILDING_PER_TRIANGLE: u64 = 512;

/// What is held of it afterwards, bytes. Measured: 75 to 126.
const HELD_PER_TRIANGLE: u64 = 144;

/// The same of an instance of a mesh with a tree of its own, and of a sphere or a shape.
const BUILDING_PER_OBJECT: u64 = 768;
const HELD_PER_OBJECT: u64 = 320;

/// Pieces, strata and light samples of an emissive triangle, of a lamp, and of what is sampled of one light.
const PER_EMISSIVE_TRIANGLE: u64 = 160;
const PER_LAMP: u64 = 512;
const PER_SAMPLE: u64 = 256;

/// What a triangle's corners take while parts that are closed are told from sheets.
const SHEETS_PER_TRIANGLE: u64 = 256;

/// Meshes whose trees are built at the same time, at most.
const TOGETHER: u64 = 16;

impl TriangleMesh {
    /// Memory held, bytes.
    pub fn bytes(&self) -> u64 {
        let uvs: usize = self.uvs.iter().map(|uvs| size_of_val(uvs.as_slice())).sum();
        let vertices = size_of_val(self.positions.as_slice()) + size_of_val(self.normals.as_slice()) + uvs;
        let colors = size_of_val(self.tangents.as_slice()) + size_of_val(self.colors.as_slice());
        (vertices + colors + size_of_val(self.triangles.as_slice()) + size_of::<Self>() + self.name.len()) as u64
    }
}

impl ImageData {
    /// Memory held, bytes; without smaller copies.
    pub fn bytes(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * self.texel_bytes()
    }

    fn texel_bytes(&self) -> u64 {
        match self.texels {
            Texels::Rgba8(_) => 4,
            Texels::Rgba32F(_) => 16,
        }
    }
}

impl SceneData {
    /// Memory held by meshes, instances, images and lights, bytes.
    pub fn bytes(&self) -> u64 {
        let meshes: u64 = self.meshes.iter().map(TriangleMesh::bytes).sum();
        let images: u64 = self.images.iter().map(ImageData::bytes).sum();
        let environment = self.environment.as_ref().and_then(|e| e.map.as_ref()).map_or(0, ImageData::bytes);
        let lists = self.instances.len() * size_of::<Instance>() + self.lights.len() * size_of::<Light>();
        meshes + images + environment + lists as u64
    }

    /// Counts triangles as trees hold them: once for each instance of a mesh that is copied into the world, else once.
    /// Returns the number of all, and of the largest trees that are built together.
    fn triangles_in_trees(&self) -> (u64, u64) {
        let flat = flattened_meshes(self);
        let in_world: u64 =
            self.instances.iter().filter(|i| flat[i.mesh]).map(|i| self.meshes[i.mesh].triangles.len() as u64).sum();
        let own =
            self.meshes.iter().zip(&flat).filter(|(_, flat)| !**flat).map(|(mesh, _)| mesh.triangles.len() as u64);
        let (sum, largest) = own.fold((0, 0), |(sum, largest): (u64, u64), n| (sum + n, largest.max(n)));
        (in_world + sum, in_world.max(sum.min(TOGETHER * largest)))
    }

    /// What is held of the built scene beside the description and its trees, bytes: smaller copies of images, and samples
    /// of lights.
    pub(super) fn bytes_of_extras(&self, emitters: &EmitterOptions) -> u64 {
        // Images of colours that are averaged.
        let mut averaged: HashMap<usize, u64> = HashMap::new();
        for r in self.materials.iter().flat_map(|material| material.averaged_textures()).flatten() {
            let image = self.textures.get(r.texture).and_then(|texture| self.images.get(texture.image));
            if let Some(image) = image {
                let texels = ImageData::mipmap_texels(image.width, image.height);
                averaged.insert(r.texture, texels * image.texel_bytes());
            }
        }
        // Emissive surfaces.
        let emits = |mesh: usize| {
            let material = self.meshes.get(mesh).and_then(|mesh| self.materials.get(mesh.material));
            material.is_some_and(|material| material.emission.max_element() > 0.0)
        };
        let emissive = self.instances.iter().filter(|instance| emits(instance.mesh));
        let (lights, triangles) = emissive.fold((0, 0), |(lights, triangles), instance| {
            (lights + 1, triangles + self.meshes[instance.mesh].triangles.len() as u64)
        });
        let lamps =
            self.lights.len() as u64 * if emitters.light_radius > 0.0 { emitters.light_samples.into() } else { 1 };
        averaged.values().sum::<u64>()
            + triangles * PER_EMISSIVE_TRIANGLE
            + lights * u64::from(emitters.light_samples) * PER_SAMPLE
            + lamps * PER_LAMP
    }

    /// Refuses a description that a limit does not hold together with what is built from it.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; nothing has been allocated.
    pub(super) fn check_memory(&self, emitters: &EmitterOptions, limits: &Limits) -> Result<(), Error> {
        let (all, together) = self.triangles_in_trees();
        let objects = (self.instances.len() + self.spheres.len() + self.shapes.len()) as u64;
        let is_glass = |mesh: &TriangleMesh| self.materials.get(mesh.material).is_some_and(|m| m.transmission > 0.0);
        let glass: u64 = self.meshes.iter().filter(|mesh| is_glass(mesh)).map(|mesh| mesh.triangles.len() as u64).sum();
        let building =
            together * (BUILDING_PER_TRIANGLE - HELD_PER_TRIANGLE) + objects * (BUILDING_PER_OBJECT - HELD_PER_OBJECT);
        let held = all * HELD_PER_TRIANGLE + objects * HELD_PER_OBJECT;
        let extras = self.bytes_of_extras(emitters);
        // The trees are built first, and what their building took is free again.
        let needed_bytes = self.bytes() + held + building.max(extras + glass * SHEETS_PER_TRIANGLE);
        if needed_bytes <= limits.max_memory {
            return Ok(());
        }
        Err(Error::OutOfMemory {
            what: "building the scene",
            needed_bytes,
            limit_bytes: limits.max_memory,
            advice: "use fewer triangles, lights or texels",
        })
    }
}

impl Scene {
    /// Memory held, bytes; an estimate of what lights and smaller copies of images take.
    pub fn bytes(&self) -> u64 {
        let objects = self.data().instances.len() as u64 * HELD_PER_OBJECT;
        self.data().bytes() + self.bvh().bytes() + self.data().bytes_of_extras(self.emitter_options()) + objects
    }
}
