//! `lightmesh info`.

use glam::{DVec3, Vec3};
use lightmesh::geometry::Aabb;
use lightmesh::{Camera, EmitterOptions, ImageData, Light, Limits, Projection, Scene, SceneData, Texels, human_bytes};
use lightmesh_io::LoadOptions;
use serde::Serialize;

use crate::{args::InfoArgs, exit::Failure, machine, terminal};

/// The contents of a scene file.
#[derive(Debug, Serialize)]
struct Info {
    scene: String,
    triangles: Triangles,
    meshes: usize,
    instances: usize,
    spheres: usize,
    materials: usize,
    emissive_materials: usize,
    textures: Vec<TextureInfo>,
    lights: Lights,
    /// The map of the environment; `null`: none.
    environment: Option<TextureInfo>,
    cameras: Vec<CameraInfo>,
    r#box: BoxInfo,
    memory: MemoryInfo,
    warnings: Vec<String>,
}

/// Triangles as stored, and as seen with every instance.
#[derive(Debug, Serialize)]
struct Triangles {
    unique: u64,
    instanced: u64,
}

/// An image.
#[derive(Debug, Serialize)]
struct TextureInfo {
    name: String,
    width: u32,
    height: u32,
    bytes: u64,
}

/// Lights by type.
#[derive(Debug, Default, Serialize)]
struct Lights {
    point: usize,
    spot: usize,
    directional: usize,
}

/// A camera.
#[derive(Debug, Serialize)]
struct CameraInfo {
    index: usize,
    name: String,
    r#type: &'static str,
    /// Vertical field of view; `null` for parallel rays.
    yfov_degrees: Option<f64>,
    /// Height of the view; `null` for a pinhole.
    height_m: Option<f64>,
    aspect: f64,
}

/// What the scene takes, what it may take, and what there is, bytes.
#[derive(Debug, Serialize)]
struct MemoryInfo {
    /// Of the scene, ready for rays.
    scene_bytes: u64,
    /// `--max-memory`, or its default.
    limit_bytes: u64,
    /// Of the machine, or of its control group; `null` where the system does not tell.
    machine_bytes: Option<u64>,
}

/// The box around everything, metres.
#[derive(Debug, Serialize)]
struct BoxInfo {
    min: [f64; 3],
    max: [f64; 3],
    size: [f64; 3],
}

impl BoxInfo {
    /// The box in the file's coordinates.
    fn new(bounds: &Aabb, origin: DVec3) -> Self {
        // The shortest decimals of the floats, not their binary tails.
        let decimal = |x: f32| x.to_string().parse::<f64>().unwrap_or(x.into());
        let decimals = |p: Vec3| DVec3::new(decimal(p.x), decimal(p.y), decimal(p.z));
        let (min, max, size) = (decimals(bounds.min), decimals(bounds.max), decimals(bounds.size()));
        Self { min: (min + origin).to_array(), max: (max + origin).to_array(), size: size.to_array() }
    }
}

/// Reads the scene and says what it holds.
pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let options = LoadOptions {
        allow_outside: args.allow_outside,
        scene: args.scene_name.clone(),
        max_memory: args.max_memory(),
        ..LoadOptions::default()
    };
    let name = args.scene.display().to_string();
    let loaded = lightmesh_io::load(&args.scene, &options).map_err(Failure::input)?;
    let limits = Limits { max_memory: options.max_memory };
    let scene = Scene::within(loaded.data, &EmitterOptions::default(), &limits)
        .map_err(|error| Failure::Input(anyhow::Error::new(error).context(name.clone())))?;
    let mut warnings = loaded.warnings;
    warnings.extend_from_slice(scene.warnings());
    let info = gather(name, &scene, options.max_memory, warnings);
    let text = if args.json { serde_json::to_string_pretty(&info).map_err(Failure::work)? } else { describe(&info) };
    terminal::print(&text).map_err(Failure::work)
}

/// Counts everything in a scene.
fn gather(name: String, scene: &Scene, limit_bytes: u64, warnings: Vec<String>) -> Info {
    let data = scene.data();
    let bounds = scene.bounds();
    Info {
        scene: name,
        triangles: count_triangles(data),
        meshes: data.meshes.len(),
        instances: data.instances.len(),
        spheres: data.spheres.len(),
        materials: data.materials.len(),
        emissive_materials: data.materials.iter().filter(|m| m.emission.max_element() > 0.0).count(),
        textures: data.images.iter().map(texture).collect(),
        lights: count_lights(&data.lights),
        environment: data.environment.as_ref().and_then(|e| e.map.as_ref()).map(texture),
        cameras: data.cameras.iter().enumerate().map(|(index, c)| camera(index, c)).collect(),
        r#box: BoxInfo::new(&bounds, data.origin),
        memory: MemoryInfo { scene_bytes: scene.bytes(), limit_bytes, machine_bytes: machine::memory() },
        warnings,
    }
}

fn count_triangles(data: &SceneData) -> Triangles {
    let of = |mesh: usize| data.meshes.get(mesh).map_or(0, |m| m.triangles.len() as u64);
    Triangles {
        unique: data.meshes.iter().map(|m| m.triangles.len() as u64).sum(),
        instanced: data.instances.iter().map(|i| of(i.mesh)).sum(),
    }
}

fn texture(image: &ImageData) -> TextureInfo {
    let bytes_per_texel = match image.texels {
        Texels::Rgba8(_) => 4,
        Texels::Rgba32F(_) => 16,
    };
    let bytes = u64::from(image.width) * u64::from(image.height) * bytes_per_texel;
    TextureInfo { name: image.name.clone(), width: image.width, height: image.height, bytes }
}

fn count_lights(lights: &[Light]) -> Lights {
    let mut counts = Lights::default();
    for light in lights {
        match light {
            Light::Point { .. } => counts.point += 1,
            Light::Spot { .. } => counts.spot += 1,
            Light::Directional { .. } => counts.directional += 1,
        }
    }
    counts
}

fn camera(index: usize, camera: &Camera) -> CameraInfo {
    let (r#type, yfov_degrees, height_m) = match camera.projection {
        Projection::Perspective { yfov, .. } => ("perspective", Some(f64::from(yfov).to_degrees()), None),
        Projection::Orthographic { ymag, .. } => ("orthographic", None, Some(2.0 * f64::from(ymag))),
    };
    CameraInfo { index, name: camera.name.clone(), r#type, yfov_degrees, height_m, aspect: camera.aspect().into() }
}

/// The text form: one fact per line.
fn describe(info: &Info) -> String {
    let Info { triangles, lights, memory, .. } = info;
    let machine =
        memory.machine_bytes.map_or_else(String::new, |bytes| format!(", the machine has {}", human_bytes(bytes)));
    // Describe what every scene has.
    let mut lines = vec![
        info.scene.clone(),
        format!("triangles  {} ({} with instances)", triangles.unique, triangles.instanced),
        format!("meshes     {}, {} instances", info.meshes, info.instances),
        format!("materials  {}, {} emissive", info.materials, info.emissive_materials),
        format!("lights     {} point, {} spot, {} directional", lights.point, lights.spot, lights.directional),
        format!("box        {} to {}, {} m", triple(info.r#box.min), triple(info.r#box.max), triple(info.r#box.size)),
        format!(
            "memory     {}, the limit is {}{machine}",
            human_bytes(memory.scene_bytes),
            human_bytes(memory.limit_bytes)
        ),
    ];
    // Describe what only some scenes have.
    if info.spheres > 0 {
        lines.push(format!("spheres    {}", info.spheres));
    }
    if let Some(map) = &info.environment {
        lines.push(format!("environment {}x{}", map.width, map.height));
    }
    for texture in &info.textures {
        let name = if texture.name.is_empty() { "(unnamed)" } else { &texture.name };
        lines.push(format!("texture    {name}, {}x{}", texture.width, texture.height));
    }
    for camera in &info.cameras {
        let lens = match (camera.yfov_degrees, camera.height_m) {
            (Some(degrees), _) => format!("{degrees:.1} degrees high"),
            (None, height) => format!("{} m high", height.unwrap_or(0.0)),
        };
        let (index, name, kind, aspect) = (camera.index, &camera.name, camera.r#type, camera.aspect);
        lines.push(format!("camera     {index} {name:?}, {kind}, {lens}, aspect {aspect:.3}"));
    }
    lines.extend(info.warnings.iter().map(|warning| format!("warning    {warning}")));
    lines.join("\n")
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("({x:.3}, {y:.3}, {z:.3})")
}
