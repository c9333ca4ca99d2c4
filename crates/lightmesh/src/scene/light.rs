//! Punctual lights, in glTF's photometric units (KHR_lights_punctual).

use glam::Vec3;

/// A light without extent. Colours are linear RGB and already multiplied by the intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Light {
    /// Shines alike in every direction.
    Point {
        /// Metres.
        position: Vec3,
        /// Luminous intensity per channel, candela.
        intensity_cd: Vec3,
        /// Distance (metres) at which KHR_lights_punctual's window reaches zero; `None`: infinite.
        range: Option<f32>,
    },
    /// A cone with a smooth edge, `(clamp((cosθ − cos outer) / (cos inner − cos outer)))²` as KHR_lights_punctual
    /// recommends.
    Spot {
        /// Metres.
        position: Vec3,
        /// Unit; the way the light shines.
        direction: Vec3,
        /// Luminous intensity on the axis per channel, candela.
        intensity_cd: Vec3,
        /// As for a point light.
        range: Option<f32>,
        /// Half angle (radians) inside which the intensity is full; 0 ≤ inner < outer.
        inner_cone_angle: f32,
        /// Half angle (radians) outside which it is zero; ≤ π/2.
        outer_cone_angle: f32,
    },
    /// Infinitely far away.
    Directional {
        /// Unit; the way the light shines.
        direction: Vec3,
        /// Illuminance per channel on a surface that faces it, lux.
        illuminance_lux: Vec3,
    },
}

impl Light {
    /// Intensity (candela) or illuminance (lux) per channel.
    pub fn color(&self) -> Vec3 {
        match *self {
            Self::Point { intensity_cd, .. } | Self::Spot { intensity_cd, .. } => intensity_cd,
            Self::Directional { illuminance_lux, .. } => illuminance_lux,
        }
    }

    /// The same light elsewhere; a directional one stays.
    pub(crate) fn moved(self, offset: Vec3) -> Self {
        let mut light = self;
        match &mut light {
            Self::Point { position, .. } | Self::Spot { position, .. } => *position += offset,
            Self::Directional { .. } => {}
        }
        light
    }

    /// The same light with a part of its power.
    pub(crate) fn dimmed(self, part: f32) -> Self {
        let mut light = self;
        match &mut light {
            Self::Point { intensity_cd: color, .. }
            | Self::Spot { intensity_cd: color, .. }
            | Self::Directional { illuminance_lux: color, .. } => *color *= part,
        }
        light
    }
}
