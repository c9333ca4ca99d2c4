//! Which corners of its cell a surface point sees, where clearances do not tell.

use super::super::clearance::component;
use super::super::corners::{corner, set_bits};
use super::super::probe::sees;
use super::super::read_result::CornerVisibility;
use super::super::stencil::Stencil;
use super::Reader;
use crate::geometry::Ray;
use crate::interaction::ShadingPoint;
use crate::sampling::{hash, seed_of_position, unit_f32};

impl Reader<'_> {
    /// Those of the usable corners that the vertex sees, or one of them; some are `parted` from it.
    #[cold]
    pub(super) fn trace_occlusion(&mut self, vertex: &ShadingPoint, stencil: &Stencil, usable: u8, parted: u8) -> u8 {
        match self.sight {
            CornerVisibility::All => {
                let seen = self.trace_components(vertex, stencil, usable, parted);
                if seen != 0 { seen } else { self.trace_each(vertex, usable) }
            }
            CornerVisibility::Stochastic => self.trace_until_visible(vertex, stencil, usable),
            CornerVisibility::Deferred { .. } => usable,
        }
    }

    /// Corners that are parted from the vertex get a ray each; one to the heaviest of the others decides about its piece, unless
    /// there is but one piece and nothing of it is hidden.
    fn trace_components(&mut self, vertex: &ShadingPoint, stencil: &Stencil, usable: u8, parted: u8) -> u8 {
        let mut seen = self.trace_each(vertex, parted);
        let mut rest = usable;
        while rest != 0 {
            let piece = component(&self.free_edges, rest);
            rest &= !piece;
            let together = piece & !parted;
            let heavier = |a: &usize, b: &usize| stencil.weight(*a).total_cmp(&stencil.weight(*b));
            let Some(heaviest) = set_bits(together).max_by(heavier) else { continue };
            let trusted = piece == usable && parted & !seen == 0;
            if trusted || self.sees(vertex, heaviest) {
                seen |= together;
            }
        }
        seen
    }

    pub(super) fn trace_each(&mut self, vertex: &ShadingPoint, corners: u8) -> u8 {
        set_bits(corners).filter(|&k| self.sees(vertex, k)).map(|k| 1 << k).sum()
    }

    /// Corners in random order until one is seen: among those that the vertex sees, each comes out in proportion to its weight.
    fn trace_until_visible(&mut self, vertex: &ShadingPoint, stencil: &Stencil, mut corners: u8) -> u8 {
        let mut seed = seed_of_position(vertex.position);
        while corners != 0 {
            let k = choose(set_bits(corners).map(|k| (k, stencil.weight(k))), seed);
            if self.sees(vertex, k) {
                return 1 << k;
            }
            corners &= !(1 << k);
            seed = hash(seed);
        }
        0
    }

    /// Whether nothing stands between the vertex and corner k.
    fn sees(&mut self, vertex: &ShadingPoint, k: usize) -> bool {
        self.visibility_rays += 1;
        let point = self.level.lattice.point(corner(self.cell, k));
        sees(self.scene, &Ray::segment(vertex.origin_towards(point - vertex.position), point))
    }
}

/// One of the weighted things, of which there is at least one, in proportion to their weights.
pub(crate) fn choose<T: Copy>(weighted: impl Iterator<Item = (T, f32)> + Clone, seed: u32) -> T {
    let u = unit_f32(hash(seed));
    let mut rest = u * weighted.clone().map(|(_, weight)| weight).sum::<f32>();
    let mut last = None;
    for (thing, weight) in weighted {
        last = Some(thing);
        rest -= weight;
        if rest < 0.0 {
            break;
        }
    }
    last.expect("at least one")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::chi_square::assert_follows;

    /// What weighs nothing never comes.
    #[test]
    fn choices_come_in_proportion_to_their_weights() {
        let weights = [3.0_f32, 0.5, 0.0, 1.0, 2.5, 4.0];
        let mut counts = [0; 6];
        for i in 0..20_000 {
            counts[choose(weights.iter().copied().enumerate(), i)] += 1;
        }
        assert_follows(&counts, &weights.map(f64::from));
    }
}
