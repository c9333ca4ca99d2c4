//! The ambient cube: values for the six faces of a cube around a point, and how a normal weighs them.

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

    /// Returns what a surface of the normal gets of the values of the six faces.
    #[inline(always)]
    pub(crate) fn project(&self, values: &[Vec4; 6]) -> Vec4 {
        let [x, y, z] = self.faces;
        values[x] * self.squares.x + values[y] * self.squares.y + values[z] * self.squares.z
    }
}
