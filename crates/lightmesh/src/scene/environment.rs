//! Light from infinitely far away, from every direction.

use glam::{Quat, Vec3};

use super::ImageData;

/// An environment: what rays see that leave the scene.
#[derive(Clone, Debug)]
pub struct Environment {
    /// A latitude-longitude map of linear RGB, or `None` for 1 in every direction. Row 0 is up (+Y), the middle of the map is
    /// +X, columns go on towards +Z, as Blender's environment textures do after export to glTF's axes, and three.js':
    /// column `u` and row `v` in [0, 1] look along (−cos 2πu sin πv, cos πv, −sin 2πu sin πv).
    pub map: Option<ImageData>,
    /// Luminance per channel of a texel of 1, cd/m².
    pub radiance: Vec3,
    /// Turns the map's directions into the world's.
    pub world_from_map: Quat,
}

/// How emitters become light samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterOptions {
    /// Samples per area light (all triangles of an emissive mesh together), per spherical light and per environment; 1 to 65536.
    pub light_samples: u32,
    /// Punctual lights become spheres of this radius (metres) and equal power; 0 leaves them points.
    pub light_radius: f32,
}

impl Default for EmitterOptions {
    fn default() -> Self {
        Self { light_samples: 64, light_radius: 0.0 }
    }
}
