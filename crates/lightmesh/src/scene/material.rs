//! Surface materials: glTF 2.0 metallic-roughness and the extensions that we read.

use glam::Vec3;

use super::texture::TextureRef;

/// How the base colour's alpha is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Opaque where alpha ≥ `cutoff`, absent elsewhere.
    Mask {
        /// In [0, 1].
        cutoff: f32,
    },
    /// Covers the fraction alpha; rays go on behind with the rest.
    Blend,
}

/// A material as glTF describes it. Textures multiply the factor beside them.
///
/// # Reflection model
/// A surface is Lambert plus mirror, after glTF 2.0's metallic-roughness model with its lobe narrowed to a mirror:
///
/// - F0 = mix(min(((ior − 1) / (ior + 1))² · specularColor, 1) · specular, baseColor, metallic),
///   F90 = mix(specular, 1, metallic), F = F0 + (F90 − F0)(1 − cosθ)⁵ (Schlick 1994; KHR_materials_specular, _ior).
/// - roughness ≤ [`Material::MIRROR_ROUGHNESS`]: the mirror direction carries F, the
///   diffuse albedo is baseColor · (1 − metallic)(1 − transmission)(1 − F).
/// - rougher: no mirror; Lambert of the base colour, metals included. `specular` = 0 is exactly Lambert at any
///   roughness.
/// - transmission (at any roughness, seen sharp): the refracted direction carries baseColor · (1 − metallic) ·
///   transmission · (1 − F), with F = F0 + (F90 − F0) (R − R0) / (1 − R0), R Fresnel's reflectance for the index of
///   refraction. A `double_sided` surface has no inside: its ray goes on unbent. So does that of a sheet, a surface that
///   encloses nothing; it stands for both faces of a thin pane, and 1 − F becomes the mean over both polarisations of
///   (1 − F) / (1 + F).
/// - alpha: BLEND covers the fraction alpha, the ray goes on with the rest; MASK is there or not.
///
/// Shadow rays go straight through surfaces that are not opaque, and take on their colour: a BLEND surface transmits
/// (1 − α) · mix(1, baseColor, α), a sheet of glass what a pane passes at that angle, and each face of a solid the root
/// of it. Caustics are not followed.
///
/// Both sides of a surface shade and block light alike.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Name in the file, for messages; may be empty.
    pub name: String,
    /// Linear RGB, each in [0, 1].
    pub base_color: Vec3,
    /// In [0, 1].
    pub alpha: f32,
    /// sRGB colour and linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// In [0, 1].
    pub metallic: f32,
    /// In [0, 1]; 0 is a perfect mirror.
    pub roughness: f32,
    /// Linear; G multiplies roughness, B multiplies metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Emitted luminance per channel, cd/m² (emissiveFactor × emissiveStrength).
    pub emission: Vec3,
    /// sRGB.
    pub emission_texture: Option<TextureRef>,
    /// Linear tangent-space normals.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// KHR_materials_specular's factor in [0, 1]; 0 makes a dielectric exactly Lambert.
    pub specular: f32,
    /// Linear; A multiplies `specular`.
    pub specular_texture: Option<TextureRef>,
    /// KHR_materials_specular's colour of F0, linear RGB ≥ 0.
    pub specular_color: Vec3,
    /// sRGB.
    pub specular_color_texture: Option<TextureRef>,
    /// Index of refraction, 1 or more (KHR_materials_ior).
    pub ior: f32,
    /// Fraction of the light that is not reflected which is refracted, in [0, 1] (KHR_materials_transmission).
    pub transmission: f32,
    /// Linear; R multiplies `transmission`.
    pub transmission_texture: Option<TextureRef>,
    /// glTF's doubleSided. Surfaces shade from both sides anyway; it says that a back face does not mean the inside of
    /// a closed object.
    pub double_sided: bool,
    /// KHR_materials_unlit: the base colour is shown as it is and no light changes it.
    pub unlit: bool,
}

impl Default for Material {
    /// White, fully rough, dielectric with glTF's defaults (ior 1.5, specular 1).
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::ONE,
            alpha: 1.0,
            base_color_texture: None,
            alpha_mode: AlphaMode::Opaque,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            emission: Vec3::ZERO,
            emission_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            ior: 1.5,
            transmission: 0.0,
            transmission_texture: None,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// Every texture reference.
    pub fn textures(&self) -> [Option<TextureRef>; 7] {
        [
            self.base_color_texture,
            self.metallic_roughness_texture,
            self.emission_texture,
            self.normal_texture,
            self.specular_texture,
            self.specular_color_texture,
            self.transmission_texture,
        ]
    }

    /// The textures that are averaged over footprints: colours, as they multiply light.
    ///
    /// Those of surfaces that are not opaque are not averaged. The colour of a texel counts there as much as its alpha,
    /// and a mean of products is not the product of means: the black that painters leave between the leaves would
    /// darken their edges.
    pub(crate) fn averaged_textures(&self) -> [Option<TextureRef>; 3] {
        match self.alpha_mode {
            AlphaMode::Opaque => [self.base_color_texture, self.emission_texture, self.specular_color_texture],
            AlphaMode::Mask { .. } | AlphaMode::Blend => [None; 3],
        }
    }

    /// Whether there is one of [`Material::averaged_textures`].
    pub(crate) fn has_averaged_textures(&self) -> bool {
        let Self { base_color_texture, emission_texture, specular_color_texture, .. } = self;
        self.alpha_mode == AlphaMode::Opaque
            && (base_color_texture.is_some() || emission_texture.is_some() || specular_color_texture.is_some())
    }

    /// [`Material::textures`], in the same order, to be changed.
    pub fn textures_mut(&mut self) -> [&mut Option<TextureRef>; 7] {
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.emission_texture,
            &mut self.normal_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
        ]
    }

    /// The largest index of refraction; more reflects all, within 4·10⁻⁶.
    pub const MOST_IOR: f32 = 1e6;

    /// Up to this roughness the specular lobe is rendered as a mirror; above it, it is left out and the surface is
    /// Lambert.
    pub const MIRROR_ROUGHNESS: f32 = 0.25;

    /// Whether the material has neither a mirror nor transmission, whatever its textures are.
    pub(crate) fn is_lambert(&self) -> bool {
        let never_smooth = self.roughness > Self::MIRROR_ROUGHNESS && self.metallic_roughness_texture.is_none();
        let never_shiny = self.specular == 0.0 && self.metallic == 0.0;
        self.transmission == 0.0 && (never_smooth || never_shiny)
    }

    /// Whether the author meant a visible highlight that is not rendered: a metal, or a dielectric with a roughness
    /// below 0.6 (a judgement, not measured: above it a lobe of F0 = 0.04 looks much like Lambert).
    pub(crate) fn falls_back_to_lambert(&self) -> bool {
        let rough = self.roughness > Self::MIRROR_ROUGHNESS && self.metallic_roughness_texture.is_none();
        let glossy = self.metallic > 0.5 || (self.specular > 0.0 && self.roughness < 0.6);
        rough && glossy && !self.unlit
    }

    /// An exactly Lambertian material of the given linear albedo.
    pub fn lambert(albedo: Vec3) -> Self {
        Self { base_color: albedo, specular: 0.0, ..Self::default() }
    }
}
