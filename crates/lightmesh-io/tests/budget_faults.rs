//! Every step that asks for memory is refused once: the limit is raised from nothing, each time by what the refusal says is
//! missing, until the whole way from the file to the picture and the mesh file fits.

use std::path::{Path, PathBuf};

use lightmesh::{EmitterOptions, LightMesh, Limits, Method, RenderOptions, Scene, render};
use lightmesh_io::{Error, LoadOptions, MeshFile, Provenance, load, mesh_from_bytes, write_mesh_to};

/// What must not happen more often: then a refusal asks for too little again and again.
const MOST_STEPS: usize = 2000;

/// Why a step did not get its memory, and the limit with which it would.
#[derive(Debug)]
struct Refused {
    message: String,
    enough: u64,
}

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        let message = error.to_string();
        match error {
            Error::OutOfMemory { needed_bytes, left_bytes, limit_bytes, .. } => {
                Self { message, enough: limit_bytes + (needed_bytes - left_bytes) }
            }
            other => panic!("no other error may come of a small limit: {other}"),
        }
    }
}

impl From<lightmesh::Error> for Refused {
    fn from(error: lightmesh::Error) -> Self {
        let message = error.to_string();
        match error {
            lightmesh::Error::OutOfMemory { needed_bytes, .. } => Self { message, enough: needed_bytes },
            other => panic!("no other error may come of a small limit: {other}"),
        }
    }
}

/// From the file to the picture and back from the mesh file, within a limit.
fn whole_way(path: &Path, method: Method, max_memory: u64) -> Result<(), Refused> {
    let limits = Limits { max_memory };
    let loaded = load(path, &LoadOptions { max_memory, ..LoadOptions::default() })?;
    let scene = Scene::within(loaded.data, &EmitterOptions::default(), &limits)?;
    let camera = scene.data().cameras.first().cloned().unwrap_or_else(|| scene.data().framing_camera());
    let mut options = RenderOptions { method, limits, ..RenderOptions::default() };
    (options.picture.width, options.picture.height, options.picture.spp) = (24, 16, 1);
    options.mesh.gather_rays = Some(16);
    let mut mesh = LightMesh::for_cameras(&scene, &options, std::slice::from_ref(&camera))?;
    let frame = render(&scene, &camera, &options, &mut mesh, &())?;
    assert_eq!(frame.stats.non_finite_pixels, 0);

    // The file of the mesh, and the mesh of the file.
    if !method.has_mesh() {
        return Ok(());
    }
    let provenance = Provenance { software: "test", method: method.name(), settings: "{}" };
    let mut bytes = Vec::new();
    write_mesh_to(&mut bytes, &MeshFile::new(&scene, &options, &mesh, provenance)).expect("written to memory");
    let file = mesh_from_bytes("mesh", &bytes, max_memory)?;
    match file.into_mesh(Path::new("mesh"), &scene, &options) {
        Ok(_) => Ok(()),
        Err(Error::Mesh { cause, .. }) => Err(cause.into()),
        Err(other) => Err(other.into()),
    }
}

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

#[test]
fn every_refusal_of_memory_is_one_sentence_and_says_what_is_enough() {
    for (name, method) in
        [("cornell.glb", Method::MESH), ("window.glb", Method::Hybrid), ("triangle.glb", Method::Path)]
    {
        let (mut limit, mut steps) = (1, 0);
        while let Err(Refused { message, enough }) = whole_way(&scene(name), method, limit) {
            assert!(!message.contains('\n') && message.contains("--max-memory"), "{message}");
            assert!(enough > limit, "{name} at {limit}: {message}");
            (limit, steps) = (enough, steps + 1);
            assert!(steps < MOST_STEPS, "{name}: {message}");
        }
        assert!(steps > 5, "{name}: {steps} steps up to {limit} bytes");
    }
}
