//! Packing light samples into blocks of lanes, and taking them out again.

use glam::Vec3;

use super::sample::{LightEmission, RangeWindow, SampledLight, SpotCone};
use super::samples::{LANES, LightBlock, LightSamples, PatchLanes, SpotLanes};

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
        self.strata.clear();
        self.reaches.clear();
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

    use super::super::sample::{LightSample, Patch};
    use super::super::samples::Directions;
    use super::*;
    use crate::Falloff;
    use crate::scene::Light;

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
