//! Light from infinitely far away, from every direction.

use glam::{Quat, Vec3};

use super::texture::{ImageData, Texels};

/// An environment: the light of rays that leave the scene.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Environment {
    /// A latitude-longitude map of linear RGB, or `None` for 1 in every direction. Row 0 is up (+Y), the middle of the
    /// map is +X, columns go on towards +Z, as Blender's environment textures do after export to glTF's axes, and
    /// three.js': column `u` and row `v` in [0, 1] look along (−cos 2πu sin πv, cos πv, −sin 2πu sin πv).
    pub map: Option<ImageData>,
    /// Luminance per channel of a texel of 1, cd/m².
    pub radiance: Vec3,
    /// Turns the map's directions into the world's.
    pub world_from_map: Quat,
}

/// Returns a soft white sky for scenes without light: 150 cd/m² above, falling smoothly to 50 cd/m² below, so that a
/// white surface that faces it gets the luminance of a lit room, 100 cd/m² on average.
pub fn soft_environment() -> Environment {
    const ROWS: u32 = 32;
    // Linear in the height, cos θ, of a direction: its mean over the sphere is that of the horizon.
    let row = |v: u32| {
        let height = libm::cosf(std::f32::consts::PI * (v as f32 + 0.5) / ROWS as f32);
        let c = 1.0 + 0.5 * height;
        [c, c, c, 1.0]
    };
    let texels: Vec<[f32; 4]> = (0..ROWS).map(row).collect();
    let map = ImageData {
        name: "soft environment".to_owned(),
        width: 1,
        height: ROWS,
        texels: Texels::Rgba32F(texels.into()),
    };
    Environment { map: Some(map), radiance: Vec3::splat(100.0), world_from_map: Quat::IDENTITY }
}
