//! The ambient cube: what a point keeps for each of ±x, ±y, ±z, and how a normal weighs it.

use glam::Vec3;

/// The three axes of the ambient cube that a normal faces, by their side (0 to 5: +x, −x, +y, −y, +z, −z), and their
/// weights.
pub(crate) struct AmbientCube {
    pub faces: [usize; 3],
    pub squares: Vec3,
}

impl AmbientCube {
    pub(crate) fn facing(n: Vec3) -> Self {
        let sides = [usize::from(n.x < 0.0), 2 + usize::from(n.y < 0.0), 4 + usize::from(n.z < 0.0)];
        Self { faces: sides, squares: n * n }
    }
}
