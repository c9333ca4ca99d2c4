//! glTF 2.0, text and binary.
//!
//! Order of work: container, JSON, required extensions, nodes of the chosen scene, then only what they reach: buffers,
//! meshes, materials, textures, images, environment. What the scene does not use is neither decoded nor checked.

mod accessor;
mod attribute;
mod buffer;
mod camera;
mod container;
mod context;
mod cube_map;
mod environment;
mod extensions;
mod image;
mod irradiance;
mod json;
mod light;
mod material;
mod mesh;
mod node;
mod normals;
mod texture;
mod topology;
mod uri;

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec3, Vec3};
use lightmesh::geometry::Aabb;
use lightmesh::{Instance, Material, SceneData, TextureRef};

use self::buffer::Buffers;
use self::context::{Context, place};
use self::json::Document;
use self::texture::Textures;
use crate::budget::Budget;
use crate::error::{Error, one_line};
use crate::load_options::{LoadOptions, Loaded};
use crate::world_origin::{WorldOrigin, bring_near};

/// Reads a glTF that is in memory. `file` is its name for messages; URIs are looked up in `folder`, and a file that has
/// them is refused where it is `None`.
///
/// # Errors
/// As [`load`](crate::load).
pub fn load_gltf_bytes(
    file: &str,
    bytes: &[u8],
    folder: Option<&Path>,
    options: &LoadOptions,
) -> Result<Loaded, Error> {
    read(file, bytes, folder, options, Budget::new(options.max_memory))
}

/// [`load_gltf_bytes`] with what is left of a budget.
pub(crate) fn read(
    file: &str,
    bytes: &[u8],
    folder: Option<&Path>,
    options: &LoadOptions,
    budget: Budget,
) -> Result<Loaded, Error> {
    // Parse the JSON, and refuse extensions that are required and not read.
    let container = container::split(file, bytes)?;
    let mut context = Context::new(file, folder, options, budget);
    context.spend("JSON", json::parsed_bytes(container.json), 1)?;
    let document = json::parse(file, container.json)?;
    extensions::check(&mut context, &document)?;
    let uris = document.buffers.iter().map(|buffer| &buffer.uri).chain(document.images.iter().map(|image| &image.uri));
    uris.flatten().for_each(|uri| uri::note_file(&mut context, uri));

    // Nodes: which meshes, lights and cameras the chosen scene has, and where.
    let visit = node::visit(&mut context, &document)?;
    let buffers = Buffers::open(&mut context, &document, container.binary)?;
    let mut data =
        SceneData { cameras: camera::cameras(&mut context, &document, &visit.cameras)?, ..SceneData::default() };

    // Meshes that the scene uses, each decoded once, then their places.
    let mut materials = Used::default();
    let (mut loaded, mut shifts) = (BTreeMap::new(), Vec::new());
    for &mesh in visit.meshes.iter().map(|placed| &placed.index) {
        if let std::collections::btree_map::Entry::Vacant(entry) = loaded.entry(mesh) {
            let mut primitives = mesh::primitives(&mut context, &buffers, mesh, &mut materials)?;
            shifts.extend(primitives.iter_mut().map(bring_near));
            let first = data.meshes.len();
            data.meshes.extend(primitives);
            entry.insert(first..data.meshes.len());
        }
    }
    let bounds: Vec<Aabb> = data.meshes.iter().map(|mesh| mesh.bounds()).collect();
    data.origin = world_origin(&visit, &loaded, &shifts, &bounds);
    data.lights = light::lights(&mut context, &document, &visit.lights, data.origin)?;
    place_meshes(&mut context, &document, &visit.meshes, &Loading { loaded, shifts, bounds }, &mut data)?;
    if data.instances.is_empty() {
        let what = match visit.meshes.is_empty() {
            true => "no node of the scene has a mesh; is it the right file and scene?",
            false => "the scene's meshes have no triangles that could be seen; does it hold only points or lines?",
        };
        return Err(Error::Empty { file: one_line(file), what: what.into() });
    }

    // Materials of those meshes, the textures of those materials, the images of those textures.
    let mut textures = Textures::default();
    context.spend("materials", materials.order.len() as u64, size_of::<Material>() as u64)?;
    data.materials.reserve_exact(materials.order.len());
    for &material in &materials.order {
        data.materials.push(material::material(&mut context, &document, material, &mut textures)?);
    }
    let shown = image::decode(&mut context, &buffers, textures)?;
    leave_out(&mut data.materials, &shown.index_of);
    (data.textures, data.images) = (shown.textures, shown.images);
    data.environment = environment::environment(&mut context, &buffers, visit.scene)?;
    warn_of_missing_uvs(&mut context, &data);

    if !document.animations.is_empty() {
        context.warnings.add("animations", "animations are not read: nodes stay where the file puts them");
    }
    Ok(Loaded { data, warnings: context.warnings.into_sentences(), files: context.files })
}

/// Numbers keys in the order in which they are first used.
#[derive(Debug)]
struct Used<K> {
    order: Vec<K>,
    index: BTreeMap<K, usize>,
}

impl<K> Default for Used<K> {
    fn default() -> Self {
        Self { order: Vec::new(), index: BTreeMap::new() }
    }
}

impl<K: Copy + Ord> Used<K> {
    /// Returns the key's number.
    fn number(&mut self, key: K) -> usize {
        *self.index.entry(key).or_insert_with(|| {
            self.order.push(key);
            self.order.len() - 1
        })
    }
}

/// The meshes that were read.
struct Loading {
    /// Of each of the file's meshes, those that its primitives have become.
    loaded: BTreeMap<usize, std::ops::Range<usize>>,
    /// By how much each was moved towards the origin of its own space.
    shifts: Vec<DVec3>,
    /// The box around each.
    bounds: Vec<Aabb>,
}

/// Chooses the origin of the scene: by the middles of meshes, and where there are two minds, by lights and cameras.
fn world_origin(
    visit: &node::Visit,
    loaded: &BTreeMap<usize, std::ops::Range<usize>>,
    shifts: &[DVec3],
    bounds: &[Aabb],
) -> DVec3 {
    let middle = |mesh: usize| bounds[mesh].center().as_dvec3() + shifts[mesh];
    let placed = |placed: &node::Placed| {
        let world_from_node = placed.world_from_node;
        loaded[&placed.index].clone().map(move |mesh| world_from_node.transform_point3(middle(mesh)))
    };
    let meshes: Vec<DVec3> = visit.meshes.iter().flat_map(placed).collect();
    let places = |placed: &[node::Placed]| placed.iter().map(node::Placed::place).collect::<Vec<_>>();
    let mut origin = WorldOrigin::default();
    origin.add(&meshes, 1.0);
    origin.add(&places(&visit.lights), 0.25);
    origin.add(&places(&visit.cameras), 0.25);
    origin.choose()
}

/// One instance per node and primitive. An instance without volume to stand in, or outside what f32 can hold, is not
/// rendered.
fn place_meshes(
    context: &mut Context<'_>,
    document: &Document,
    placed: &[node::Placed],
    loading: &Loading,
    data: &mut SceneData,
) -> Result<(), Error> {
    let Loading { loaded, shifts, bounds } = loading;
    let instances: usize = placed.iter().map(|placed| loaded[&placed.index].len()).sum();
    context.spend("instances of meshes", instances as u64, size_of::<Instance>() as u64)?;
    data.instances.reserve_exact(instances);
    for placed in placed {
        let node_place = place("node", placed.node, document.nodes[placed.node].name.as_deref());
        // A determinant that underflows has no inverse in f32, and a surface that is scaled to nothing cannot be seen.
        if !placed.shifted_to(DVec3::ZERO, data.origin).matrix3.determinant().is_normal() {
            context.warnings.add(node_place, "its scale is zero in some direction: its mesh is left out");
            continue;
        }
        for mesh in loaded[&placed.index].clone() {
            let world_from_object = placed.shifted_to(shifts[mesh], data.origin);
            let world = bounds[mesh].transformed(&world_from_object);
            if !(world.min.is_finite() && world.max.is_finite()) {
                return Err(context
                    .invalid(node_place, "its mesh's positions leave the range of 32-bit floats; check its scale"));
            }
            data.instances.push(Instance { mesh, world_from_object });
        }
    }
    Ok(())
}

/// Renumbers the textures that materials use; one without a new number is left out, its factor stays. Only emission
/// goes with its texture: a whole wall would shine where the author painted a screen.
fn leave_out(materials: &mut [Material], index_of: &[Option<usize>]) {
    for material in materials {
        let painted = material.emission_texture.is_some();
        for slot in material.textures_mut() {
            *slot = slot.and_then(|old| Some(TextureRef { texture: index_of[old.texture]?, ..old }));
        }
        if painted && material.emission_texture.is_none() {
            material.emission = Vec3::ZERO;
        }
    }
}

/// Warns about textured materials on meshes without the texture coordinates: they show one texel everywhere.
fn warn_of_missing_uvs(context: &mut Context<'_>, data: &SceneData) {
    for mesh in &data.meshes {
        let material = &data.materials[mesh.material];
        if material.textures().iter().flatten().any(|reference| mesh.uvs[reference.uv_set].is_empty()) {
            let message = "its material has a texture, but the mesh has no texture coordinates for it";
            context.warnings.add(format_args!("mesh {:?}", mesh.name), message);
        }
    }
}
