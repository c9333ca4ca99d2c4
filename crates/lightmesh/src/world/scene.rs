//! The scene that is ready for rays: checked once, with its acceleration structure, placed frames and light samples.

use fearless_simd::Level;
use glam::{Mat3, Vec3};

use crate::Error;
use crate::bvh::{SceneBvh, Target};
use crate::geometry::Aabb;
use crate::light::{Emitters, LightSamples};
use crate::scene::{AlphaMode, EmitterOptions, Material, Mipmap, SceneData, build_mipmaps, validate};

/// A checked scene with all that rays need. It does not change: a [`LightMesh`](crate::LightMesh) may outlive many
/// frames of it.
#[derive(Debug)]
pub struct Scene {
    data: SceneData,
    bvh: SceneBvh,
    frames: Vec<InstanceFrame>,
    emitters: Emitters,
    emitter_options: EmitterOptions,
    pyramids: Vec<Mipmap>,
    solid: Vec<bool>,
    all_solid: bool,
    all_double_sided: bool,
    warnings: Vec<String>,
    level: Level,
}

/// How an instance turns object space into world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceFrame {
    /// Turns normals: the inverse transpose of the linear part, its sign that of the determinant, so that the front of a
    /// mirrored instance stays its front.
    pub normal_from_object: Mat3,
    /// −1 for a mirroring transform, else 1.
    pub handedness: f32,
    /// Whether object space is world space.
    pub is_identity: bool,
}

impl Scene {
    /// Checks `data` once and builds what rays need.
    ///
    /// # Errors
    /// [`Error::InvalidScene`] names the object and value that is wrong; [`Error::EmptyScene`] if there is no surface.
    pub fn new(data: SceneData) -> Result<Self, Error> {
        Self::with_emitters(data, &EmitterOptions::default())
    }

    /// [`Scene::new`] with a say in how emitters become light samples.
    ///
    /// # Errors
    /// As [`Scene::new`], and [`Error::InvalidOption`] for options out of range.
    pub fn with_emitters(mut data: SceneData, emitters: &EmitterOptions) -> Result<Self, Error> {
        let mut warnings = validate::check(&mut data)?;
        warnings.extend(glossy_warning(&data.materials));
        let bvh = SceneBvh::build(&data);
        if bvh.bounds().is_empty() {
            return Err(Error::EmptyScene);
        }
        let frames = data
            .instances
            .iter()
            .map(|instance| {
                let m = Mat3::from(instance.world_from_object.matrix3);
                let handedness = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
                InstanceFrame {
                    normal_from_object: cofactor(m),
                    handedness,
                    is_identity: instance.world_from_object == glam::Affine3A::IDENTITY,
                }
            })
            .collect();
        let solid: Vec<bool> = data.materials.iter().map(blocks_light_fully).collect();
        let emitter_options = *emitters;
        let emitters = Emitters::new(&data, &bvh.bounds(), &emitter_options)?;
        let pyramids = build_mipmaps(&data);
        let level = Level::new();
        let all_solid = solid.iter().all(|&s| s);
        let all_double_sided = data.materials.iter().all(|material| material.double_sided);
        Ok(Self {
            emitters,
            emitter_options,
            pyramids,
            all_solid,
            all_double_sided,
            data,
            bvh,
            frames,
            solid,
            warnings,
            level,
        })
    }

    /// The description it was built from, mended where [`Scene::warnings`] says so.
    pub fn data(&self) -> &SceneData {
        &self.data
    }

    /// The box around all surfaces, metres.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// What was mended or cannot be shown as the author meant, one sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The acceleration structure.
    pub fn bvh(&self) -> &SceneBvh {
        &self.bvh
    }

    /// Triangles that are in view of rays: those of a mesh count once per instance.
    pub fn triangle_count(&self) -> u64 {
        self.data.instances.iter().map(|i| self.data.meshes[i.mesh].triangles.len() as u64).sum()
    }

    /// How many light samples stand for all emitters.
    pub fn light_sample_count(&self) -> u64 {
        self.emitters.all().len() as u64
    }

    /// Everything that shines and has a size.
    pub(crate) fn emitters(&self) -> &Emitters {
        &self.emitters
    }

    /// How they became light samples.
    pub(crate) fn emitter_options(&self) -> &EmitterOptions {
        &self.emitter_options
    }

    /// The samples of all emitters but those that gather rays find.
    pub(crate) fn lights(&self) -> &LightSamples {
        &self.emitters.sampled
    }

    /// What a ray sees that leaves the scene along a unit direction, cd/m².
    pub(crate) fn environment(&self, direction: Vec3) -> Vec3 {
        self.emitters.environment.as_ref().map_or(Vec3::ZERO, |environment| environment.radiance(direction))
    }

    pub(crate) fn frame(&self, instance: u32) -> &InstanceFrame {
        &self.frames[instance as usize]
    }

    /// Whether any texture is averaged over what a sample sees of it.
    pub(crate) fn averages_textures(&self) -> bool {
        self.data.materials.iter().any(|material| material.has_averaged_textures())
    }

    /// The smaller copies of an image of colours.
    pub(crate) fn pyramid(&self, image: usize) -> &Mipmap {
        &self.pyramids[image]
    }

    /// Whether a material stops every shadow ray.
    pub(crate) fn is_solid(&self, material: usize) -> bool {
        self.solid[material]
    }

    /// Whether all do, so that any hit is a shadow.
    pub(crate) fn all_opaque(&self) -> bool {
        self.all_solid
    }

    /// Whether no material has a back: nothing has an inside.
    pub(crate) fn all_double_sided(&self) -> bool {
        self.all_double_sided
    }

    /// Whether anything shines that is much brighter than what it lights: lamps with a size, or a sky.
    pub(crate) fn has_lamps(&self) -> bool {
        !self.emitters.area.is_dark() || self.emitters.environment.is_some()
    }

    /// Whether a surface's emission is found by gather rays alone.
    pub(crate) fn is_gathered(&self, target: Target) -> bool {
        !self.emitters.area.is_sampled(target)
    }

    /// Whether there is any such surface.
    pub(crate) fn has_gathered_emitters(&self) -> bool {
        let emits = |m: usize| self.data.materials[m].emission != Vec3::ZERO && !self.data.materials[m].unlit;
        self.emitters.area.has_gathered() || self.data.shapes.iter().any(|entry| emits(entry.material))
    }

    pub(crate) fn simd_level(&self) -> Level {
        self.level
    }
}

/// The matrix of cofactors, det(m) · m⁻ᵀ: turns cross products, and so normals, even where `m` has no inverse.
fn cofactor(m: Mat3) -> Mat3 {
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

fn blocks_light_fully(material: &Material) -> bool {
    material.transmission == 0.0 && (material.alpha_mode == AlphaMode::Opaque)
}

/// Says which materials are glossier than what is rendered.
fn glossy_warning(materials: &[Material]) -> Option<String> {
    let names: Vec<&str> = materials.iter().filter(|m| m.falls_back_to_lambert()).map(|m| m.name.as_str()).collect();
    let first = names.first()?;
    Some(format!(
        "{} material(s), \"{first}\" the first, are glossy; a roughness above {} is rendered as Lambert",
        names.len(),
        Material::MIRROR_ROUGHNESS
    ))
}
