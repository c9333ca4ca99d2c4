//! A light sample outside its block, and the packing of blocks from such samples.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::emitters::LightSample;
use super::samples::{LANES, LightBlock, LightSamples, MIN_R2, PatchLanes, SpotLanes};
use crate::Falloff;
use crate::scene::Light;

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
    pub(super) fn of(sample: &LightSample) -> Self {
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

impl LightSamples {
    /// The light of a lane; `None` for padding.
    pub(crate) fn sample(&self, lane: usize) -> Option<SampledLight> {
        let (index, i) = (lane / LANES, lane % LANES);
        let block = &self.blocks[index];
        let position = Vec3::new(block.x[i], block.y[i], block.z[i]);
        let intensity = self.intensity(lane);
        let plain = self.blocks.len() - self.patches.len() - self.spots.len();
        let emission = if index < plain {
            LightEmission::Isotropic
        } else if let Some(lanes) = self.patches.get(index - plain) {
            lanes.emission(i)
        } else {
            self.spots[index - plain - self.patches.len()].emission(i)
        };
        (intensity != Vec3::ZERO).then_some(SampledLight { position, intensity, emission })
    }

    /// No lights; what was allocated is kept.
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.patches.clear();
        self.spots.clear();
        self.count = 0;
        self.last_lanes = 0;
    }

    /// Adds a light and returns its lane. Isotropic ones come first, then patches, then the others.
    pub(crate) fn push(&mut self, light: &SampledLight) -> usize {
        // Begin a block where the last one is full, or of another kind.
        let first_of_kind = match light.emission {
            LightEmission::Isotropic => self.blocks.is_empty(),
            LightEmission::Patch { .. } => self.patches.is_empty(),
            LightEmission::Spot { .. } | LightEmission::Directional => self.spots.is_empty(),
        };
        if first_of_kind || self.last_lanes == LANES {
            self.blocks.push(LightBlock::PADDING);
            match light.emission {
                LightEmission::Isotropic => debug_assert!(self.patches.is_empty() && self.spots.is_empty()),
                LightEmission::Patch { .. } => self.patches.push(PatchLanes::PADDING),
                LightEmission::Spot { .. } | LightEmission::Directional => self.spots.push(SpotLanes::PADDING),
            }
            self.last_lanes = 0;
        }
        // Fill the next lane.
        let (index, i) = (self.blocks.len() - 1, self.last_lanes);
        let block = &mut self.blocks[index];
        [block.x[i], block.y[i], block.z[i]] = light.position.to_array();
        [block.r[i], block.g[i], block.b[i]] = light.intensity.to_array();
        match light.emission {
            LightEmission::Isotropic => {}
            LightEmission::Patch { normal, back, area_over_pi } => {
                let lanes = self.patches.last_mut().expect("the last block is of patches");
                [lanes.ax[i], lanes.ay[i], lanes.az[i]] = normal.to_array();
                (lanes.back[i], lanes.area_over_pi[i]) = (back, area_over_pi);
            }
            LightEmission::Spot { cone: SpotCone { axis, scale, offset }, window } => {
                let lanes = self.spots.last_mut().expect("the last block is of spots");
                [lanes.ax[i], lanes.ay[i], lanes.az[i]] = axis.to_array();
                (lanes.cone_scale[i], lanes.cone_offset[i]) = (scale, offset);
                lanes.inv_range2[i] = window.inv_range2;
            }
            LightEmission::Directional => self.spots.last_mut().expect("the last block is of spots").w[i] = 0.0,
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
        Self { ax: [0.0; LANES], ay: [0.0; LANES], az: [0.0; LANES], back: [0.0; LANES], area_over_pi: [0.0; LANES] };

    fn emission(&self, i: usize) -> LightEmission {
        let normal = Vec3::new(self.ax[i], self.ay[i], self.az[i]);
        LightEmission::Patch { normal, back: self.back[i], area_over_pi: self.area_over_pi[i] }
    }
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

    fn emission(&self, i: usize) -> LightEmission {
        if self.w[i] == 0.0 {
            return LightEmission::Directional;
        }
        let axis = Vec3::new(self.ax[i], self.ay[i], self.az[i]);
        LightEmission::Spot {
            cone: SpotCone { axis, scale: self.cone_scale[i], offset: self.cone_offset[i] },
            window: RangeWindow { inv_range2: self.inv_range2[i] },
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;

    use super::super::emitters::Patch;
    use super::super::samples::Directions;
    use super::*;

    /// Lights of every kind, unpacked from their blocks and packed into new ones, have the same lanes.
    #[test]
    fn lights_survive_their_blocks_and_their_scalar_twin_agrees() {
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
            if let Some(light) = lights.sample(lane) {
                assert_eq!(again.push(&light), lane);
            }
        }
        assert_eq!((again.len(), again.lanes()), (lights.len(), lights.lanes()));
        assert!((0..lights.lanes()).all(|lane| again.sample(lane) == lights.sample(lane)));

        // The scalar twin gives the bits of the blocks; what is 0 or less counts as 0.
        let p = Vec3::new(40.3, 1.2, 3.0);
        for falloff in [Falloff::InverseSquare, Falloff::ConstantPlusDistance { constant: 0.3 }] {
            let mut directions = Directions::default();
            lights.directions(Level::new(), falloff, p, &mut directions);
            for lane in 0..lights.lanes() {
                let Some(light) = lights.sample(lane) else { continue };
                let (d, f) = light.arriving(falloff, p);
                assert_eq!(d, Vec3::new(directions.dx[lane], directions.dy[lane], directions.dz[lane]));
                assert_eq!(f.max(0.0), directions.f[lane].max(0.0), "{light:?}");
            }
        }
    }
}
