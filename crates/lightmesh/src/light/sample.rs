//! One light sample outside its block, and blocks filled from such, one after the other.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::emitters::LightSample;
use super::samples::{LANES, LightBlock, LightSamples, MIN_R2, PatchLanes, SpotLanes};
use crate::Falloff;
use crate::scene::Light;

/// A light sample, or a light that stands for many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SampledLight {
    /// Metres; of a directional light the unit vector towards it.
    pub position: Vec3,
    /// Candela, or lux for a directional one, per channel.
    pub intensity: Vec3,
    pub emission: LightEmission,
}

/// How a luminaire shines: the rows of the table in the module's documentation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LightEmission {
    /// Alike in every direction, without end.
    Isotropic,
    /// A patch: the unit normal of the side that shines, 0 or −1 for both sides, A / π in square metres.
    Patch { axis: Vec3, back: f32, spread: f32 },
    /// A spot, a point with a range, or a direction (`w` 0): cone factor clamp(cosθ · scale + offset)² about an axis that points against
    /// the way the light shines, and 1 / R².
    Spot { w: f32, axis: Vec3, scale: f32, offset: f32, inv_range2: f32 },
}

impl SampledLight {
    pub(super) fn of(sample: &LightSample) -> Self {
        match *sample {
            LightSample::Patch(patch) => Self {
                position: patch.position,
                intensity: patch.intensity_cd,
                emission: LightEmission::Patch {
                    axis: patch.normal,
                    back: if patch.two_sided { -1.0 } else { 0.0 },
                    spread: patch.area * FRAC_1_PI,
                },
            },
            LightSample::Punctual(light) => {
                let place = match light {
                    Light::Point { position, .. } | Light::Spot { position, .. } => position,
                    Light::Directional { direction, .. } => -direction,
                };
                Self { position: place, intensity: light.color(), emission: LightEmission::of(&light) }
            }
        }
    }

    /// The plain twin of the blocks' SIMD: d and f of the module's table, as seen from `p`.
    pub(crate) fn arriving(&self, falloff: Falloff, p: Vec3) -> (Vec3, f32) {
        let w = if let LightEmission::Spot { w, .. } = self.emission { w } else { 1.0 };
        let d = self.position - p * w;
        let r2 = d.length_squared().max(MIN_R2);
        let r = r2.sqrt();
        let attenuation = match falloff {
            Falloff::InverseSquare => 1.0 / (r2 * r),
            Falloff::ConstantPlusDistance { constant } => 1.0 / ((r + constant) * r),
        };
        let f = match self.emission {
            LightEmission::Isotropic => attenuation,
            LightEmission::Patch { axis, back, spread } => {
                let ahead = -d.dot(axis) / r;
                let cos = ahead.max(ahead * back);
                match falloff {
                    Falloff::InverseSquare => cos / ((r2 + spread * (cos * cos * 3.0 - 2.0)).max(spread) * r),
                    Falloff::ConstantPlusDistance { .. } => attenuation * cos,
                }
            }
            LightEmission::Spot { w: 0.0, .. } => 1.0,
            LightEmission::Spot { axis, scale, offset, inv_range2, .. } => {
                let cone = (d.dot(axis) / r * scale + offset).clamp(0.0, 1.0);
                let q = r2 * inv_range2;
                attenuation * cone * cone * (1.0 - q * q).max(0.0)
            }
        };
        (d, f)
    }
}

impl LightEmission {
    fn of(light: &Light) -> Self {
        let inv_range2 = |range: Option<f32>| range.map_or(0.0, |r| 1.0 / (r * r));
        let round = |w, inv_range2| Self::Spot { w, axis: Vec3::ZERO, scale: 0.0, offset: 1.0, inv_range2 };
        match *light {
            Light::Point { range: None, .. } => Self::Isotropic,
            Light::Point { range, .. } => round(1.0, inv_range2(range)),
            Light::Spot { direction, range, inner_cone_angle, outer_cone_angle, .. } => {
                // KHR_lights_punctual: scale = 1 / max(0.001, cos inner − cos outer), offset = −cos outer · scale.
                let (inner, outer) = (libm::cosf(inner_cone_angle), libm::cosf(outer_cone_angle));
                let scale = 1.0 / (inner - outer).max(1e-3);
                let inv_range2 = inv_range2(range);
                Self::Spot { w: 1.0, axis: -direction, scale, offset: -outer * scale, inv_range2 }
            }
            Light::Directional { .. } => round(0.0, 0.0),
        }
    }

    /// Where its blocks come among all.
    pub(super) fn order(&self) -> u8 {
        match self {
            Self::Isotropic => 0,
            Self::Patch { .. } => 1,
            Self::Spot { .. } => 2,
        }
    }
}

impl LightSamples {
    /// The light of a lane; `None` for padding.
    pub(crate) fn sample(&self, lane: usize) -> Option<SampledLight> {
        let (index, i) = (lane / LANES, lane % LANES);
        let block = &self.blocks[index];
        let place = Vec3::new(block.x[i], block.y[i], block.z[i]);
        let intensity = self.intensity(lane);
        let plain = self.blocks.len() - self.patches.len() - self.spots.len();
        let emission = if index < plain {
            LightEmission::Isotropic
        } else if let Some(f) = self.patches.get(index - plain) {
            LightEmission::Patch { axis: Vec3::new(f.ax[i], f.ay[i], f.az[i]), back: f.back[i], spread: f.spread[i] }
        } else {
            let e = &self.spots[index - plain - self.patches.len()];
            LightEmission::Spot {
                w: e.w[i],
                axis: Vec3::new(e.ax[i], e.ay[i], e.az[i]),
                scale: e.cone_scale[i],
                offset: e.cone_offset[i],
                inv_range2: e.inv_range2[i],
            }
        };
        (intensity != Vec3::ZERO).then_some(SampledLight { position: place, intensity, emission })
    }

    /// No lights; what was allocated is kept.
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.patches.clear();
        self.spots.clear();
        self.count = 0;
        self.last_lanes = 0;
    }

    /// Adds a light and returns its lane. Even ones come first, then patches, then shaped ones.
    pub(crate) fn push(&mut self, light: &SampledLight) -> usize {
        let first_of_kind = match light.emission {
            LightEmission::Isotropic => self.blocks.is_empty(),
            LightEmission::Patch { .. } => self.patches.is_empty(),
            LightEmission::Spot { .. } => self.spots.is_empty(),
        };
        if first_of_kind || self.last_lanes == LANES {
            self.blocks.push(LightBlock::PADDING);
            match light.emission {
                LightEmission::Isotropic => debug_assert!(self.patches.is_empty() && self.spots.is_empty()),
                LightEmission::Patch { .. } => self.patches.push(PatchLanes::PADDING),
                LightEmission::Spot { .. } => self.spots.push(SpotLanes::PADDING),
            }
            self.last_lanes = 0;
        }
        let (index, i) = (self.blocks.len() - 1, self.last_lanes);
        let block = &mut self.blocks[index];
        [block.x[i], block.y[i], block.z[i]] = light.position.to_array();
        [block.r[i], block.g[i], block.b[i]] = light.intensity.to_array();
        match (light.emission, self.patches.last_mut(), self.spots.last_mut()) {
            (LightEmission::Patch { axis, back, spread }, Some(f), _) => {
                [f.ax[i], f.ay[i], f.az[i]] = axis.to_array();
                (f.back[i], f.spread[i]) = (back, spread);
            }
            (LightEmission::Spot { w, axis, scale, offset, inv_range2 }, _, Some(e)) => {
                [e.ax[i], e.ay[i], e.az[i]] = axis.to_array();
                (e.w[i], e.cone_scale[i], e.cone_offset[i], e.inv_range2[i]) = (w, scale, offset, inv_range2);
            }
            _ => {}
        }
        self.last_lanes += 1;
        self.count += 1;
        index * LANES + i
    }
}

impl LightBlock {
    /// Stands far away and shines with zero.
    const PADDING: Self =
        Self { x: [1e9; LANES], y: [1e9; LANES], z: [1e9; LANES], r: [0.0; LANES], g: [0.0; LANES], b: [0.0; LANES] };
}

impl PatchLanes {
    const PADDING: Self =
        Self { ax: [0.0; LANES], ay: [0.0; LANES], az: [0.0; LANES], back: [0.0; LANES], spread: [0.0; LANES] };
}

impl SpotLanes {
    const PADDING: Self = Self {
        w: [1.0; LANES],
        ax: [0.0; LANES],
        ay: [0.0; LANES],
        az: [0.0; LANES],
        cone_scale: [0.0; LANES],
        cone_offset: [1.0; LANES],
        inv_range2: [0.0; LANES],
    };
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;

    use super::super::emitters::Patch;
    use super::super::samples::Directions;
    use super::*;

    /// Lights of every kind, out of their blocks and into new ones: the same lanes.
    #[test]
    fn filling_blocks_with_what_was_in_them_gives_them_back() {
        let position = |i: u32| Vec3::new(i as f32, 1.0, -2.0);
        let samples: Vec<LightSample> = (0..100)
            .map(|i| match i % 5 {
                0 => LightSample::Patch(Patch {
                    position: position(i),
                    normal: Vec3::Y,
                    intensity_cd: Vec3::ONE,
                    area: 0.1,
                    two_sided: i % 2 == 0,
                }),
                1 => LightSample::Punctual(Light::Spot {
                    position: position(i),
                    direction: Vec3::X,
                    intensity_cd: Vec3::ONE,
                    range: Some(3.0),
                    inner_cone_angle: 0.1,
                    outer_cone_angle: 0.5,
                }),
                2 => LightSample::Punctual(Light::Directional { direction: Vec3::Z, illuminance_lux: Vec3::ONE }),
                _ => {
                    LightSample::Punctual(Light::Point { position: position(i), intensity_cd: Vec3::ONE, range: None })
                }
            })
            .collect();
        let lights = LightSamples::new(&samples);
        let mut again = LightSamples::new(&samples[..7]);
        again.clear();
        for lane in 0..lights.lanes() {
            if let Some(luminaire) = lights.sample(lane) {
                assert_eq!(again.push(&luminaire), lane);
            }
        }
        assert_eq!((again.len(), again.lanes()), (lights.len(), lights.lanes()));
        assert!((0..lights.lanes()).all(|lane| again.sample(lane) == lights.sample(lane)));

        // And what arrives of each is what the blocks say.
        let p = Vec3::new(40.3, 1.2, 3.0);
        for falloff in [Falloff::InverseSquare, Falloff::ConstantPlusDistance { constant: 0.3 }] {
            let mut directions = Directions::default();
            lights.directions(Level::new(), falloff, p, &mut directions);
            for lane in 0..lights.lanes() {
                let Some(luminaire) = lights.sample(lane) else { continue };
                let (d, f) = luminaire.arriving(falloff, p);
                assert_eq!(d, Vec3::new(directions.dx[lane], directions.dy[lane], directions.dz[lane]));
                let expected = directions.f[lane];
                assert!(
                    (f.max(0.0) - expected.max(0.0)).abs() <= 1e-5 * expected.abs(),
                    "{luminaire:?}: {f} {expected}"
                );
            }
        }
    }
}
