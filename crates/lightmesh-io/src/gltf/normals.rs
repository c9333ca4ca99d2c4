//! Shading normals that can be trusted: unit, and never missing.

use glam::{DVec3, Vec3};

/// The unit vector along `v`; `None` for zero and for what is not finite. In double precision the square of no 32-bit
/// float underflows, so the shortest vector has a direction.
pub(super) fn unit(v: Vec3) -> Option<Vec3> {
    v.as_dvec3().try_normalize().map(|unit| unit.as_vec3())
}

/// Normalises `normals`; those that are zero or not finite become zero. Returns how many did.
pub(super) fn normalize(normals: &mut [Vec3]) -> usize {
    let mut broken = 0;
    for normal in normals {
        *normal = unit(*normal).unwrap_or_else(|| {
            broken += 1;
            Vec3::ZERO
        });
    }
    broken
}

/// Bytes that [`replace_zeros`] takes for each normal that it replaces.
pub(super) const REPLACEMENT_BYTES: u64 = (size_of::<u32>() + size_of::<DVec3>()) as u64;

/// Replaces the `broken` normals that are zero by the area-weighted mean of the triangles around their vertex.
pub(super) fn replace_zeros(normals: &mut [Vec3], broken: usize, positions: &[Vec3], triangles: &[[u32; 3]]) {
    // Sorted, so a search tells whether a vertex is one of them.
    let mut vertices = Vec::with_capacity(broken);
    vertices.extend((0..normals.len() as u32).filter(|&i| normals[i as usize] == Vec3::ZERO));
    let mut sums = vec![DVec3::ZERO; vertices.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
        let area_normal = (b - a).cross(c - a);
        for i in triangle {
            if let Ok(at) = vertices.binary_search(i) {
                sums[at] += area_normal;
            }
        }
    }
    // Where triangles cancel, or none uses the vertex, any unit vector will do.
    for (&i, sum) in vertices.iter().zip(sums) {
        normals[i as usize] = sum.try_normalize().unwrap_or(DVec3::Y).as_vec3();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_normals_become_geometric_and_good_ones_unit() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let mut normals = [Vec3::ZERO, Vec3::new(f32::NAN, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO];
        assert_eq!(normalize(&mut normals), 3);
        replace_zeros(&mut normals, 3, &positions, &[[0, 1, 2]]);
        assert_eq!(normals, [Vec3::Z, Vec3::Z, Vec3::Y, Vec3::Y]);
    }

    #[test]
    fn every_length_has_a_direction() {
        for length in [1e-45, 1e-30, 1e-20, 1.0, 1e20, f32::MAX] {
            assert_eq!(unit(Vec3::new(0.0, -length, 0.0)), Some(Vec3::NEG_Y));
            assert!(unit(Vec3::splat(length)).is_some_and(|u| u.is_normalized()));
        }
        assert_eq!(unit(Vec3::INFINITY), None);
    }
}
