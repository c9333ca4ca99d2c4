//! What is done with a scene that could be read.

use lightmesh::{Camera, LightMesh, Method, RenderOptions, Scene, SceneData, Spacing, render};

/// How far an input is followed. Building and rendering take far more time than reading, so that most inputs are only
/// read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Depth {
    /// It is read.
    Read,
    /// What was read is made a [`Scene`].
    Build,
    /// And a small picture of it is rendered.
    Render,
}

impl Depth {
    /// Of 1024 inputs one is rendered and sixteen are built, by their checksum. Where the environment variable
    /// `LIGHTMESH_FUZZ_DEPTH` is `read`, `build` or `render`, it says so for all of them: to find an input again while
    /// it is made smaller.
    pub fn of(input: &[u8]) -> Self {
        static ASKED: std::sync::LazyLock<Option<Depth>> =
            std::sync::LazyLock::new(|| match std::env::var("LIGHTMESH_FUZZ_DEPTH").ok()?.as_str() {
                "read" => Some(Depth::Read),
                "build" => Some(Depth::Build),
                "render" => Some(Depth::Render),
                _ => None,
            });
        let by_checksum = || match crc32fast::hash(input) {
            sum if sum.is_multiple_of(1024) => Self::Render,
            sum if sum.is_multiple_of(64) => Self::Build,
            _ => Self::Read,
        };
        ASKED.unwrap_or_else(by_checksum)
    }
}

/// What a scene that is rendered may have at most: a larger one says no more about hostile input.
const MOST_TRIANGLES: usize = 2_000;
const MOST_LIGHTS: usize = 64;

/// The memory of a render, bytes.
const MEMORY: u64 = 64 << 20;

/// Builds and renders a scene as far as `depth` says.
///
/// # Panics
/// If the scene's picture has a value that is not finite.
pub(crate) fn exercise(data: SceneData, depth: Depth) {
    if depth < Depth::Build {
        return;
    }
    let triangles: usize = data.meshes.iter().map(|mesh| mesh.triangles.len().max(mesh.positions.len())).sum();
    if triangles > MOST_TRIANGLES || data.instances.len() > MOST_TRIANGLES || data.lights.len() > MOST_LIGHTS {
        return;
    }
    let camera = data.cameras.first().cloned();
    let Ok(scene) = Scene::new(data) else { return };
    if depth < Depth::Render {
        return;
    }
    let camera = camera.unwrap_or_else(|| scene.data().framing_camera());
    for method in [Method::Path, Method::MESH] {
        render_small(&scene, &camera, &options(method), None);
    }
}

/// Options of a small picture.
pub(crate) fn options(method: Method) -> RenderOptions {
    RenderOptions::default().with(|o| {
        o.method = method;
        (o.picture.width, o.picture.height, o.picture.spp) = (4, 4, 1);
        o.transport.bounces = 1;
        o.transport.depth = 4;
        o.mesh.gather_rays = Some(4);
        (o.mesh.spacing, o.mesh.indirect_spacing) = (Spacing::Fraction(4.0), Spacing::Fraction(4.0));
        o.limits.max_memory = MEMORY;
    })
}

/// Renders a picture of 4 × 4 pixels, with a mesh that is there or a new one.
///
/// # Panics
/// If it has a value that is not finite.
pub(crate) fn render_small(scene: &Scene, camera: &Camera, options: &RenderOptions, mesh: Option<LightMesh>) {
    let new = || LightMesh::for_cameras(scene, options, std::slice::from_ref(camera));
    let Ok(mut mesh) = mesh.map_or_else(new, Ok) else { return };
    let Ok(frame) = render(scene, camera, options, &mut mesh, &()) else { return };
    if let Some(at) = frame.image.pixels.iter().position(|pixel| !pixel.is_finite()) {
        panic!("not finite: pixel {at} of a picture by {} is {}", options.method, frame.image.pixels[at]);
    }
}
