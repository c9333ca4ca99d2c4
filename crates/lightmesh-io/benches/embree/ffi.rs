//! The few functions of Embree 4's C interface that the comparison needs, loaded at run time.

use std::ffi::{CString, c_char, c_uint, c_void};
use std::path::{Path, PathBuf};
use std::process::Command;

use glam::Vec3;
use libloading::Library;
use lightmesh::geometry::Ray;

type Handle = *mut c_void;

/// `RTCRayHit`, with room to spare for the instance ids whose number depends on how Embree was built.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instances: [u32; 9],
}

const INVALID: u32 = u32::MAX;

/// How Embree builds its tree.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quality {
    Medium = 1,
    High = 2,
}

/// `RTCSceneFlags`: whether rays may pass between neighbours.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flags {
    None = 0,
    Robust = 4,
}

/// The loaded library.
pub(crate) struct Embree {
    library: Library,
    device: Handle,
}

/// A committed scene with one triangle mesh.
pub(crate) struct EmbreeScene {
    scene: Handle,
    intersect: unsafe extern "C" fn(Handle, *mut RayHit, *const c_void),
    occluded: unsafe extern "C" fn(Handle, *mut RayHit, *const c_void),
}

impl Embree {
    /// Loads the library that `LIGHTMESH_EMBREE` names, or the one of the Python package `embreex`; one thread.
    pub(crate) fn load() -> Result<Self, String> {
        let path = find().ok_or("set LIGHTMESH_EMBREE to libembree4, or pip install embreex")?;
        // SAFETY: loading Embree runs only its static initialisers; the signature is that of rtcore_device.h, and an
        // empty configuration string outlives the call.
        unsafe {
            let library = Library::new(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            let config = CString::new("threads=1").map_err(|e| e.to_string())?;
            let new: unsafe extern "C" fn(*const c_char) -> Handle =
                *library.get(b"rtcNewDevice\0").map_err(|e| e.to_string())?;
            let device = new(config.as_ptr());
            if device.is_null() { Err("rtcNewDevice failed".into()) } else { Ok(Self { library, device }) }
        }
    }

    /// Builds a scene of these triangles.
    pub(crate) fn scene(&self, triangles: &[[Vec3; 3]], quality: Quality, flags: Flags) -> Result<EmbreeScene, String> {
        // SAFETY: signatures and constants are those of rtcore_scene.h and rtcore_geometry.h of Embree 4; each buffer
        // is written within the size it was created with.
        unsafe {
            macro_rules! function {
                ($name:literal, $type:ty) => {{
                    let f: $type = *self.library.get(concat!($name, "\0").as_bytes()).map_err(|e| e.to_string())?;
                    f
                }};
            }
            let scene = function!("rtcNewScene", unsafe extern "C" fn(Handle) -> Handle)(self.device);
            function!("rtcSetSceneFlags", unsafe extern "C" fn(Handle, c_uint))(scene, flags as c_uint);
            function!("rtcSetSceneBuildQuality", unsafe extern "C" fn(Handle, c_uint))(scene, quality as c_uint);
            let geometry = function!("rtcNewGeometry", unsafe extern "C" fn(Handle, c_uint) -> Handle)(self.device, 0);
            type NewBuffer = unsafe extern "C" fn(Handle, c_uint, c_uint, c_uint, usize, usize) -> *mut c_void;
            let new_buffer = function!("rtcSetNewGeometryBuffer", NewBuffer);
            let [index, vertex, uint3, float3]: [c_uint; 4] = [0, 1, 0x5003, 0x9003];
            let vertices = new_buffer(geometry, vertex, 0, float3, 12, 3 * triangles.len()).cast::<f32>();
            let indices = new_buffer(geometry, index, 0, uint3, 12, triangles.len()).cast::<u32>();
            for (i, corner) in triangles.iter().flatten().enumerate() {
                for axis in 0..3 {
                    vertices.add(3 * i + axis).write(corner[axis]);
                }
                indices.add(i).write(i as u32);
            }
            function!("rtcCommitGeometry", unsafe extern "C" fn(Handle))(geometry);
            function!("rtcAttachGeometry", unsafe extern "C" fn(Handle, Handle) -> c_uint)(scene, geometry);
            function!("rtcReleaseGeometry", unsafe extern "C" fn(Handle))(geometry);
            function!("rtcCommitScene", unsafe extern "C" fn(Handle))(scene);
            type Query = unsafe extern "C" fn(Handle, *mut RayHit, *const c_void);
            Ok(EmbreeScene {
                scene,
                intersect: function!("rtcIntersect1", Query),
                occluded: function!("rtcOccluded1", Query),
            })
        }
    }
}

impl EmbreeScene {
    /// Distance and triangle of the closest hit.
    pub(crate) fn closest(&self, ray: &Ray) -> Option<(f32, u32)> {
        let mut query = RayHit::new(ray);
        // SAFETY: the query is at least as large as RTCRayHit and as aligned; null arguments mean the defaults.
        unsafe { (self.intersect)(self.scene, &mut query, std::ptr::null()) };
        (query.geometry != INVALID).then_some((query.t_far, query.primitive))
    }

    /// Whether anything is hit.
    pub(crate) fn occluded(&self, ray: &Ray) -> bool {
        let mut query = RayHit::new(ray);
        // SAFETY: as above; RTCRay is the head of RTCRayHit.
        unsafe { (self.occluded)(self.scene, &mut query, std::ptr::null()) };
        query.t_far < 0.0
    }
}

impl RayHit {
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            t_near: ray.t_min,
            direction: ray.direction.to_array(),
            time: 0.0,
            t_far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: INVALID,
            geometry: INVALID,
            instances: [INVALID; 9],
        }
    }
}

/// The library's path: from the environment, or asked of Python.
fn find() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("LIGHTMESH_EMBREE") {
        return Some(path.into());
    }
    let code = "import embreex, os; print(os.path.dirname(embreex.__file__))";
    let output = Command::new("python3").args(["-c", code]).output().ok()?;
    let package = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim());
    let libraries = package.parent()?.join("embreex.libs");
    let named = |p: &Path| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libembree4"));
    std::fs::read_dir(libraries).ok()?.filter_map(|e| Some(e.ok()?.path())).find(|p| named(p))
}
