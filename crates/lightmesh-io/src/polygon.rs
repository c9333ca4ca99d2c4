//! Polygons to triangles.

use glam::{DVec2, Vec3};

/// Larger polygons that are not convex are cut as a fan: ears take time with the cube of the corners.
const MOST_EARS: usize = 256;

/// Cuts a polygon into triangles and hands each, as indices into `corners`, to `emit`. The triangles keep the polygon's
/// winding. Convex polygons become a fan from the first corner; others are cut ear by ear (G. H. Meisters, "Polygons
/// have ears", 1975) in the coordinate plane that shows most of their area. Fewer than three corners give nothing.
pub(crate) fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
    let count = corners.len();
    if count < 3 {
        return;
    }
    let flat = flatten(corners);
    let turn = |a: usize, b: usize, c: usize| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    let convex = (0..count).all(|i| turn(i, (i + 1) % count, (i + 2) % count) >= 0.0);
    let mut left: Vec<usize> = (0..count).collect();
    if !convex && count <= MOST_EARS {
        // Cut corners that stick out and whose triangle holds no other corner; a polygon that crosses itself may have
        // none.
        while left.len() > 3 {
            let n = left.len();
            let ear = (0..n).find(|&i| {
                let [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
                turn(a, b, c) > 0.0
                    && left.iter().all(|&p| [a, b, c].contains(&p) || !inside([flat[a], flat[b], flat[c]], flat[p]))
            });
            let Some(i) = ear else { break };
            emit([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
            left.remove(i);
        }
    }
    for pair in left[1..].windows(2) {
        emit([left[0], pair[0], pair[1]]);
    }
}

/// Projects the polygon onto the coordinate plane where its area is largest, counter-clockwise.
fn flatten(corners: &[Vec3]) -> Vec<DVec2> {
    // Newell's normal: twice the areas of the three projections.
    let next = corners.iter().cycle().skip(1);
    let normal: glam::DVec3 = corners.iter().zip(next).map(|(a, b)| a.as_dvec3().cross(b.as_dvec3())).sum();
    let size = normal.abs();
    let flat = |p: &Vec3| {
        let p = p.as_dvec3();
        if size.x >= size.y && size.x >= size.z {
            DVec2::new(p.y * normal.x.signum(), p.z)
        } else if size.y >= size.z {
            DVec2::new(p.z * normal.y.signum(), p.x)
        } else {
            DVec2::new(p.x * normal.z.signum(), p.y)
        }
    };
    corners.iter().map(flat).collect()
}

/// Returns whether `p` is in the counter-clockwise triangle or on its edge.
fn inside([a, b, c]: [DVec2; 3], p: DVec2) -> bool {
    let left_of = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a) >= 0.0;
    left_of(a, b) && left_of(b, c) && left_of(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(corners: &[Vec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        triangulate(corners, |t| triangles.push(t));
        triangles
    }

    /// The triangles of an L, from every first corner and on every side, have areas that sum to the polygon's: none
    /// overlap.
    #[test]
    fn concave_polygons_keep_their_area() {
        let ell = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        let planes: [fn(f32, f32) -> Vec3; 3] =
            [|x, y| Vec3::new(x, y, 5.0), |x, y| Vec3::new(7.0, x, -y), |x, y| Vec3::new(x, 1.0, y)];
        for plane in planes {
            for first in 0..6 {
                let corners: Vec<Vec3> = (0..6).map(|i| ell[(first + i) % 6]).map(|(x, y)| plane(x, y)).collect();
                let area =
                    |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]).length() / 2.0;
                let triangles = cut(&corners);
                assert_eq!(triangles.len(), 4);
                assert_eq!(triangles.into_iter().map(area).sum::<f32>(), 4.0, "first corner {first}");
            }
        }
    }

    #[test]
    fn convex_polygons_are_fans_and_too_few_corners_are_nothing() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        assert_eq!(cut(&square), [[0, 1, 2], [0, 2, 3]]);
        assert!(cut(&square[..2]).is_empty());
        assert_eq!(cut(&[Vec3::ONE; 5]).len(), 3);
    }
}
