//! The studio: an environment with a soft key light, and the background that is seen in its place.
//!
//! A key light over the left shoulder of the scene's first camera makes forms readable, light all round fills its
//! shadows, and a weaker lobe behind the scene draws its outlines. The background is darker than a white surface and
//! brighter than a black one. All figures are empirical: looked at on product models, buildings, rooms with windows and
//! without a roof.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};

use super::ground_shadow;
use crate::scene::{ImageData, Material, Texels};
use crate::world::Background;
use crate::{Camera, Environment, Scene, SceneData};

/// Luminance of a white surface that faces the key light, where nothing in the scene says what is bright: about that of
/// a lit room, cd/m².
const WHITE: f32 = 100.0;

/// A lobe of light around a direction, `peak · exp(sharpness (cos − 1))`, in units of a white surface.
struct Lobe {
    /// From the scene to the light; the camera looks along −X.
    towards: Vec3,
    peak: f32,
    sharpness: f32,
}

/// The key light: 50° up, 40° to the left of the camera. Its standard deviation is 1/√20 = 13°.
const KEY: Lobe = Lobe { towards: Vec3::new(0.49, 0.77, 0.41), peak: 7.6, sharpness: 20.0 };
/// The light from behind: 35° up, on the other side.
const RIM: Lobe = Lobe { towards: Vec3::new(-0.63, 0.57, -0.53), peak: 1.0, sharpness: 8.0 };
/// The light all round: straight up, at the horizon and straight down.
const FILL: [f32; 3] = [0.32, 0.23, 0.14];
/// The background straight up, at the horizon and straight down.
const BACKGROUND: [f32; 3] = [0.11, 0.15, 0.36];

/// Columns and rows of the map: 5.6°, fine enough for the key light.
const SIZE: (u32, u32) = (64, 32);

impl Lobe {
    fn radiance(&self, direction: Vec3) -> f32 {
        self.peak * libm::expf(self.sharpness * (self.towards.normalize().dot(direction) - 1.0))
    }
}

/// Returns the luminance that a white surface gets, cd/m²: that of the scene's own emission or unlit colours if there
/// are any, so that what glows is as bright beside it as in viewers, whose light has no unit.
pub(super) fn white(data: &SceneData) -> f32 {
    let brightest = used_materials(data).into_iter().map(|m| shown(data, &data.materials[m])).fold(0.0, f32::max);
    if brightest > 0.0 { brightest } else { WHITE }
}

/// Returns the indices of the materials that surfaces have.
pub(super) fn used_materials(data: &SceneData) -> Vec<usize> {
    let meshes = data.instances.iter().map(|i| data.meshes[i.mesh].material);
    let spheres = data.spheres.iter().map(|s| s.material);
    let mut used: Vec<usize> = meshes.chain(spheres).chain(data.shapes.iter().map(|s| s.material)).collect();
    used.sort_unstable();
    used.dedup();
    used
}

/// Returns the largest luminance that a surface shows by itself, cd/m².
pub(super) fn shown(data: &SceneData, material: &Material) -> f32 {
    if material.unlit {
        return 1.0;
    }
    let factor = material.emission.max_element();
    let texture = material.emission_texture.filter(|_| factor > 0.0);
    factor * texture.map_or(1.0, |t| brightest_texel(&data.images[data.textures[t.texture].image]))
}

/// Returns the largest channel of an image of colours, linear.
fn brightest_texel(image: &ImageData) -> f32 {
    match &image.texels {
        Texels::Rgba8(texels) => {
            let byte = texels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).max().unwrap_or(0);
            // The curve of sRGB, near enough.
            libm::powf(f32::from(byte) / 255.0, 2.2)
        }
        Texels::Rgba32F(texels) => texels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).fold(0.0, f32::max),
    }
}

/// Returns the light of the studio, for a scene whose first camera is `view`.
pub(super) fn environment(view: &Camera, white: f32, rotation: f32) -> Environment {
    let (width, height) = SIZE;
    let texel = |i: u32| {
        let (column, row) = (i % width, i / width);
        let (phi, theta) = (TAU * (column as f32 + 0.5) / width as f32, PI * (row as f32 + 0.5) / height as f32);
        let sin = libm::sinf(theta);
        let direction = Vec3::new(-libm::cosf(phi) * sin, libm::cosf(theta), -libm::sinf(phi) * sin);
        let c = fill(direction.y) + KEY.radiance(direction) + RIM.radiance(direction);
        [c, c, c, 1.0]
    };
    let texels: Vec<[f32; 4]> = (0..width * height).map(texel).collect();
    let map = ImageData { name: "studio".to_owned(), width, height, texels: Texels::Rgba32F(texels.into()) };
    let world_from_map = Quat::from_rotation_y(azimuth(view) + rotation);
    Environment { map: Some(map), radiance: Vec3::splat(white), world_from_map }
}

/// Returns the angle about +Y that turns +X to where the camera is, seen from what it looks at.
fn azimuth(view: &Camera) -> f32 {
    let m = &view.world_from_camera.matrix3;
    let level = |axis: Vec3| Vec3::new(axis.x, 0.0, axis.z);
    let (back, up) = (m.z_axis.as_vec3(), m.y_axis.as_vec3());
    // Straight down, the lower edge of the picture is where the camera stands.
    let towards = if level(back).length() > 0.1 * back.length() { level(back) } else { -level(up) * back.y.signum() };
    libm::atan2f(-towards.z, towards.x)
}

/// The light all round, by the height of a direction.
fn fill(up: f32) -> f32 {
    let [zenith, horizon, nadir] = FILL;
    horizon + if up >= 0.0 { (zenith - horizon) * up } else { (nadir - horizon) * -up }
}

/// Returns what the camera sees beyond the scene, with the scene's shadow on the floor.
pub(super) fn background(scene: &Scene, white: f32) -> Background {
    // A little blue sets it off from white and grey models.
    let tint = Vec3::new(0.94, 1.0, 1.08);
    Background { colors: BACKGROUND.map(|c| tint * (c * white)), white_cd_m2: white, shadow: ground_shadow::of(scene) }
}
