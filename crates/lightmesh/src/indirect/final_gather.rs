//! Indirect light at surfaces that no mesh point can serve: gather rays from the surface itself.
//!
//! Where a ray ends the mesh is read. Where that fails again, as everywhere inside a box whose faces are turned inside
//! out, the ray goes on as *one* path: rays that shot as many rays in their turn took 36 to 360 times as long as `path`.

use std::f32::consts::PI;

use glam::Vec3;

use super::control_variate::{GatherPaths, GoOn};
use super::field::IndirectField;
use crate::Error;
use crate::direct::DirectLighting;
use crate::interaction::ShadingPoint;
use crate::mesh::Marks;
use crate::sampling::{seed_of_surface, unit_f32};

/// Most rays from a surface of the picture that no mesh point can serve; those that count for less in the picture,
/// behind several panes of glass, get fewer, one at least.
const FIRST_RAYS: u32 = 2;

/// How many times as many where some of the surfaces that they find can be read: in a narrow gap, or at a seam. Then
/// they are as good as a mesh point's, and end there. The others lie in the same gap as the point, and are taken to
/// receive what it does.
const MORE: u32 = 16;

/// Surfaces that count for less than this are left out by chance, and the others count for more.
const LEAST_SHARE: f32 = 0.1;

/// What other rays are seeded with.
const OTHER_RAYS: u64 = 0x9e37_79b9_7f4a_7c15;

impl IndirectField {
    /// Computes the indirect irradiance at points of the picture that cannot read the mesh: few rays where what they
    /// find cannot read it either, more elsewhere. Each point's rays depend on it alone.
    ///
    /// # Errors
    /// As [`IndirectField::fill`].
    pub(crate) fn gather_without_mesh(
        &mut self,
        direct: &mut DirectLighting<'_, '_>,
        marks: &mut Marks,
        points: &[ShadingPoint],
        bounces: u32,
        seed: u64,
    ) -> Result<Vec<Vec3>, Error> {
        // Leave out some of those that hardly count.
        let mut irradiance = vec![Vec3::ZERO; points.len()];
        let mut by_count: [Vec<usize>; FIRST_RAYS as usize] = Default::default();
        let share = |point: &ShadingPoint| PI * point.weight.max_element();
        for (i, point) in points.iter().enumerate() {
            let share = share(point);
            if unit_f32(seed_of_surface(seed ^ OTHER_RAYS, point.position)) * LEAST_SHARE < share {
                let count = (share * FIRST_RAYS as f32).ceil().clamp(1.0, FIRST_RAYS as f32);
                by_count[count as usize - 1].push(i);
            }
        }

        for (rays, chosen) in (1..).zip(by_count) {
            // Shoot a few rays from each point.
            let paths = GatherPaths { bounces, rays, seed, go_on: GoOn::WithoutMesh };
            let some: Vec<ShadingPoint> = chosen.iter().map(|&i| points[i]).collect();
            let sums = self.follow_paths(direct, marks, &some, paths)?;

            for (&i, sum) in chosen.iter().zip(&sums) {
                irradiance[i] = sum.irradiance;
            }

            // Shoot more instead where that is cheap: I = S + ρI, summed bounce by bounce.
            let readable: Vec<usize> = (0..some.len()).filter(|&i| sums[i].read > 0).collect();
            let again: Vec<ShadingPoint> = readable.iter().map(|&i| some[i]).collect();
            let paths = GatherPaths { rays: MORE * rays, seed: seed ^ OTHER_RAYS, go_on: GoOn::Nowhere, ..paths };
            for (&k, sum) in readable.iter().zip(self.follow_paths(direct, marks, &again, paths)?) {
                irradiance[chosen[k]] = sum.irradiance * geometric_series(sum.gap, bounces);
            }

            // Make up for those that are left out.
            for &i in &chosen {
                irradiance[i] /= (share(&points[i]) / LEAST_SHARE).min(1.0);
            }
        }
        Ok(irradiance)
    }
}

/// 1 + q + q² … + qⁿ, n at most 64: q is an albedo at most, and 0.9 to that power a thousandth.
fn geometric_series(q: Vec3, n: u32) -> Vec3 {
    (0..n.min(64)).fold(Vec3::ONE, |sum, _| sum * q + Vec3::ONE)
}
