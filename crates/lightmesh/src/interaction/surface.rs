//! The surface at a hit: position, normals and the numbers of the reflection model.

use glam::{Vec3, Vec4};

use super::fresnel::Reflectances;
use super::hit_geometry::{SurfaceInteraction, intersect_geometry};
use super::ray_footprint::footprints;
use crate::AlphaMode;
use crate::bvh::{Hit, Target};
use crate::geometry::{Cone, Ray, offset_origin};
use crate::scene::{ColorEncoding, Material, TextureRef};
use crate::world::Scene;

/// The cosine to the triangle's normal above which light needs no help over its edge: that of Cycles' `Shading Offset`.
const GRAZING: f32 = 0.1;

/// A surface point to be lit: what direct and indirect lighting need to know of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadingPoint {
    /// Metres, world space.
    pub position: Vec3,
    /// Unit shading normal, on the viewer's side.
    pub n: Vec3,
    /// Unit geometric normal, on the viewer's side.
    pub ng: Vec3,
    /// How far off the surface its rays start, metres.
    pub offset: f32,
    /// From the point to the curved surface that smooth normals pretend, metres.
    pub bulge: Vec3,
    /// Radiance that reaches the start of the path, at the film or along a gather ray, per unit of irradiance here:
    /// throughput · albedo / π.
    pub weight: Vec3,
    /// Whatever the tracer numbers its paths by: the film's pixel, or the index of the gather ray.
    pub id: u32,
}

impl ShadingPoint {
    /// Returns where a ray along `direction` starts: off the surface on that side.
    pub(crate) fn origin_towards(&self, direction: Vec3) -> Vec3 {
        offset_origin(self.position, self.ng, self.offset, direction)
    }

    /// Returns where a ray starts along which light arrives from a direction above the shading normal's horizon. Of a
    /// curved surface made of flat triangles it may be below the triangle's: such a ray starts on the surface that the
    /// normals pretend, on the viewer's side, and so meets whatever really is in its way. Grazing directions blend
    /// between the two, as Cycles' do.
    #[inline(always)]
    pub(crate) fn light_origin(&self, direction: Vec3) -> Vec3 {
        if self.bulge == Vec3::ZERO {
            return self.origin_towards(direction);
        }
        let cos = self.ng.dot(direction) / direction.length();
        let share = (1.0 - cos * (1.0 / GRAZING)).clamp(0.0, 1.0);
        self.position + self.ng * self.offset + self.bulge * share
    }
}

/// A hit, evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadedHit {
    pub position: Vec3,
    pub n: Vec3,
    pub ng: Vec3,
    pub offset: f32,
    /// As of [`ShadingPoint`].
    pub bulge: Vec3,
    /// The fraction of the ray that meets the surface; the rest goes on.
    pub opacity: f32,
    /// Radiance towards the viewer, cd/m²: emission, or the colour of an unlit surface.
    pub emission: Vec3,
    /// The part of it that lights other surfaces: none for unlit ones.
    pub illuminating: Vec3,
    /// Lambertian albedo.
    pub diffuse: Vec3,
    /// Albedo of the mirror direction.
    pub mirror: Vec3,
    /// Albedo of the refracted direction.
    pub refraction: Vec3,
    /// The refracted direction; the ray's own where nothing is refracted.
    pub refracted: Vec3,
}

impl ShadedHit {
    /// The surface as a point to be lit, which path number `id` has reached with throughput `beta`.
    pub(crate) fn shading_point(&self, beta: Vec3, id: u32) -> ShadingPoint {
        ShadingPoint {
            position: self.position,
            n: self.n,
            ng: self.ng,
            offset: self.offset,
            bulge: self.bulge,
            weight: beta * self.diffuse * std::f32::consts::FRAC_1_PI,
            id,
        }
    }

    /// Returns the mirror direction of an arriving `direction`; about the geometric normal where the shading normal
    /// would send it into the surface.
    pub(crate) fn reflect(&self, direction: Vec3) -> Vec3 {
        let d = direction.normalize();
        let about = |n: Vec3| d - n * (2.0 * n.dot(d));
        let mirrored = about(self.n);
        if mirrored.dot(self.ng) > 0.0 { mirrored } else { about(self.ng) }
    }

    /// A ray from the surface along `direction`.
    pub(crate) fn spawn_ray(&self, direction: Vec3) -> Ray {
        Ray::new(offset_origin(self.position, self.ng, self.offset, direction), direction)
    }
}

/// Evaluates what `ray` hit, its textures at a point.
pub(crate) fn evaluate(scene: &Scene, ray: &Ray, hit: &Hit) -> ShadedHit {
    evaluate_at(scene, ray, &intersect_geometry(scene, ray, hit))
}

/// Evaluates what `ray` hit, its colours averaged over what the cone about it covers. Normal maps and the maps of
/// roughness, metal and transmission are looked up at a point: they act on light through curves and thresholds, and
/// the picture of a mean is not the mean of pictures.
pub(crate) fn evaluate_footprint(scene: &Scene, ray: &Ray, cone: Cone, hit: &Hit) -> ShadedHit {
    let mut interaction = intersect_geometry(scene, ray, hit);
    interaction.footprints = footprints(scene, ray, cone, hit, &interaction);
    evaluate_at(scene, ray, &interaction)
}

/// Evaluates the material where a ray hit; the model is documented at [`Material`].
fn evaluate_at(scene: &Scene, ray: &Ray, interaction: &SurfaceInteraction<'_>) -> ShadedHit {
    // Look up opacity and colours.
    let material = &scene.data().materials[interaction.material];
    let n = bumped_normal(scene, material, interaction);
    let base = base_color(scene, material, interaction);
    let opacity = material_opacity(material, base.w);
    let base = base.truncate();
    if material.unlit {
        return ShadedHit { emission: base, ..plain(interaction, n, opacity) };
    }
    // The back of a single-sided surface shades, as Mitsuba's and Cycles' do, but does not shine, as Mitsuba's area
    // lights.
    let shines = interaction.front || material.double_sided;
    let emission = if shines { emission(scene, material, interaction) } else { Vec3::ZERO };
    let lambert = ShadedHit { emission, illuminating: emission, diffuse: base, ..plain(interaction, n, opacity) };
    if material.is_lambert() {
        return lambert;
    }

    // Look up what makes mirrors and glass.
    let rough_metal = linear_texture(scene, material.metallic_roughness_texture, interaction);
    let (roughness, metallic) = (material.roughness * rough_metal.y, material.metallic * rough_metal.z);
    let transmission = material.transmission * linear_texture(scene, material.transmission_texture, interaction).x;
    if roughness > Material::MIRROR_ROUGHNESS && transmission == 0.0 {
        return lambert;
    }

    // Snell: eta is n_outside / n_inside on the way in, and the inverse on the way out.
    let d = ray.direction.normalize();
    let cos_o = (-n.dot(d)).clamp(0.0, 1.0);
    let eta = if interaction.front { 1.0 / material.ior } else { material.ior };
    let cos2_t = 1.0 - eta * eta * (1.0 - cos_o * cos_o);
    let thin = material.double_sided || interaction.sheet;

    // Fresnel, by the angle on the thinner side; all of it where nothing can leave a solid.
    let leaving = transmission > 0.0 && !interaction.front && !thin;
    let specular = Specular::new(scene, material, interaction, base, metallic);
    let fresnel = match transmission {
        0.0 => specular.schlick(cos_o),
        _ if leaving && cos2_t <= 0.0 => Vec3::ONE,
        _ => specular.dielectric(if leaving { cos2_t.sqrt() } else { cos_o }),
    };
    // A sheet stands for both faces of a pane.
    let glass = if interaction.sheet { Vec3::ONE - specular.pane_transmittance(cos_o) } else { fresnel };

    // Share what is not reflected between diffuse reflection and transmission.
    let refracted = if thin || cos2_t <= 0.0 { d } else { d * eta + n * (eta * cos_o - cos2_t.sqrt()) };
    let below = (1.0 - metallic) * base;
    ShadedHit {
        diffuse: below * (Vec3::ONE - fresnel) * (1.0 - transmission),
        mirror: fresnel.lerp(glass, transmission),
        refraction: below * (Vec3::ONE - glass) * transmission,
        refracted,
        ..lambert
    }
}

/// The part of a shadow ray's light, by channel, that passes a surface which is not opaque.
///
/// The ray goes straight on where a real one is bent twice. Through a pane with parallel faces both meet each face at
/// the same outer angle, so a face of a solid passes the root of what the whole pane does, and a sheet all of it.
pub(crate) fn shadow_transmittance(scene: &Scene, ray: &Ray, hit: &Hit) -> Vec3 {
    // What passes beside the surface, coloured by it.
    let interaction = intersect_geometry(scene, ray, hit);
    let material = &scene.data().materials[interaction.material];
    let base = base_color(scene, material, &interaction);
    let opacity = material_opacity(material, base.w);
    let base = base.truncate();
    let passed = (1.0 - opacity) * Vec3::ONE.lerp(base, opacity);
    if material.transmission == 0.0 || material.unlit {
        return passed;
    }

    // What passes through it.
    let metallic = material.metallic * linear_texture(scene, material.metallic_roughness_texture, &interaction).z;
    let transmission = material.transmission * linear_texture(scene, material.transmission_texture, &interaction).x;
    let cos = bumped_normal(scene, material, &interaction).dot(ray.direction.normalize()).abs().min(1.0);
    let pane = Specular::new(scene, material, &interaction, base, metallic).pane_transmittance(cos);
    let face = if interaction.sheet { pane } else { pane.map(f32::sqrt) };
    passed + base * face * (opacity * (1.0 - metallic) * transmission)
}

/// Whether a ray enters or leaves, and which material it meets: two crossings at one place that agree in these are one.
pub(crate) fn crossing_kind(scene: &Scene, ray: &Ray, hit: &Hit) -> (usize, bool) {
    (material_of(scene, hit), intersect_geometry(scene, ray, hit).front)
}

/// Whether the surface that was hit stops every shadow ray.
pub(crate) fn is_opaque(scene: &Scene, hit: &Hit) -> bool {
    scene.is_opaque(material_of(scene, hit))
}

/// Index of the hit surface's material.
fn material_of(scene: &Scene, hit: &Hit) -> usize {
    let data = scene.data();
    match hit.target {
        Target::Triangle { instance, .. } => data.meshes[data.instances[instance as usize].mesh].material,
        Target::Sphere(i) => data.spheres[i as usize].material,
        Target::Shape(i) => data.shapes[i as usize].material,
    }
}

/// Whether the ray met the back of a single-sided surface, as it does inside a solid.
pub(crate) fn is_back_face(scene: &Scene, ray: &Ray, hit: &Hit) -> bool {
    if scene.data().materials[material_of(scene, hit)].double_sided {
        return false;
    }
    let interaction = intersect_geometry(scene, ray, hit);
    !interaction.front && !interaction.sheet
}

/// A surface that neither emits nor reflects.
fn plain(interaction: &SurfaceInteraction<'_>, n: Vec3, opacity: f32) -> ShadedHit {
    ShadedHit {
        position: interaction.position,
        n,
        ng: interaction.ng,
        offset: interaction.offset,
        bulge: interaction.bulge,
        opacity,
        emission: Vec3::ZERO,
        illuminating: Vec3::ZERO,
        diffuse: Vec3::ZERO,
        mirror: Vec3::ZERO,
        refraction: Vec3::ZERO,
        refracted: Vec3::ZERO,
    }
}

/// A specular lobe's reflectance at normal and at grazing incidence, as glTF has it (see [`Material`]).
struct Specular {
    f0: Vec3,
    f90: Vec3,
    ior: f32,
}

impl Specular {
    fn new(
        scene: &Scene,
        material: &Material,
        interaction: &SurfaceInteraction<'_>,
        base: Vec3,
        metallic: f32,
    ) -> Self {
        let specular = material.specular * linear_texture(scene, material.specular_texture, interaction).w;
        let color =
            material.specular_color * color_texture(scene, material.specular_color_texture, interaction).truncate();
        let f0 = ((f0_of(material.ior) * color).min(Vec3::ONE) * specular).lerp(base, metallic);
        let f90 = Vec3::splat(specular + (1.0 - specular) * metallic);
        Self { f0, f90, ior: material.ior }
    }

    /// Schlick's approximation.
    fn schlick(&self, cos: f32) -> Vec3 {
        let m = (1.0 - cos).clamp(0.0, 1.0);
        let m5 = m * m * m * m * m;
        self.f0 + (self.f90 - self.f0) * m5
    }

    /// Fresnel's equations, their values at normal and at grazing incidence replaced by those of the lobe.
    fn dielectric(&self, cos: f32) -> Vec3 {
        let (normal, reflectance) = (f0_of(self.ior), Reflectances::new(cos, self.ior).mean());
        self.f0 + (self.f90 - self.f0) * ((reflectance - normal) / (1.0 - normal))
    }

    /// What passes both faces of a pane, with all reflections between them.
    fn pane_transmittance(&self, cos: f32) -> Vec3 {
        let reflectances = Reflectances::new(cos, self.ior);
        let mean = reflectances.mean();
        // Scale both polarisations as the lobe scales their mean.
        self.dielectric(cos).map(|f| reflectances.pane_transmittance(if mean > 0.0 { f / mean } else { 1.0 }))
    }
}

/// The reflectance of a dielectric at normal incidence.
fn f0_of(ior: f32) -> f32 {
    let ratio = (ior - 1.0) / (ior + 1.0);
    ratio * ratio
}

fn material_opacity(material: &Material, alpha: f32) -> f32 {
    match material.alpha_mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
        AlphaMode::Blend => alpha,
    }
}

fn base_color(scene: &Scene, material: &Material, interaction: &SurfaceInteraction<'_>) -> Vec4 {
    let texture = color_texture(scene, material.base_color_texture, interaction);
    (material.base_color.extend(material.alpha) * interaction.color * texture).clamp(Vec4::ZERO, Vec4::ONE)
}

fn emission(scene: &Scene, material: &Material, interaction: &SurfaceInteraction<'_>) -> Vec3 {
    material.emission * color_texture(scene, material.emission_texture, interaction).truncate()
}

/// A texture of colours, the mean over the footprint.
fn color_texture(scene: &Scene, texture_ref: Option<TextureRef>, interaction: &SurfaceInteraction<'_>) -> Vec4 {
    let Some(r) = texture_ref else { return Vec4::ONE };
    let texture = &scene.data().textures[r.texture];
    let image = &scene.data().images[texture.image];
    let (uv, footprint) = (r.transform.apply(interaction.uvs[r.uv_set]), interaction.footprints[r.uv_set]);
    let footprint = footprint.transformed(&r.transform);
    texture.sample_over(image, || scene.mipmap(texture.image), uv, footprint, ColorEncoding::Srgb)
}

/// A texture of numbers, at a point.
fn linear_texture(scene: &Scene, texture_ref: Option<TextureRef>, interaction: &SurfaceInteraction<'_>) -> Vec4 {
    let Some(r) = texture_ref else { return Vec4::ONE };
    let texture = &scene.data().textures[r.texture];
    texture.sample(
        &scene.data().images[texture.image],
        r.transform.apply(interaction.uvs[r.uv_set]),
        ColorEncoding::Linear,
    )
}

/// The shading normal, turned by the normal map (glTF 2.0 §3.9.3).
fn bumped_normal(scene: &Scene, material: &Material, interaction: &SurfaceInteraction<'_>) -> Vec3 {
    let (Some(map), Some((tangent, bitangent))) = (material.normal_texture, interaction.tangents) else {
        return interaction.n;
    };
    let texel = linear_texture(scene, Some(map), interaction).truncate() * 2.0 - 1.0;
    let (x, y) = (texel.x * material.normal_scale, texel.y * material.normal_scale);
    (tangent * x + bitangent * y + interaction.n * texel.z).normalize_or(interaction.n)
}
