//! Rays that find out which corners of its cell a surface point sees, where clearances do not tell.

use super::super::clearance::component;
use super::super::corners::{corner, corners_of};
use super::super::probe::sees;
use super::super::read_result::CornerVisibility;
use super::super::stencil::Stencil;
use super::level_reader::LevelReader;
use crate::geometry::Ray;
use crate::interaction::ShadingPoint;
use crate::sampling::{hash, seed_of_position, unit_f32};

impl LevelReader<'_> {
    /// Returns those of the usable corners that the vertex sees, or one of them. By their clearances, some may be
    /// `occluded`.
    #[cold]
    pub(super) fn trace_occlusion(&mut self, vertex: &ShadingPoint, stencil: &Stencil, usable: u8, occluded: u8) -> u8 {
        match self.visibility {
            CornerVisibility::All => {
                let visible = self.trace_components(vertex, stencil, usable, occluded);
                if visible != 0 { visible } else { self.trace_each(vertex, usable) }
            }
            CornerVisibility::Stochastic => self.trace_until_visible(vertex, stencil, usable),
            CornerVisibility::Deferred { .. } => usable,
        }
    }

    /// Traces a ray to each corner that may be occluded. Of the others, one ray to the heaviest decides about all of
    /// its component, and none is traced if there is one component and nothing of it is hidden.
    fn trace_components(&mut self, vertex: &ShadingPoint, stencil: &Stencil, usable: u8, occluded: u8) -> u8 {
        // Trace each corner that may be occluded.
        let mut visible = self.trace_each(vertex, occluded);

        // Decide about the others component by component.
        let mut rest = usable;
        while rest != 0 {
            let component = component(&self.cell.free_edges, rest);
            rest &= !component;
            let unoccluded = component & !occluded;
            let heavier = |a: &usize, b: &usize| stencil.weight(*a).total_cmp(&stencil.weight(*b));
            let Some(heaviest) = corners_of(unoccluded).max_by(heavier) else { continue };
            let is_whole_and_visible = component == usable && occluded & !visible == 0;
            if is_whole_and_visible || self.sees(vertex, heaviest) {
                visible |= unoccluded;
            }
        }
        visible
    }

    /// Returns those of some corners that the vertex sees, by a ray to each.
    pub(super) fn trace_each(&mut self, vertex: &ShadingPoint, corners: u8) -> u8 {
        corners_of(corners).filter(|&k| self.sees(vertex, k)).map(|k| 1 << k).sum()
    }

    /// Traces rays to corners in random order until one is visible: among those that the vertex sees, each is returned
    /// with a probability in proportion to its weight. The order is a race in which each corner has a time of its own,
    /// exponential by its weight: which points there are behind a wall does not change it.
    fn trace_until_visible(&mut self, vertex: &ShadingPoint, stencil: &Stencil, corners: u8) -> u8 {
        let seed = hash(seed_of_position(vertex.position));
        let time = |k: usize| -libm::logf(1.0 - unit_f32(hash(seed ^ hash(k as u32)))) / stencil.weight(k);
        let mut order = [(f32::INFINITY, 0); 8];
        for (slot, k) in order.iter_mut().zip(corners_of(corners)) {
            *slot = (time(k), k);
        }
        let order = &mut order[..corners.count_ones() as usize];
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order.iter().find(|&&(_, k)| self.sees(vertex, k)).map_or(0, |&(_, k)| 1 << k)
    }

    /// Returns whether nothing stands between the vertex and corner k.
    fn sees(&mut self, vertex: &ShadingPoint, k: usize) -> bool {
        self.visibility_rays += 1;
        let point = self.level.lattice.point(corner(self.cell.coordinate, k));
        sees(self.scene, &Ray::segment(vertex.origin_towards(point - vertex.position), point))
    }
}

/// Returns one of the weighted items, of which there is at least one, in proportion to their weights.
pub(crate) fn choose<T: Copy>(weighted: impl Iterator<Item = (T, f32)> + Clone, seed: u32) -> T {
    let u = unit_f32(hash(seed));
    let mut rest = u * weighted.clone().map(|(_, weight)| weight).sum::<f32>();
    let mut last = None;
    for (item, weight) in weighted {
        last = Some(item);
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

    /// An item without weight is never chosen.
    #[test]
    fn choices_are_in_proportion_to_their_weights() {
        let weights = [3.0_f32, 0.5, 0.0, 1.0, 2.5, 4.0];
        let mut counts = [0; 6];
        for i in 0..20_000 {
            counts[choose(weights.iter().copied().enumerate(), i)] += 1;
        }
        assert_follows(&counts, &weights.map(f64::from));
    }
}
