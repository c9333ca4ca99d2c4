//! A light sample on its way into a tree.

use glam::Vec3;

use super::super::sample::{LightEmission, SampledLight};
use super::Kind;

/// A light sample on its way into a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub light: SampledLight,
    pub lane: u32,
}

impl Leaf {
    /// R + G + B.
    pub(super) fn strength(&self) -> f32 {
        self.light.intensity.element_sum()
    }

    /// Which way it shines; zero for isotropic and directional lights.
    pub(super) fn axis(&self) -> Vec3 {
        match self.light.emission {
            LightEmission::Isotropic | LightEmission::Directional => Vec3::ZERO,
            LightEmission::Patch { normal, .. } => normal,
            LightEmission::Spot { cone, .. } => cone.axis,
        }
    }

    pub(super) fn kind(&self) -> Kind {
        match self.light.emission {
            LightEmission::Isotropic => Kind::Isotropic,
            LightEmission::Patch { back: 0.0, .. } => Kind::OneSided,
            LightEmission::Patch { .. } => Kind::TwoSided,
            LightEmission::Spot { .. } => Kind::Spot,
            LightEmission::Directional => Kind::Directional,
        }
    }

    /// Turns a patch whose both sides shine to have its normal in the upper hemisphere: patches of opposite normals are
    /// alike.
    pub(super) fn upright(mut self) -> Self {
        if let LightEmission::Patch { normal, back, .. } = &mut self.light.emission
            && *back != 0.0
            && normal.to_array() < [0.0; 3]
        {
            *normal = -*normal;
        }
        self
    }
}
