//! The lattices of a mesh, from coarse to fine: those for what is far from its focus, the base, and the finer ones that
//! a picture may ask for.

use glam::Vec3;

use super::Lattice;
use super::focus::Focus;
use crate::Error;
use crate::geometry::Aabb;

/// The lattices of a mesh; each has half the spacing of the one before.
#[derive(Clone, Debug)]
pub(crate) struct Levels {
    /// The coarsest first.
    pub lattices: Vec<Lattice>,
    /// The level that surfaces read near the focus. Those before it are for what is farther away, those after it for
    /// what a picture refines. Without a focus the first, which has the whole scene.
    pub base: u32,
    /// Where the mesh is fine.
    pub focus: Option<Focus>,
}

/// How many levels beyond the base there are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FinerLevels {
    /// Which must be there.
    pub needed: u32,
    /// Which may be left out if they would have too many points along an axis; no less than the others.
    pub most: u32,
}

impl Levels {
    /// One lattice over the scene's box, and finer ones. `reach`: see [`Lattice::new`]; `option` names the spacing in
    /// messages.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for too many points along an axis.
    pub(crate) fn over(
        option: &'static str,
        bounds: &Aabb,
        spacing: f32,
        reach: u32,
        finer: FinerLevels,
    ) -> Result<Self, Error> {
        let level = |l: u32| Lattice::new(option, bounds, bounds, spacing / (1 << l) as f32, reach);
        Ok(Self { lattices: finer.collect(0, level)?, base: 0, focus: None })
    }

    /// Lattices about a focus. None of them depends on what is around it: `scene`, its box, only counts points.
    ///
    /// # Errors
    /// [`Error::InvalidOption`] for too many points along an axis.
    pub(crate) fn around(
        option: &'static str,
        focus: Focus,
        scene: &Aabb,
        spacing: f32,
        reach: u32,
        finer: FinerLevels,
    ) -> Result<Self, Error> {
        let base = Focus::MOST_DOUBLINGS;
        let level = |l: u32| {
            let doublings = base.saturating_sub(l);
            let spacing = spacing * 2.0_f32.powi(base as i32 - l as i32);
            // Whole cells around the box. Cells of the level before reach over the border.
            let border = ((focus.radius(doublings) / spacing).ceil() + 4.0) * spacing;
            let covered = Aabb { min: Vec3::from(focus.min) - border, max: Vec3::from(focus.max) + border };
            Lattice::new(option, &covered, scene, spacing, reach)
        };
        Ok(Self { lattices: finer.collect(base, level)?, base, focus: Some(focus) })
    }
}

impl FinerLevels {
    /// Makes the levels up to `base` and beyond.
    fn collect(self, base: u32, level: impl Fn(u32) -> Result<Lattice, Error>) -> Result<Vec<Lattice>, Error> {
        let mut levels = (0..=base + self.needed).map(&level).collect::<Result<Vec<_>, _>>()?;
        levels.extend((base + self.needed + 1..=base + self.most).map_while(|l| level(l).ok()));
        Ok(levels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is outside changes no lattice, and each level has half the spacing of the one before.
    #[test]
    fn the_scene_moves_no_point() {
        let focus = Focus { min: [0.0; 3], max: [6.0, 3.0, 4.0], scale: 6.0 };
        let finer = FinerLevels { needed: 2, most: 2 };
        let shapes = |size: f32| {
            let scene = Aabb { min: Vec3::splat(-size), max: Vec3::splat(size) };
            let levels = Levels::around("spacing", focus, &scene, 0.1, 1, finer).expect("small");
            levels.lattices.iter().map(Lattice::shape).collect::<Vec<_>>()
        };
        assert_eq!(shapes(10.0), shapes(1e5));
        assert_eq!(shapes(1.0).len(), Focus::MOST_DOUBLINGS as usize + 3);
        assert!(shapes(1.0).windows(2).all(|pair| pair[0].spacing == 2.0 * pair[1].spacing));
    }

    /// As far as the scene goes.
    #[test]
    fn points_beyond_the_scene_are_not_counted() {
        let focus = Focus { min: [0.0; 3], max: [6.0, 3.0, 4.0], scale: 6.0 };
        let scene = Aabb { min: Vec3::ZERO, max: Vec3::new(6.0, 3.0, 4.0) };
        let finer = FinerLevels { needed: 0, most: 0 };
        let levels = Levels::around("spacing", focus, &scene, 0.125, 1, finer).expect("small");
        assert_eq!(levels.lattices.last().expect("levels").point_count(), 48 * 24 * 32);
    }
}
