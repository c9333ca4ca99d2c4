//! Where a mesh is fine: about what cameras see. Away from it the spacing doubles with every doubling of the distance,
//! as far as the scene goes, so that neither a ground plane nor a sky dome makes the mesh of a room coarser or larger.

use glam::Vec3;

use crate::geometry::Aabb;

/// A box in which a mesh has its full density. Within half of its longest edge around it the spacing is that of the
/// box; from there on it doubles with every doubling of the distance to the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Its lower corner, metres.
    pub min: [f32; 3],
    /// Its upper corner, metres.
    pub max: [f32; 3],
    /// The length of which [`Spacing::Auto`](crate::Spacing::Auto) is a part, metres: the longest edge of the box, or more
    /// where pictures are so small that they do not show that much.
    pub scale: f32,
}

impl Focus {
    /// Doublings of the spacing beyond the box, at most: from 1 mm to more than 10 km.
    pub(crate) const MOST_DOUBLINGS: u32 = 24;

    /// The focus on a box; `None` where [`Self::is_valid`] says no.
    pub(crate) fn on(bounds: &Aabb, scale: f32) -> Option<Self> {
        let focus = Self { min: bounds.min.to_array(), max: bounds.max.to_array(), scale };
        focus.is_valid().then_some(focus)
    }

    /// Returns whether the box has an extent, and one that a lattice can have: in single precision, positions of points
    /// must be told apart.
    pub(crate) fn is_valid(&self) -> bool {
        let (min, max) = (Vec3::from(self.min), Vec3::from(self.max));
        let (longest, magnitude) = (self.longest_edge(), min.abs().max(max.abs()).max_element());
        let is_fine = min.cmple(max).all() && longest > magnitude * 1e-4 && longest > 1e-18;
        is_fine && longest <= self.scale && self.scale < longest * 1e4
    }

    /// Its longest edge, metres.
    pub(crate) fn longest_edge(&self) -> f32 {
        (Vec3::from(self.max) - Vec3::from(self.min)).max_element()
    }

    /// Returns how far a position is from the box along the axis where it is farthest, metres; at most 0 inside.
    #[inline(always)]
    pub(crate) fn distance(&self, p: Vec3) -> f32 {
        (Vec3::from(self.min) - p).max(p - Vec3::from(self.max)).max_element()
    }

    /// The distance up to which the spacing is doubled `doublings` times, metres.
    pub(crate) fn radius(&self, doublings: u32) -> f32 {
        0.5 * self.longest_edge() * (1_u64 << doublings) as f32
    }

    /// Returns how often the spacing is doubled at a distance: 0 within the first radius.
    pub(crate) fn doublings(&self, distance: f32) -> u32 {
        (0..Self::MOST_DOUBLINGS).find(|&n| distance < self.radius(n)).unwrap_or(Self::MOST_DOUBLINGS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn focus() -> Focus {
        Focus { min: [0.0, 0.0, 0.0], max: [8.0, 3.0, 4.0], scale: 8.0 }
    }

    /// 4 m, 8 m, 16 m … from the box.
    #[test]
    fn the_spacing_doubles_with_every_doubling_of_the_distance() {
        let at = |x: f32| focus().doublings(focus().distance(Vec3::new(x, 1.0, 1.0)));
        assert_eq!([4.0, 11.9, 12.1, 15.9, 16.1, 24.1, 5e9].map(at), [0, 0, 1, 1, 2, 3, 24]);
    }

    #[test]
    fn a_box_without_extent_is_no_focus() {
        let on = |min: Vec3, max: Vec3| Focus::on(&Aabb { min, max }, (max - min).max_element()).is_some();
        assert!(on(Vec3::ZERO, Vec3::X) && on(Vec3::splat(1e3), Vec3::splat(1001.0)));
        assert!(!on(Vec3::ONE, Vec3::ONE) && !on(Vec3::splat(1e6), Vec3::splat(1e6 + 1.0)));
        assert!(!Focus { scale: 1.0, ..focus() }.is_valid() && !Focus { scale: f32::NAN, ..focus() }.is_valid());
        assert!(!on(Vec3::INFINITY, Vec3::NEG_INFINITY) && !on(Vec3::ZERO, Vec3::splat(f32::NAN)));
    }
}
