//! Every step of writing every kind of output fails once: old files stay whole, and nothing else is left.

use std::fs;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

use glam::{Affine3A, Vec3};
use lightmesh::geometry::TriangleMesh;
use lightmesh::{Camera, Image, Instance, Light, LightMesh, Material, RenderOptions, Scene, SceneData, Spacing};

use crate::output::{Batch, Metadata, Precision, Step, claim, during, write_exr, write_png};
use crate::{Error, MeshFile, Provenance, write_mesh, write_mesh_to};

/// A floor under a lamp, and a mesh of it that knows some points.
fn mesh_file() -> MeshFile {
    let floor = TriangleMesh {
        positions: vec![Vec3::ZERO, Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let scene = Scene::new(SceneData {
        meshes: vec![floor],
        instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        lights: vec![Light::Point { position: Vec3::ONE, intensity_cd: Vec3::ONE, range: None }],
        ..SceneData::default()
    });
    let scene = scene.expect("scene");
    let options = RenderOptions::default().with(|o| {
        (o.picture.width, o.picture.height, o.picture.spp) = (8, 8, 1);
        (o.transport.bounces, o.mesh.spacing) = (0, Spacing::Metres(0.25));
    });
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    lightmesh::render(&scene, &camera(), &options, &mut mesh, &()).expect("picture");
    MeshFile::new(&scene, &options, &mesh, Provenance { software: "lightmesh", method: "mesh", settings: "{}" })
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.3, 1.0, 0.3), Vec3::new(0.3, 0.0, 0.31), 0.8)
}

/// A picture of colours that compress badly, so that files are written in several pieces.
fn picture() -> Image {
    let pixels = (0..64 * 64_u32).map(|i| Vec3::splat((i.wrapping_mul(2_654_435_761) >> 8) as f32)).collect();
    Image::new(64, 64, pixels)
}

/// The names of the outputs, one of each kind.
const OUTPUTS: [&str; 4] = ["a.png", "a.exr", "a.json", "a.mesh"];

/// Writes all kinds of outputs as one batch, as a render does.
fn write_all(folder: &Path, mesh: &MeshFile, picture: &Image) -> Result<(), Error> {
    let metadata = Metadata {
        software: "lightmesh".into(),
        method: "mesh".into(),
        scene: "a.glb".into(),
        settings: "{}".into(),
        seconds: 0.0,
        estimated_error: None,
        spp: 1,
        denoised: None,
        camera: camera(),
    };
    let paths: Vec<PathBuf> = OUTPUTS.iter().map(|name| folder.join(name)).collect();
    let mut files = claim(&paths)?;
    for file in &mut files {
        let written = match file.name().extension().and_then(|e| e.to_str()) {
            Some("png") => write_png(&mut *file, picture, 0.0, &metadata),
            Some("exr") => write_exr(&mut *file, picture, &[], Precision::Single, &metadata),
            Some("json") => file.write_all(&[b'1'; 100_000]),
            _ => write_mesh_to(file, mesh),
        };
        written.map_err(|cause| file.error(cause))?;
    }
    Batch::complete(files)?.commit()
}

/// The files of a folder and their contents.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let mut all: Vec<_> =
        entries.map(|e| (e.file_name().into_string().unwrap(), fs::read(e.path()).unwrap())).collect();
    all.sort();
    all
}

#[test]
fn whatever_fails_old_files_stay_whole() {
    let (mesh, picture) = (mesh_file(), picture());
    for old in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let fill = || {
            for name in OUTPUTS {
                let path = folder.path().join(name);
                if old { fs::write(path, format!("old {name}")).unwrap() } else { fs::remove_file(path).unwrap_or(()) }
            }
        };
        fill();
        let before = contents(folder.path());

        // Without a fault every file is new; each kind of step is taken.
        let (result, steps) = during(&[], || write_all(folder.path(), &mesh, &picture));
        result.unwrap();
        let all_new = || {
            let after = contents(folder.path());
            after.len() == OUTPUTS.len() && after.iter().all(|(_, bytes)| !bytes.starts_with(b"old"))
        };
        assert!(all_new());
        for (step, least) in [(Step::Create, 4), (Step::Write, 8), (Step::Sync, 4), (Step::Rename, 4)] {
            assert!(steps.iter().filter(|&&s| s == step).count() >= least, "{step:?} in {steps:?}");
        }

        for (fails, step) in steps.iter().enumerate() {
            fill();
            let (result, _) = during(&[fails], || write_all(folder.path(), &mesh, &picture));
            match result {
                // Without a second name for the old file its replacement goes on.
                Ok(()) => assert!(*step == Step::Keep && all_new(), "{step:?}"),
                Err(error) => {
                    let message = error.to_string();
                    assert!(matches!(error, Error::Write { .. }), "{step:?}: {message}");
                    assert!(OUTPUTS.iter().any(|name| message.contains(name)), "{step:?}: {message}");
                    assert!(message.contains(&format!("{step:?} fails")), "{step:?}: {message}");
                    assert!(contents(folder.path()) == before, "{step:?}, step {fails}: {message}");
                }
            }
        }
    }
}

/// A file system without second names: what is replaced is said.
#[test]
fn what_cannot_be_taken_back_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a", "b"].map(|name| folder.path().join(name));
    let write = || {
        for path in &paths {
            fs::write(path, "old").unwrap();
        }
        let files = claim(&paths).unwrap();
        Batch::complete(files).unwrap().commit()
    };
    let (result, steps) = during(&[], write);
    result.unwrap();
    let at = |wanted| steps.iter().rposition(|&step| step == wanted).unwrap();
    let (result, _) = during(&[at(Step::Keep), at(Step::Rename)], write);
    let error = result.unwrap_err();
    let message = error.to_string();
    assert!(matches!(error, Error::PartlyWritten { .. }), "{message}");
    assert!(message.contains("b: cannot be written") && message.contains("a is already replaced"), "{message}");
    let after = contents(folder.path());
    assert_eq!(after, [("a".to_owned(), b"".to_vec()), ("b".to_owned(), b"old".to_vec())]);
}

#[test]
fn a_single_mesh_file_stays_whole_too() {
    let mesh = mesh_file();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mesh");
    let (_, steps) = during(&[], || write_mesh(&path, &mesh));
    for fails in 0..steps.len() {
        fs::write(&path, "old").unwrap();
        let (result, _) = during(&[fails], || write_mesh(&path, &mesh));
        assert!(result.unwrap_err().to_string().contains("a.mesh"));
        assert_eq!(contents(folder.path()), [("a.mesh".to_owned(), b"old".to_vec())]);
    }
}

/// Content for a device fails at its steps, too.
#[cfg(unix)]
#[test]
fn a_device_that_fails_leaves_the_files_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let write = || -> Result<(), Error> {
        let mut files = claim(&[path.clone(), PathBuf::from("/dev/null")])?;
        for file in &mut files {
            file.write_all(b"new").and_then(|()| file.rewind()).map_err(|cause| file.error(cause))?;
        }
        Batch::complete(files)?.commit()
    };
    let (_, steps) = during(&[], write);
    let open = steps.iter().position(|&step| step == Step::Open).unwrap();
    for fails in [open, open + 1] {
        fs::write(&path, "old").unwrap();
        let (result, _) = during(&[fails], write);
        assert!(result.unwrap_err().to_string().starts_with("/dev/null: cannot be written"));
        assert_eq!(contents(folder.path()), [("a".to_owned(), b"old".to_vec())]);
    }
}
