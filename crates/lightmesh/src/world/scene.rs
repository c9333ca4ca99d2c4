//! The scene that is ready for rays: checked once, with its acceleration structure, instance frames and light samples.

use fearless_simd::Level;
use glam::{Mat3, Vec3};

use super::background::Background;
use super::sheets::sheets;
use crate::Error;
use crate::bvh::{Hit, SceneBvh, flattened_meshes};
use crate::geometry::{Aabb, Ray};
use crate::light::{Emitters, LightSamples, PlaneMirror, SampledLight, plane_mirrors};
use crate::options::Limits;
use crate::scene::{AlphaMode, EmitterOptions, Light, Material, Mipmap, SceneData, build_mipmaps, validate};

/// Pairs of a lamp and a plane mirror, at most.
const MOST_MIRRORED_LIGHTS: usize = 256;

/// A checked scene with all that rays need. It does not change: a [`LightMesh`](crate::LightMesh) may outlive many
/// frames of it.
#[derive(Debug)]
pub struct Scene {
    data: SceneData,
    bvh: SceneBvh,
    instance_frames: Vec<InstanceFrame>,
    sheets: Vec<Option<Box<[bool]>>>,
    emitters: Emitters,
    emitter_options: EmitterOptions,
    mirrors: Vec<PlaneMirror>,
    /// Which lamps are seen in which plane mirrors.
    mirrored_lights: Vec<(Light, PlaneMirror)>,
    mipmaps: Vec<Mipmap>,
    opaque: Vec<bool>,
    all_opaque: bool,
    all_double_sided: bool,
    warnings: Vec<String>,
    /// What camera rays see in place of the environment.
    background: Option<Background>,
    level: Level,
}

/// The parts of an instance's transform that shading needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceFrame {
    /// Turns normals: the inverse transpose of the linear part, its sign that of the determinant, so that the front of
    /// a mirrored instance stays its front.
    pub normal_from_object: Mat3,
    /// −1 for a mirroring transform, else 1.
    pub handedness: f32,
    /// Whether object space is world space.
    pub is_identity: bool,
    /// How much the transform to object space and back may amplify a rounding error, 1 for a rotation; 0 for meshes
    /// that rays meet in world space.
    pub amplification: f32,
}

impl Scene {
    /// Checks `data` once and builds what rays need.
    ///
    /// # Errors
    /// [`Error::InvalidScene`] names the object and value that is wrong; [`Error::EmptyScene`] if there is no surface.
    pub fn new(data: SceneData) -> Result<Self, Error> {
        Self::with_emitters(data, &EmitterOptions::default())
    }

    /// Builds a scene with options for the sampling of its emitters.
    ///
    /// # Errors
    /// As [`Scene::new`], and [`Error::InvalidOption`] for options out of range.
    pub fn with_emitters(data: SceneData, emitters: &EmitterOptions) -> Result<Self, Error> {
        Self::within(data, emitters, &Limits::default())
    }

    /// Builds a scene within a limit of memory, which counts the description and what is built from it.
    ///
    /// # Errors
    /// As [`Scene::with_emitters`], and [`Error::OutOfMemory`] before anything is built if that would not fit.
    pub fn within(mut data: SceneData, emitters: &EmitterOptions, limits: &Limits) -> Result<Self, Error> {
        let mut warnings = validate::check(&mut data)?;
        warnings.extend(glossy_warning(&data.materials));
        data.check_memory(emitters, limits)?;
        // Build the acceleration structure.
        let bvh = SceneBvh::build(&data);
        if bvh.bounds().is_empty() {
            return Err(Error::EmptyScene);
        }
        // Invert the instances' transforms.
        let flat = flattened_meshes(&data);
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
                    amplification: if flat[instance.mesh] { 0.0 } else { amplification(m) },
                }
            })
            .collect();
        let opaque: Vec<bool> = data.materials.iter().map(is_opaque).collect();
        // Sample the emitters, and shrink the images.
        let emitter_options = *emitters;
        let emitters = Emitters::new(&data, &bvh, &emitter_options)?;
        let mirrors = plane_mirrors(&data);
        let mirrored_lights = mirrored(&data.lights, &mirrors);
        let mipmaps = build_mipmaps(&data);
        let level = Level::new();
        let all_opaque = opaque.iter().all(|&s| s);
        let all_double_sided = data.materials.iter().all(|material| material.double_sided);
        Ok(Self {
            emitters,
            emitter_options,
            mirrors,
            mirrored_lights,
            mipmaps,
            all_opaque,
            all_double_sided,
            sheets: sheets(&data),
            data,
            bvh,
            instance_frames: frames,
            opaque,
            warnings,
            background: None,
            level,
        })
    }

    /// Lights the scene otherwise, and keeps what does not depend on light.
    ///
    /// # Errors
    /// As [`Scene::with_emitters`].
    pub(crate) fn relit(mut self, change: impl FnOnce(&mut SceneData)) -> Result<Self, Error> {
        change(&mut self.data);
        validate::check(&mut self.data)?;
        self.emitters = Emitters::new(&self.data, &self.bvh, &self.emitter_options)?;
        self.mirrored_lights = mirrored(&self.data.lights, &self.mirrors);
        Ok(self)
    }

    /// Shows a background to camera rays that leave the scene.
    pub(crate) fn with_background(self, background: Background) -> Self {
        Self { background: Some(background), ..self }
    }

    /// The description that it was built from, repaired where [`Scene::warnings`] says so.
    pub fn data(&self) -> &SceneData {
        &self.data
    }

    /// The box around all surfaces, metres.
    pub fn bounds(&self) -> Aabb {
        self.bvh.bounds()
    }

    /// What was repaired, or cannot be shown as the author meant, one sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The acceleration structure.
    pub fn bvh(&self) -> &SceneBvh {
        &self.bvh
    }

    /// How many triangles rays can hit: those of a mesh count once for each instance.
    pub fn triangle_count(&self) -> u64 {
        self.data.instances.iter().map(|i| self.data.meshes[i.mesh].triangles.len() as u64).sum()
    }

    /// How many light samples stand for all emitters.
    pub fn light_sample_count(&self) -> u64 {
        self.emitters.all().len() as u64
    }

    /// Whether any light has a size: emission that is sampled, an environment, or punctual lights with a radius. Shadow
    /// rays then go to random points of it.
    pub fn has_lights_with_size(&self) -> bool {
        let has_balls = self.emitters.light_radius > 0.0 && !self.data.lights.is_empty();
        has_balls || self.has_visible_emitters()
    }

    /// The emitters and their samples.
    pub(crate) fn emitters(&self) -> &Emitters {
        &self.emitters
    }

    /// The options by which emitters were sampled.
    pub(crate) fn emitter_options(&self) -> &EmitterOptions {
        &self.emitter_options
    }

    /// Its largest plane mirrors.
    pub(crate) fn plane_mirrors(&self) -> &[PlaneMirror] {
        &self.mirrors
    }

    /// Punctual lights with the plane mirrors in which surfaces may see them.
    pub(crate) fn mirrored_lights(&self) -> &[(Light, PlaneMirror)] {
        &self.mirrored_lights
    }

    /// The samples of all emitters but those that are left to gather rays.
    pub(crate) fn lights(&self) -> &LightSamples {
        &self.emitters.sampled
    }

    /// Returns the radiance of a ray that leaves the scene along a unit direction, cd/m².
    pub(crate) fn environment(&self, direction: Vec3) -> Vec3 {
        self.emitters.environment.as_ref().map_or(Vec3::ZERO, |environment| environment.radiance(direction))
    }

    /// Returns the radiance that the camera sees along a ray that leaves the scene, unless it comes from a mirror.
    pub(crate) fn backdrop(&self, ray: &Ray) -> Vec3 {
        match &self.background {
            Some(background) => background.radiance(ray),
            None => self.environment(ray.direction.normalize()),
        }
    }

    /// Returns how bright a white surface is in the light of the studio, cd/m²; `None` in the scene's own light.
    pub(crate) fn white_cd_m2(&self) -> Option<f32> {
        self.background.as_ref().map(|background| background.white_cd_m2)
    }

    /// The transform of an instance for shading.
    pub(crate) fn instance_frame(&self, instance: u32) -> &InstanceFrame {
        &self.instance_frames[instance as usize]
    }

    /// Whether a triangle is part of a sheet: a transmissive surface that encloses nothing, and so stands for both faces
    /// of a thin pane.
    #[inline(always)]
    pub(crate) fn is_sheet(&self, instance: u32, triangle: u32) -> bool {
        self.sheets[instance as usize].as_ref().is_some_and(|sheet| sheet[triangle as usize])
    }

    /// Whether there are unlit surfaces.
    pub(crate) fn has_unlit(&self) -> bool {
        self.data.materials.iter().any(|material| material.unlit)
    }

    /// Whether any texture is averaged over footprints.
    pub(crate) fn averages_textures(&self) -> bool {
        self.data.materials.iter().any(|material| material.has_averaged_textures())
    }

    /// The mipmap of an image of colours.
    pub(crate) fn mipmap(&self, image: usize) -> &Mipmap {
        &self.mipmaps[image]
    }

    /// Whether a material is opaque to shadow rays.
    pub(crate) fn is_opaque(&self, material: usize) -> bool {
        self.opaque[material]
    }

    /// Whether all materials are opaque, so that any hit is a shadow.
    pub(crate) fn all_opaque(&self) -> bool {
        self.all_opaque
    }

    /// Whether all materials are double-sided, so that no surface bounds a volume.
    pub(crate) fn all_double_sided(&self) -> bool {
        self.all_double_sided
    }

    /// Whether rays can hit emitters, which are much brighter than what they light: area lights, or an environment.
    pub(crate) fn has_visible_emitters(&self) -> bool {
        !self.emitters.area.is_dark() || self.emitters.environment.is_some()
    }

    /// Whether the emission of what was hit at a position is not sampled, but left to gather rays.
    pub(crate) fn is_unsampled(&self, hit: &Hit, position: Vec3) -> bool {
        !self.emitters.area.is_sampled(&self.data, hit, position)
    }

    /// Returns a random point of what a lane of some of its lights stands for: see [`Emitters::random_point`].
    pub(crate) fn random_light(&self, lights: &LightSamples, lane: usize, at: Vec3, seed: u32) -> Option<SampledLight> {
        self.emitters.random_point(&self.data, lights, lane, at, seed)
    }

    /// Whether gather rays find emission that light samples do not stand for: that of weak emitters and of user-defined
    /// shapes, and all that is seen in mirrors.
    pub(crate) fn rays_find_emission(&self) -> bool {
        let is_mirror = |m: &Material| m.metallic >= 0.5 && !m.is_lambert() && !m.unlit;
        self.has_unsampled_emitters() || (self.has_visible_emitters() && self.data.materials.iter().any(is_mirror))
    }

    /// Whether there are emitters that are not sampled: weak ones, and user-defined shapes.
    pub(crate) fn has_unsampled_emitters(&self) -> bool {
        let emits = |m: usize| self.data.materials[m].emission != Vec3::ZERO && !self.data.materials[m].unlit;
        self.emitters.area.has_weak() || self.data.shapes.iter().any(|entry| emits(entry.material))
    }

    /// The SIMD level of this machine.
    pub(crate) fn simd_level(&self) -> Level {
        self.level
    }
}

/// Returns each lamp with each mirror, up to a number.
fn mirrored(lights: &[Light], mirrors: &[PlaneMirror]) -> Vec<(Light, PlaneMirror)> {
    let pairs = mirrors.iter().flat_map(|&mirror| lights.iter().map(move |&light| (light, mirror)));
    pairs.take(MOST_MIRRORED_LIGHTS).collect()
}

/// Returns the matrix of cofactors, det(m) · m⁻ᵀ, which transforms cross products, and so normals, even if `m` has no
/// inverse; of an m scaled by a power of two, so that a large or small scale does not leave the range of floats.
fn cofactor(m: Mat3) -> Mat3 {
    let largest = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.abs().max_element()).into_iter().fold(0.0, f32::max);
    // The exponent's bits alone; 2⁻¹²⁶ of the least numbers.
    let power_of_two = f32::from_bits(largest.to_bits() & 0x7f80_0000).max(f32::MIN_POSITIVE);
    let m = m * (1.0 / power_of_two);
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// Returns how much m · m⁻¹ may amplify a rounding error: ‖ |m| |m⁻¹| ‖∞ / 3, at least 1 (Higham, *Accuracy and
/// Stability of Numerical Algorithms*, section 7.2).
fn amplification(m: Mat3) -> f32 {
    let abs = |m: Mat3| Mat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    let product = abs(m) * abs(m.as_dmat3().inverse().as_mat3());
    ((product * Vec3::ONE).max_element() / 3.0).max(1.0)
}

fn is_opaque(material: &Material) -> bool {
    material.transmission == 0.0 && (material.alpha_mode == AlphaMode::Opaque)
}

/// Returns a warning that names the materials which are glossier than they are rendered.
fn glossy_warning(materials: &[Material]) -> Option<String> {
    let names: Vec<&str> = materials.iter().filter(|m| m.falls_back_to_lambert()).map(|m| m.name.as_str()).collect();
    let first = names.first()?;
    Some(format!(
        "{} material(s), \"{first}\" the first, are glossy; a roughness above {} is rendered as Lambert",
        names.len(),
        Material::MIRROR_ROUGHNESS
    ))
}
