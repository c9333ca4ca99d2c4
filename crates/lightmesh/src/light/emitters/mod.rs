//! The emitters of a scene: emissive meshes and spheres, punctual lights, which may be sphere lights, and the
//! environment; and the point-like and directional samples that represent them.
//!
//! | emitter | samples |
//! |---|---|
//! | punctual light | itself; as a sphere light, N points of equal power in its ball ([`sphere`]) |
//! | emissive mesh, all its triangles together, or emissive sphere | N patches with cosine emission ([`AreaLights`]) |
//! | environment | N directions, more where it is bright ([`EnvironmentLight`]) |
//!
//! Emission of weak emitters, no brighter than lit walls, is left to gather rays; so is that of user-defined shapes,
//! which cannot be sampled. Double-sided surfaces shine from both sides, the others from their front. Unlit surfaces
//! show and light nothing.

mod area;
mod environment;
mod primitive;
pub(crate) mod sphere;

pub(crate) use area::AreaLights;
use area::EmitterClass;
pub(crate) use environment::EnvironmentLight;
use glam::Vec3;

use super::samples::LightSamples;
use crate::Error;
use crate::geometry::Aabb;
use crate::sampling::unit_f32;
use crate::scene::{EmitterOptions, Light, SceneData};

/// Most samples of all emitters together: 64 MiB of them.
const MAX_SAMPLES: u64 = 1 << 20;

/// One point-like or directional sample of an emitter.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightSample {
    /// A point, spot or direction.
    Punctual(Light),
    /// A small patch of an emissive surface.
    Patch(Patch),
}

/// A small flat emitter with Lambertian emission.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// Metres.
    pub position: Vec3,
    /// Unit; the side that shines.
    pub normal: Vec3,
    /// Along the normal, candela: radiance times area.
    pub intensity_cd: Vec3,
    /// Square metres.
    pub area: f32,
    /// Whether the other side shines as well.
    pub two_sided: bool,
}

/// The emitters of a scene.
#[derive(Debug)]
pub(crate) struct Emitters {
    /// Emissive meshes and spheres.
    pub area: AreaLights,
    /// The environment, unless it is black.
    pub environment: Option<EnvironmentLight>,
    /// Punctual lights alone, as points.
    pub punctual: LightSamples,
    /// The samples of the mesh methods: of all emitters but those that are left to gather rays.
    pub sampled: LightSamples,
    /// The samples of all emitters; `None` where these are `sampled`.
    all: Option<LightSamples>,
    /// Radius of the sphere lights that punctual lights are, metres; 0: points.
    pub light_radius: f32,
}

impl Emitters {
    /// Collects the emitters of a checked scene whose surfaces lie in `bounds`.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for options out of range or too many samples.
    pub(crate) fn new(data: &SceneData, bounds: &Aabb, options: &EmitterOptions) -> Result<Self, Error> {
        options.validate()?;
        // Find the emitters.
        let n = options.light_samples;
        let environment = data.environment.as_ref().and_then(EnvironmentLight::new);
        let flux = punctual_flux(&data.lights, bounds)
            + environment.as_ref().map_or(0.0, |e| std::f64::consts::PI * e.mean_luminance() * box_area(bounds));
        let area = AreaLights::new(data, flux);

        // Limit the number of samples before they are made.
        let spheres = if options.light_radius > 0.0 { data.lights.len() as u64 } else { 0 };
        let sources = spheres + area.len() as u64 + u64::from(environment.is_some());
        if sources * u64::from(n) > MAX_SAMPLES {
            let what = format!(
                "{n} samples of each of {sources} emitters are more than the {MAX_SAMPLES} that are kept; choose fewer"
            );
            return Err(Error::InvalidOption { option: "light-samples", what });
        }
        // Sample the emitters.
        let mut samples: Vec<LightSample> = match options.light_radius > 0.0 {
            true => data.lights.iter().flat_map(|light| sphere::samples(light, options.light_radius, n)).collect(),
            false => data.lights.iter().map(|&light| LightSample::Punctual(light)).collect(),
        };
        samples.extend(area.samples(data, n, EmitterClass::Sampled));
        samples.extend(environment.iter().flat_map(|environment| environment.samples(n)));
        let sampled = LightSamples::new(&samples);
        let all = area.has_weak().then(|| {
            samples.extend(area.samples(data, n, EmitterClass::Weak));
            LightSamples::new(&samples)
        });
        let punctual: Vec<LightSample> = data.lights.iter().map(|&light| LightSample::Punctual(light)).collect();
        let punctual = LightSamples::new(&punctual);
        Ok(Self { area, environment, punctual, sampled, all, light_radius: options.light_radius })
    }

    /// All samples, those of weak emitters too.
    pub(crate) fn all(&self) -> &LightSamples {
        self.all.as_ref().unwrap_or(&self.sampled)
    }
}

/// Returns the luminous flux of punctual lights, lumen: 4π I, 2π I (1 − cos outer), and that of a directional light
/// through the scene's box.
fn punctual_flux(lights: &[Light], bounds: &Aabb) -> f64 {
    use std::f64::consts::PI;
    let flux = |light: &Light| {
        f64::from(luminance(light.color()))
            * match *light {
                Light::Point { .. } => 4.0 * PI,
                Light::Spot { outer_cone_angle, .. } => 2.0 * PI * (1.0 - f64::from(libm::cosf(outer_cone_angle))),
                // A convex body's mean shadow is a quarter of its surface (Cauchy).
                Light::Directional { .. } => 0.25 * box_area(bounds),
            }
    };
    lights.iter().map(flux).sum()
}

fn box_area(bounds: &Aabb) -> f64 {
    let s = bounds.size().as_dvec3();
    2.0 * (s.x * s.y + s.y * s.z + s.z * s.x)
}

/// Returns the Rec. 709 luminance of linear RGB.
pub(crate) fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns i / 2³² with the bits of i reversed: van der Corput's sequence, in [0, 1).
pub(crate) fn radical_inverse(i: u32) -> f32 {
    unit_f32(i.reverse_bits())
}
