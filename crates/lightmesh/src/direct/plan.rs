//! How a picture's surfaces take their light: what the method says, or what keeps the error within its bound.

use super::per_light::SamplingPolicy;
use crate::mesh::CornerVisibility;
use crate::sampling::{fold_seed, hash};
use crate::{Method, RenderOptions};

/// How surfaces take their light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightingPlan {
    /// Direct light of what the camera sees.
    pub primary: Shading,
    /// Direct light where gather rays end: only the sum counts.
    pub gather: Shading,
    /// Indirect light of what the camera sees.
    pub indirect: Indirect,
}

/// How surfaces take their direct light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shading {
    /// A shadow ray to every light sample.
    Exact,
    /// The unshadowed sum times the mesh's mean visibility: formulas (2) and (3g).
    MeanVisibility,
    /// Light by light, with shadow rays as far as some care wants them.
    PerLight { care: SamplingPolicy, seed: u32 },
    /// The mesh as control variate of so many shadow rays.
    Unbiased { rays: u32, seed: u32 },
}

/// How surfaces take their indirect light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Indirect {
    /// From the indirect mesh: formula (6).
    Mesh,
    /// From gather rays of their own, which read the mesh where they end.
    FinalGather {
        /// Other seeds give other rays.
        seed: u64,
    },
    /// From so many gather rays of their own, with the mesh as control variate where they end.
    Unbiased { rays: u32, seed: u64 },
}

impl Shading {
    /// Light by light, seeded as the options say.
    pub(crate) fn by_light(care: SamplingPolicy, options: &RenderOptions) -> Self {
        // Not `fold_seed`: seeds below 2³² keep the pictures that they have always had.
        let (low, high) = (options.seed as u32, (options.seed >> 32) as u32);
        Self::PerLight { care, seed: low ^ hash(high) ^ hash(0) }
    }
}

impl LightingPlan {
    /// What the method says.
    pub(crate) fn of(options: &RenderOptions) -> Self {
        let seed = fold_seed(options.seed);
        let unbiased = |rays| Shading::Unbiased { rays, seed };
        let (seen, gathered) = match options.method {
            Method::Standard | Method::Path => (Shading::Exact, Shading::Exact),
            Method::Mesh { error: Some(_) } => (Shading::Exact, unbiased(1)),
            Method::Mesh { error: None } | Method::Paper { .. } => (Shading::MeanVisibility, Shading::MeanVisibility),
            Method::Hybrid => (Shading::by_light(SamplingPolicy::HYBRID, options), unbiased(1)),
            Method::Unbiased { rays } => (unbiased(rays), unbiased(1)),
        };
        let indirect = match options.method {
            Method::Unbiased { rays } => Indirect::Unbiased { rays, seed: options.seed },
            _ => Indirect::Mesh,
        };
        Self { primary: seen, gather: gathered, indirect }
    }

    /// The same with other random numbers: what a choice is made by must not be what is chosen for, or the choice has a bias.
    pub(crate) fn reseeded(self) -> Self {
        let seen = match self.primary {
            Shading::Exact | Shading::MeanVisibility => self.primary,
            Shading::PerLight { care, seed } => Shading::PerLight { care, seed: hash(!seed) },
            Shading::Unbiased { rays, seed } => Shading::Unbiased { rays, seed: hash(!seed) },
        };
        Self { primary: seen, ..self }
    }

    /// How vertices that look at the mesh like this take their direct light.
    pub(super) fn shading(&self, sight: CornerVisibility) -> Shading {
        match sight {
            CornerVisibility::All | CornerVisibility::Deferred { .. } => self.primary,
            CornerVisibility::Stochastic => self.gather,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seed(seed: u64) -> u32 {
        let options = RenderOptions { seed, ..RenderOptions::default() };
        match Shading::by_light(SamplingPolicy::HYBRID, &options) {
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
