//! The origin that a reader chooses for a scene far from the file's.

use glam::{DVec3, Vec3};
use lightmesh::geometry::TriangleMesh;

/// Origins are multiples of this, metres: a power of two, so that whatever is at a multiple of a power of two of a metre
/// stays at one. What is less than half of it from the file's origin keeps it.
const STEP: f64 = 1024.0;

/// Of more places than this every second is looked at, or every third, and so on.
const MOST_PLACES: usize = 4096;

/// The places of a scene's objects, in the file's coordinates, each with a weight.
#[derive(Debug, Default)]
pub(crate) struct WorldOrigin {
    places: Vec<(DVec3, f64)>,
}

impl WorldOrigin {
    /// Adds the places of objects of one kind, which count as much as `weight` together.
    pub(crate) fn add(&mut self, places: &[DVec3], weight: f64) {
        let stride = places.len().div_ceil(MOST_PLACES).max(1);
        let sample = places.iter().step_by(stride).filter(|place| place.is_finite());
        let each = weight / sample.clone().count().max(1) as f64;
        self.places.extend(sample.map(|&place| (place, each)));
    }

    /// Returns the origin: that of the place nearest to the median of all, by axis. A median, so that an object which is
    /// added or moved far away does not move the rest.
    pub(crate) fn choose(&self) -> DVec3 {
        let median = DVec3::from_array([0, 1, 2].map(|axis| self.median(axis)));
        let distance = |place: DVec3| (place - median).abs().element_sum();
        let nearest = self.places.iter().map(|&(place, _)| place).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(DVec3::ZERO, on_grid)
    }

    /// The weighted median along an axis; 0 if there is no place.
    fn median(&self, axis: usize) -> f64 {
        let mut places: Vec<(f64, f64)> = self.places.iter().map(|&(place, weight)| (place[axis], weight)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = 0.5 * places.iter().map(|&(_, weight)| weight).sum::<f64>();
        let mut sum = 0.0;
        let reached = places.iter().find(|&&(_, weight)| {
            sum += weight;
            sum >= half
        });
        reached.map_or(0.0, |&(place, _)| place)
    }
}

/// The nearest multiple of the step.
fn on_grid(place: DVec3) -> DVec3 {
    // Adding zero makes −0 the same as 0.
    (place / STEP).round() * STEP + DVec3::ZERO
}

/// Moves a mesh next to the origin of its own space where it is further from it than it is wide, and returns by how
/// much, a multiple of the step: positions so far away have no digits that are lost.
pub(crate) fn bring_near(mesh: &mut TriangleMesh) -> DVec3 {
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return DVec3::ZERO;
    }
    let (center, size) = (bounds.center().as_dvec3(), f64::from(bounds.size().max_element()));
    let shift = on_grid(center);
    if shift == DVec3::ZERO || !shift.is_finite() || center.abs().max_element() < size {
        return DVec3::ZERO;
    }
    mesh.positions.iter_mut().for_each(|p| *p = relative(p.as_dvec3(), shift));
    shift
}

/// A position relative to an origin.
pub(crate) fn relative(p: DVec3, origin: DVec3) -> Vec3 {
    (p - origin).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(objects: &[DVec3], cameras: &[DVec3]) -> DVec3 {
        let mut places = WorldOrigin::default();
        places.add(objects, 1.0);
        places.add(cameras, 0.25);
        places.choose()
    }

    /// Near the origin it stays; far away it is the nearest multiple of 1024 m; one object far from the others, or a
    /// camera, does not change it.
    #[test]
    fn the_origin_is_where_most_things_are() {
        let near = [DVec3::ZERO, DVec3::new(300.0, -5.0, 100.0), DVec3::new(-3.0, 0.0, 9.0)];
        assert_eq!(origin(&near, &[]), DVec3::ZERO);
        assert_eq!(origin(&[], &[]), DVec3::ZERO);
        let there = near.map(|p| p + DVec3::new(4.5e6, 0.0, -1e5));
        let expected = DVec3::new(4395.0 * 1024.0, 0.0, -98.0 * 1024.0);
        assert_eq!(origin(&there, &[]), expected);
        assert_eq!(origin(&there, &[DVec3::ZERO]), expected);
        let with_moon: Vec<DVec3> = there.into_iter().chain([DVec3::splat(4e8)]).collect();
        assert_eq!(origin(&with_moon, &[]), expected);
    }

    #[test]
    fn a_mesh_far_from_its_own_origin_moves_without_loss() {
        let far = Vec3::new(100_000.0, 0.5, -4096.0);
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Z].map(|p| p + far);
        let mesh = TriangleMesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..TriangleMesh::default() };
        let mut moved = mesh.clone();
        let shift = bring_near(&mut moved);
        assert_eq!(shift, DVec3::new(98.0 * 1024.0, 0.0, -4096.0));
        for (before, after) in mesh.positions.iter().zip(&moved.positions) {
            assert_eq!(after.as_dvec3() + shift, before.as_dvec3());
        }
        // As wide as it is far away: it stays.
        let mut wide = TriangleMesh { positions: vec![Vec3::ZERO, Vec3::X * 4e3, Vec3::Z], ..mesh };
        assert_eq!(bring_near(&mut wide), DVec3::ZERO);
    }
}
