//! The ambient cube: values for the six faces of a cube around a point, and how a normal weighs them.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec3, Vec4};

/// The three faces of the ambient cube that a normal points to (0 to 5: +x, −x, +y, −y, +z, −z), and their weights: a
/// surface of normal n gets Σ n_a² value(face of axis a).
pub(crate) struct AmbientCube {
    pub faces: [usize; 3],
    /// By axis.
    pub squares: Vec3,
}

impl AmbientCube {
    /// Returns the faces and weights of a unit normal.
    pub(crate) fn facing(n: Vec3) -> Self {
        let faces = [usize::from(n.x < 0.0), 2 + usize::from(n.y < 0.0), 4 + usize::from(n.z < 0.0)];
        Self { faces, squares: n * n }
    }

    /// Returns the radiance that arrives from the unit direction `d` where faces have the irradiance `values`.
    #[inline(always)]
    pub(crate) fn radiance(d: Vec3, values: &[Vec4; 6]) -> Vec4 {
        let shares = Self::radiance_shares(d);
        values.iter().zip(shares).map(|(&value, share)| value * share).sum::<Vec4>() * FRAC_1_PI
    }

    /// How much each face's irradiance counts in the radiance from the unit direction `d`, times π, that lights the faces so: as
    /// if light were of degree two in d. Irradiance blurs what is of degree one to 2/3 of it and of degree two to 1/4
    /// (Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps", SIGGRAPH 2001); here that
    /// is undone. Over the hemisphere of an axis, in proportion to the cosine, the mean is the irradiance on its face.
    #[inline(always)]
    fn radiance_shares(d: Vec3) -> [f32; 6] {
        // Of degree two: four times how far d² is from its mean over the axes. Of degree one: 3/2 of d.
        let even = (Vec3::splat(1.0 / 3.0) + (d * d - 1.0 / 3.0) * 4.0) * 0.5;
        let odd = d * (0.5 * 1.5);
        let ([x, y, z], [u, v, w]) = ((even + odd).to_array(), (even - odd).to_array());
        [x, u, y, v, z, w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{INV_GOLDEN, sample_cosine_hemisphere, unit_f32};
    use glam::Vec2;

    /// What is blurred comes back: the light that a face gets of all directions is what the face says, whatever the others say. The
    /// tolerance is empirical.
    #[test]
    fn radiance_lights_the_faces_as_they_say() {
        let n = 1_u32 << 12;
        let mut sums = [0.0; 6];
        for i in 0..n {
            let u = Vec2::new((i as f32 + 0.5) / n as f32, unit_f32(i.wrapping_mul(INV_GOLDEN)));
            let shares = AmbientCube::radiance_shares(sample_cosine_hemisphere(u));
            sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share / n as f32);
        }
        for (face, sum) in sums.into_iter().enumerate() {
            let expected = if face == 4 { 1.0 } else { 0.0 };
            assert!((sum - expected).abs() < 2e-3, "face {face}: {sum}");
        }
    }
}
