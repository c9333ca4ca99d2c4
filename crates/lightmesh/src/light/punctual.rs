//! The light of one punctual light, straight from its description: the path tracer's, and independent of the light
//! samples.

use glam::Vec3;

use super::samples::MIN_R2;
use crate::Falloff;
use crate::scene::Light;

impl Light {
    /// Returns the vector from `p` to the light, or the unit vector towards a directional one, and the illuminance (lux
    /// per channel) that it brings to a surface at `p` that faces it.
    pub(crate) fn arriving(&self, falloff: Falloff, p: Vec3) -> (Vec3, Vec3) {
        let fade = |position: Vec3, range: Option<f32>| {
            let d = position - p;
            let r2 = d.length_squared().max(MIN_R2);
            let window = range.map_or(1.0, |range| (1.0 - (r2 / (range * range)).powi(2)).max(0.0));
            (d, falloff.attenuation(r2, r2.sqrt()) * window)
        };
        match *self {
            Self::Point { position, intensity_cd, range } => {
                let (d, f) = fade(position, range);
                (d, intensity_cd * f)
            }
            Self::Spot { position, direction, intensity_cd, range, inner_cone_angle, outer_cone_angle } => {
                let (d, f) = fade(position, range);
                let (inner, outer) = (libm::cosf(inner_cone_angle), libm::cosf(outer_cone_angle));
                let cos = -direction.dot(d.normalize_or_zero());
                let cone = ((cos - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0);
                (d, intensity_cd * (f * cone * cone))
            }
            Self::Directional { direction, illuminance_lux } => (-direction, illuminance_lux),
        }
    }
}
