//! The lighting plan: how a picture's surfaces get their light, by the method, or so that the error stays within its
//! bound.

use super::per_light::SamplingPolicy;
use crate::mesh::CornerVisibility;
use crate::sampling::{fold_seed, hash};
use crate::{Interpolation, Method, RenderOptions};

/// Gather rays of a pixel whose surfaces gather themselves, shared by its samples, and the most of a sample. Judgements.
const GATHER_RAYS_OF_PIXEL: u32 = 128;
const MOST_GATHER_RAYS: u32 = 64;

/// How surfaces get their light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightingPlan {
    /// Direct light of primary hits.
    pub primary: Shading,
    /// Direct light where gather rays end: only the sum counts.
    pub gather: Shading,
    /// Indirect light of primary hits.
    pub indirect: Indirect,
}

/// How surfaces get their direct light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shading {
    /// A shadow ray to every light sample.
    Exact,
    /// The unshadowed sum times the mesh's mean visibility: formulas (2) and (3g).
    MeanVisibility,
    /// Light by light, with the shadow rays of a policy.
    PerLight { policy: SamplingPolicy, seed: u32 },
    /// A number of shadow rays, with the mesh as control variate.
    Unbiased { rays: u32, seed: u32 },
}

/// How surfaces get their indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Indirect {
    /// Not at all.
    None,
    /// From the indirect mesh: formula (6).
    Mesh {
        /// Short rays of each hit that correct it where surfaces are near; 0: none.
        near_rays: u32,
    },
    /// From gather rays of their own, which read the mesh where they end.
    FinalGather {
        /// Rays of each hit.
        rays: u32,
        /// Other seeds give other rays.
        seed: u64,
    },
    /// From a number of gather rays of their own, with the mesh as control variate where they end.
    Unbiased { rays: u32, seed: u64 },
}

impl Shading {
    /// Returns shading light by light with the seed of the options.
    pub(crate) fn per_light(policy: SamplingPolicy, options: &RenderOptions) -> Self {
        // Not `fold_seed`: seeds below 2³² keep the pictures that they have always had.
        let (low, high) = (options.seed as u32, (options.seed >> 32) as u32);
        Self::PerLight { policy, seed: low ^ hash(high) ^ hash(0) }
    }
}

impl LightingPlan {
    /// Returns the plan of the method.
    pub(crate) fn of(options: &RenderOptions) -> Self {
        let seed = fold_seed(options.seed);
        let unbiased = |rays| Shading::Unbiased { rays, seed };
        let (primary, gather) = match options.method {
            Method::Standard | Method::Path => (Shading::Exact, Shading::Exact),
            Method::Auto { .. } => (Shading::Exact, unbiased(1)),
            Method::Mesh { .. } | Method::Paper { .. } => (Shading::MeanVisibility, Shading::MeanVisibility),
            Method::Hybrid => (Shading::per_light(SamplingPolicy::HYBRID, options), unbiased(1)),
            Method::Unbiased { rays } => (unbiased(rays), unbiased(1)),
        };
        let indirect = match options.method {
            Method::Unbiased { rays } => Indirect::Unbiased { rays, seed: options.seed },
            _ => Indirect::Mesh { near_rays: near_rays(options) },
        };
        Self { primary, gather, indirect }
    }

    /// Returns the plan for meters, each of which is the only sample of what it shows. What a picture would choose for an
    /// error is for meters what *hybrid* does.
    pub(crate) fn of_meters(options: &RenderOptions) -> Self {
        let plan = Self::of(&options.clone().with(|o| o.picture.spp = 1));
        match options.method {
            Method::Auto { .. } => Self { primary: Shading::per_light(SamplingPolicy::HYBRID, options), ..plan },
            _ => plan,
        }
    }

    /// Returns how many gather rays each of so many samples of a pixel shoots, where surfaces gather themselves.
    pub(crate) fn gather_rays(spp: u32) -> u32 {
        GATHER_RAYS_OF_PIXEL.div_ceil(spp).min(MOST_GATHER_RAYS)
    }

    /// Returns the plan for pixels that have so many samples in all.
    pub(crate) fn with_samples(self, options: &RenderOptions, spp: u32) -> Self {
        let indirect = match self.indirect {
            Indirect::Mesh { near_rays } => {
                Indirect::Mesh { near_rays: (near_rays * options.picture.spp).div_ceil(spp) }
            }
            Indirect::FinalGather { seed, .. } => Indirect::FinalGather { rays: Self::gather_rays(spp), seed },
            other => other,
        };
        Self { indirect, ..self }
    }

    /// Returns the plan with other random numbers: samples by which something is chosen must not be used again in the
    /// result, or that has a bias.
    pub(crate) fn reseeded(self) -> Self {
        let primary = match self.primary {
            Shading::Exact | Shading::MeanVisibility => self.primary,
            Shading::PerLight { policy: care, seed } => Shading::PerLight { policy: care, seed: hash(!seed) },
            Shading::Unbiased { rays, seed } => Shading::Unbiased { rays, seed: hash(!seed) },
        };
        Self { primary, ..self }
    }

    /// Returns how vertices that read the mesh like this get their direct light.
    pub(super) fn shading(&self, visibility: CornerVisibility) -> Shading {
        match visibility {
            CornerVisibility::All | CornerVisibility::Deferred { .. } => self.primary,
            CornerVisibility::Stochastic => self.gather,
        }
    }
}

/// Returns how many short rays each sample of a pixel gets. The paper's meshes, and those that are read as it tried, are
/// read as it says.
fn near_rays(options: &RenderOptions) -> u32 {
    let as_in_paper = options.method.is_paper() || options.resolved().interpolation != Interpolation::Trilinear;
    if as_in_paper { 0 } else { options.mesh.near_rays.div_ceil(options.picture.spp) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seed(seed: u64) -> u32 {
        let options = RenderOptions { seed, ..RenderOptions::default() };
        match Shading::per_light(SamplingPolicy::HYBRID, &options) {
            Shading::PerLight { seed, .. } => seed,
            other => panic!("{other:?}"),
        }
    }

    /// Equal halves too: 0x1_0000_0001 chose the shadow rays of 0 once.
    #[test]
    fn both_halves_of_the_seed_choose_shadow_rays() {
        assert_eq!([0, 7, u64::from(u32::MAX)].map(seed), [0, 7, u32::MAX]);
        let seeds = [0, 1, 1 << 32, 0x1_0000_0001, 0x2_0000_0000, 0x2_0000_0002, u64::MAX];
        let distinct: std::collections::HashSet<u32> = seeds.into_iter().map(seed).collect();
        assert_eq!(distinct.len(), seeds.len());
    }
}
