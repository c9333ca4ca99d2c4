//! What benches of whole frames have in common.

use std::path::{Path, PathBuf};

use lightmesh::{Camera, Method, RenderOptions, SceneData, Spacing};
use lightmesh_io::{LoadOptions, load};

/// A path from the repository's root; cargo starts a bench in its package.
pub(crate) fn from_root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// A scene file and its first camera, or one that sees all of it.
pub(crate) fn open(path: &str) -> Result<(SceneData, Camera), Box<dyn std::error::Error>> {
    let data = load(&from_root(path), &LoadOptions::default())?.data;
    let camera = data.cameras.first().cloned().unwrap_or_else(|| data.framing_camera());
    Ok((data, camera))
}

/// Direct light at 800 × 800, one sample per pixel, from a mesh of so many points along the longest edge.
pub(crate) fn direct_light(method: Method, points: f32) -> RenderOptions {
    RenderOptions::default().with(|o| {
        o.method = method;
        o.picture.width = 800;
        o.picture.height = 800;
        o.picture.spp = 1;
        o.transport.bounces = 0;
        o.mesh.spacing = Spacing::Fraction(points);
    })
}
