//! How far light is followed.

use super::Falloff;

/// How far light is followed, and with what attenuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransportOptions {
    /// Diffuse interreflections; 0 is direct light only, 1 the paper. At most 4096.
    /// [`Method::Standard`](crate::Method::Standard) computes none.
    pub bounces: u32,
    /// How many mirror and refraction events a ray may meet in a row.
    pub depth: u32,
    /// A mirrored or refracted ray that carries less than this fraction of the picture's light is dropped; at least 0
    /// and below 1.
    pub cutoff: f32,
    /// φ3: attenuation of the unshadowed sum, for every method.
    pub falloff: Falloff,
    /// Error of the sum over more than 512 light samples, as a part of all light that arrives at a place: lights that
    /// are far away are taken together as far as it allows (docs/many-lights.md). At least 0 and below 1; 0: every
    /// light by itself. For the methods with a mesh; [`Method::Standard`](crate::Method::Standard) and
    /// [`Method::Path`](crate::Method::Path) know every light.
    pub light_error: f32,
}

impl Default for TransportOptions {
    fn default() -> Self {
        Self { bounces: 3, depth: 8, cutoff: 1e-3, falloff: Falloff::default(), light_error: 0.01 }
    }
}
