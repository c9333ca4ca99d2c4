//! A light sample of an emitter, and one as it is evaluated by itself.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::Falloff;
use crate::scene::Light;

/// r² is not taken below this (1 µm): a light that touches a point stays finite.
pub(super) const MIN_R2: f32 = 1e-12;

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

/// A light sample, or the one light that represents a cluster of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SampledLight {
    /// Metres; of a directional light the unit vector towards it.
    pub position: Vec3,
    /// Candela, or lux for a directional one, per channel.
    pub intensity: Vec3,
    pub emission: LightEmission,
}

/// How a light sample's intensity depends on where it is seen from: the rows of the table in `samples.rs`. A new kind
/// needs a block of lanes there, and its own term in the bounds of the light tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LightEmission {
    /// A point that shines alike in every direction, without end.
    Isotropic,
    /// A disk with Lambertian emission.
    Patch {
        /// Unit; the side that shines.
        normal: Vec3,
        /// 0, or −1 if both sides shine.
        back: f32,
        /// A / π, square metres.
        area_over_pi: f32,
    },
    /// A point whose light is limited to a cone, or to a range, or both.
    Spot { cone: SpotCone, window: RangeWindow },
    /// Parallel light.
    Directional,
}

/// The cone of a spot light: the intensity is multiplied by the square of [`SpotCone::ramp`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpotCone {
    /// Unit, against the way the light shines; zero where there is no cone.
    pub axis: Vec3,
    pub scale: f32,
    pub offset: f32,
}

/// The window that ends a light at its range R (KHR_lights_punctual): clamp(1 − (r / R)⁴).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RangeWindow {
    /// 1 / R², 1/m²; 0 where there is no range.
    pub inv_range2: f32,
}

impl SpotCone {
    /// The whole sphere.
    pub(crate) const EVERYWHERE: Self = Self { axis: Vec3::ZERO, scale: 0.0, offset: 1.0 };

    /// KHR_lights_punctual: scale = 1 / max(0.001, cos inner − cos outer), offset = −cos outer · scale.
    fn new(direction: Vec3, inner_angle: f32, outer_angle: f32) -> Self {
        let (inner, outer) = (libm::cosf(inner_angle), libm::cosf(outer_angle));
        let scale = 1.0 / (inner - outer).max(1e-3);
        Self { axis: -direction, scale, offset: -outer * scale }
    }

    /// clamp(cosθ · scale + offset), for the cosine between the axis and the direction towards the light.
    #[inline(always)]
    pub(crate) fn ramp(&self, cos: f32) -> f32 {
        (cos * self.scale + self.offset).clamp(0.0, 1.0)
    }
}

impl RangeWindow {
    /// No range.
    pub(crate) const OPEN: Self = Self { inv_range2: 0.0 };

    fn new(range: Option<f32>) -> Self {
        range.map_or(Self::OPEN, |r| Self { inv_range2: 1.0 / (r * r) })
    }

    /// The factor at a distance, given its square.
    #[inline(always)]
    pub(crate) fn factor(&self, r2: f32) -> f32 {
        let q = r2 * self.inv_range2;
        (1.0 - q * q).max(0.0)
    }
}

impl SampledLight {
    pub(crate) fn of(sample: &LightSample) -> Self {
        match *sample {
            LightSample::Patch(patch) => Self {
                position: patch.position,
                intensity: patch.intensity_cd,
                emission: LightEmission::Patch {
                    normal: patch.normal,
                    back: if patch.two_sided { -1.0 } else { 0.0 },
                    area_over_pi: patch.area * FRAC_1_PI,
                },
            },
            LightSample::Punctual(light) => {
                let position = match light {
                    Light::Point { position, .. } | Light::Spot { position, .. } => position,
                    Light::Directional { direction, .. } => -direction,
                };
                Self { position, intensity: light.color(), emission: LightEmission::of(&light) }
            }
        }
    }

    /// d and f of the table in `samples.rs` at `p`: the scalar twin of the blocks' SIMD.
    pub(crate) fn arriving(&self, falloff: Falloff, p: Vec3) -> (Vec3, f32) {
        let d = match self.emission {
            LightEmission::Directional => return (self.position, 1.0),
            _ => self.position - p,
        };
        let r2 = d.length_squared().max(MIN_R2);
        let r = r2.sqrt();
        let f = match self.emission {
            LightEmission::Isotropic | LightEmission::Directional => falloff.attenuation_over_distance(r2, r),
            LightEmission::Patch { normal, back, area_over_pi } => {
                let ahead = -d.dot(normal) / r;
                let cos = ahead.max(ahead * back);
                match falloff {
                    Falloff::InverseSquare => {
                        cos / ((r2 + area_over_pi * (cos * cos * 3.0 - 2.0)).max(area_over_pi) * r)
                    }
                    Falloff::ConstantPlusDistance { .. } => falloff.attenuation_over_distance(r2, r) * cos,
                }
            }
            LightEmission::Spot { cone, window } => {
                let ramp = cone.ramp(d.dot(cone.axis) / r);
                falloff.attenuation_over_distance(r2, r) * ramp * ramp * window.factor(r2)
            }
        };
        (d, f)
    }
}

impl LightEmission {
    fn of(light: &Light) -> Self {
        match *light {
            Light::Point { range: None, .. } => Self::Isotropic,
            Light::Point { range, .. } => Self::Spot { cone: SpotCone::EVERYWHERE, window: RangeWindow::new(range) },
            Light::Spot { direction, range, inner_cone_angle, outer_cone_angle, .. } => Self::Spot {
                cone: SpotCone::new(direction, inner_cone_angle, outer_cone_angle),
                window: RangeWindow::new(range),
            },
            Light::Directional { .. } => Self::Directional,
        }
    }

    /// The rank of its blocks among all.
    pub(super) fn order(&self) -> u8 {
        match self {
            Self::Isotropic => 0,
            Self::Patch { .. } => 1,
            Self::Spot { .. } | Self::Directional => 2,
        }
    }
}
