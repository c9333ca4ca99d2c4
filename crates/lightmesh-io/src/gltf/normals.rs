//! Shading normals that can be trusted: unit, and never missing.

use glam::Vec3;

/// Normalises `normals` and replaces those that are zero or not finite by the area-weighted mean of the triangles around their
/// vertex. Returns how many were replaced.
pub(super) fn mend(normals: &mut [Vec3], positions: &[Vec3], triangles: &[[u32; 3]]) -> u64 {
    let mut broken: Vec<u32> = Vec::new();
    for (i, normal) in normals.iter_mut().enumerate() {
        match normal.try_normalize() {
            Some(unit) => *normal = unit,
            None => {
                *normal = Vec3::ZERO;
                broken.push(i as u32);
            }
        }
    }
    if broken.is_empty() {
        return 0;
    }
    // Sum the geometric normals at broken vertices; `broken` is sorted, so a search tells which they are.
    for &triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        let area_normal = (b - a).cross(c - a);
        for i in triangle {
            if area_normal.is_finite() && broken.binary_search(&i).is_ok() {
                normals[i as usize] += area_normal;
            }
        }
    }
    // Where triangles cancel, or none uses the vertex, any unit vector will do.
    for &i in &broken {
        normals[i as usize] = normals[i as usize].normalize_or(Vec3::Y);
    }
    broken.len() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_normals_become_geometric_and_good_ones_unit() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let mut normals = [Vec3::ZERO, Vec3::new(f32::NAN, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO];
        assert_eq!(mend(&mut normals, &positions, &[[0, 1, 2]]), 3);
        assert_eq!(normals, [Vec3::Z, Vec3::Z, Vec3::Y, Vec3::Y]);
    }
}
