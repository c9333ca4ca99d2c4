//! Mesh files: there and back bit for bit, and files that are damaged, cut off, foreign or of something else.

use std::path::Path;

use glam::{Affine3A, Vec3};
use lightmesh::geometry::{Sphere, TriangleMesh};
use lightmesh::{
    Camera, DirectValues, Fingerprint, Image, Instance, Light, LightMesh, Material, Method, RenderOptions, Scene,
    SceneData, Snapshot, Spacing, render,
};
use lightmesh_io::{Error, MeshFile, Provenance, mesh_from_bytes, mesh_to_bytes, read_mesh, write_mesh};

const MEMORY: u64 = 1 << 30;
const METHODS: [Method; 4] = [Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED];

/// A ball on a floor under so many lamps.
fn scene(lamps: u16) -> Scene {
    Scene::new(under_lamps(lamps)).expect("scene")
}

fn under_lamps(lamps: u16) -> SceneData {
    let floor = TriangleMesh {
        positions: vec![Vec3::ZERO, Vec3::new(0.0, 0.0, 4.0), Vec3::new(4.0, 0.0, 4.0), Vec3::new(4.0, 0.0, 0.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    let lamp = |i: u16| Light::Point {
        position: Vec3::new(0.5 + 0.1 * f32::from(i % 30), 3.0, 0.5 + 0.1 * f32::from(i / 30)),
        intensity_cd: Vec3::new(30.0, 20.0, 10.0) / f32::from(lamps),
        range: None,
    };
    SceneData {
        meshes: vec![floor],
        instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
        spheres: vec![Sphere { center: Vec3::new(2.0, 0.5, 2.0), radius: 0.5, material: 0 }],
        materials: vec![Material::lambert(Vec3::splat(0.7))],
        lights: (0..lamps).map(lamp).collect(),
        ..SceneData::default()
    }
}

/// The same in sunshine, which points keep for itself.
fn sunny_scene() -> Scene {
    let mut data = under_lamps(3);
    data.lights.push(Light::Directional { direction: Vec3::NEG_Y, illuminance_lux: Vec3::splat(5.0) });
    Scene::new(data).expect("scene")
}

fn options(method: Method, bounces: u32) -> RenderOptions {
    let spacing = Spacing::Metres(0.5);
    RenderOptions::default().with(|o| {
        o.method = method;
        o.transport.bounces = bounces;
        o.picture.width = 16;
        o.picture.height = 12;
        o.picture.spp = 1;
        o.mesh.gather_rays = Some(16);
        o.mesh.spacing = spacing;
        o.mesh.indirect_spacing = spacing;
    })
}

fn picture(scene: &Scene, eye: [f32; 3], options: &RenderOptions, mesh: &mut LightMesh) -> Image {
    let camera = Camera::look_at(eye.into(), Vec3::new(2.0, 0.3, 2.0), 0.8);
    render(scene, &camera, options, mesh, &()).expect("frame").image
}

fn filled(scene: &Scene, options: &RenderOptions) -> MeshFile {
    let mut mesh = LightMesh::new(scene, options).expect("mesh");
    picture(scene, [2.0, 2.0, 6.0], options, &mut mesh);
    let provenance = Provenance { software: "lightmesh 0.0.0", method: "a method", settings: "{\"spp\":1}" };
    MeshFile::new(scene, options, &mesh, provenance)
}

#[test]
fn what_is_written_is_read_bit_for_bit() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.safetensors");
    for lamps in [3, 600] {
        let scene = scene(lamps);
        for (method, bounces) in METHODS.into_iter().flat_map(|method| [(method, 0), (method, 2)]) {
            let options = options(method, bounces);
            let file = filled(&scene, &options);
            write_mesh(&path, &file).expect("written");
            let back = read_mesh(&path, MEMORY).expect("read");
            assert!(back == file, "{method:?} {lamps}");
            let bytes = std::fs::read(&path).expect("bytes");
            assert!(bytes == mesh_to_bytes(&filled(&scene, &options)), "equal meshes are equal files");
            assert!(mesh_from_bytes("memory", &bytes, MEMORY).expect("read") == file);
            let direct = &file.contents.direct.values;
            let by_light = matches!(method, Method::Hybrid | Method::Unbiased { .. });
            assert_eq!(matches!(direct, DirectValues::Runs { .. }), by_light && lamps == 600);
            assert_eq!(matches!(direct, DirectValues::Lights { .. }), by_light && lamps == 3);

            // Who reads it renders as if it had filled the mesh itself.
            let mut mesh = back.into_mesh(&path, &scene, &options).expect("mesh");
            let elsewhere = [5.0, 2.0, 4.0];
            let shown = picture(&scene, elsewhere, &options, &mut mesh);
            let mut own = LightMesh::new(&scene, &options).expect("mesh");
            assert!(shown == picture(&scene, elsewhere, &options, &mut own), "{method:?} {lamps}");
        }
    }
    let (scene, options) = (sunny_scene(), options(Method::MESH, 2));
    let file = filled(&scene, &options);
    assert!(matches!(file.contents.direct.values, DirectValues::SixAxisParts(_)));
    write_mesh(&path, &file).expect("written");
    assert!(read_mesh(&path, MEMORY).expect("read") == file);
    assert_eq!(std::fs::read_dir(folder.path()).expect("folder").count(), 1);
}

/// Any reader of safetensors sees the arrays of the documentation.
#[test]
fn other_readers_open_it() {
    let file = filled(&scene(3), &options(Method::MESH, 2));
    let bytes = mesh_to_bytes(&file);
    let tensors = safetensors::SafeTensors::deserialize(&bytes).expect("safetensors");
    let n = file.contents.direct.points.addresses.len();
    let six_axis = tensors.tensor("direct.six_axis").expect("values");
    assert_eq!((six_axis.dtype(), six_axis.shape()), (safetensors::Dtype::F32, [n, 6, 2, 3].as_slice()));
    let positions = tensors.tensor("direct.positions").expect("positions");
    let first: Vec<f32> =
        positions.data()[..12].chunks(4).map(|c| f32::from_le_bytes(c.try_into().expect("4"))).collect();
    assert_eq!(first, file.contents.direct.points.positions()[0]);
    let m = file.contents.indirect.as_ref().expect("indirect").points.addresses.len();
    assert_eq!(tensors.tensor("indirect.values").expect("values").shape(), [3, m, 6, 3]);
    assert_eq!(tensors.len(), 9 + 11);
    // Arrays begin at multiples of eight bytes.
    assert_eq!(u64::from_le_bytes(bytes[..8].try_into().expect("8")) % 8, 0);
}

/// A message of one line that names the file, and no panic, wherever a file ends.
#[test]
fn files_that_are_cut_off_are_refused() {
    let bytes = mesh_to_bytes(&filled(&scene(3), &options(Method::Hybrid, 1)));
    for end in (0..bytes.len()).filter(|end| end % 3 == 0 || *end < 100 || bytes.len() - end < 100) {
        let message = mesh_from_bytes("cut.safetensors", &bytes[..end], MEMORY).expect_err("cut off").to_string();
        assert!(message.starts_with("cut.safetensors: ") && !message.contains('\n'), "{end}: {message}");
    }
    let mut longer = bytes;
    longer.push(0);
    let message = mesh_from_bytes("long", &longer, MEMORY).expect_err("longer").to_string();
    assert!(message.contains("arrays: end at byte"), "{message}");
}

/// Whatever byte is damaged: an error, or the same contents.
#[test]
fn damaged_files_are_refused_or_read_the_same() {
    let file = filled(&scene(3), &options(Method::Hybrid, 1));
    let bytes = mesh_to_bytes(&file);
    let mut refused = 0;
    for i in 0..bytes.len() {
        // All of the header, and every few bytes of the rest.
        if i > 5000 && i % 13 != 0 {
            continue;
        }
        for flip in [0x01, 0x10, 0x80] {
            let mut damaged = bytes.clone();
            damaged[i] ^= flip;
            match mesh_from_bytes("damaged", &damaged, MEMORY) {
                Ok(read) => assert!(read.contents == file.contents, "byte {i}"),
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().contains('\n'), "{error}");
                }
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}

/// A file whose header says this, with so many bytes after it.
fn with_header(header: &str, data: usize) -> Vec<u8> {
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend_from_slice(header.as_bytes());
    bytes.resize(bytes.len() + data, 0);
    bytes
}

#[test]
fn foreign_and_hostile_files_are_refused() {
    let message = |bytes: &[u8]| mesh_from_bytes("x", bytes, MEMORY).expect_err("refused").to_string();
    assert!(message(b"").contains("the file has 0 bytes"));
    assert!(message(b"\x89PNG\r\n\x1a\n and so on").contains("is this a mesh file"));
    assert!(message(&u64::MAX.to_le_bytes()).contains("would be 18446744073709551615 bytes"));
    assert!(message(&with_header("[1, 2]", 0)).contains("header: "));
    let weights = "{\"w\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}";
    assert!(message(&with_header(weights, 8)).contains("does not say that its format"));
    let of = |metadata: &str, tensors: &str| {
        format!("{{\"__metadata__\":{{\"format\":\"lightmesh mesh\"{metadata}}}{tensors}}}")
    };
    assert!(message(&with_header(&of(",\"version\":\"1\"", ""), 0)).contains("version \"1\" is not read"));
    let huge = ",\"a\":{\"dtype\":\"U8\",\"shape\":[2305843009213693951],\"data_offsets\":[0,2305843009213693951]}";
    assert!(message(&with_header(&of(",\"version\":\"2\"", huge), 8)).contains("arrays: end at byte 2305843009"));
    assert!(message(&with_header(&of(",\"version\":\"2\"", ""), 0)).contains("is missing"));
    let texts = ",\"version\":\"2\",\"software\":\"\",\"method\":\"\",\"settings\":\"\",\"scene\":\"0\",\"settings_fingerprint\":\"0\",\"crc32\":\"{}\"";
    let text = message(&with_header(&of(texts, ""), 0));
    assert_eq!(text, "x: direct.lattice_spacing: the array is missing");
    let wrong = ",\"direct.lattice_spacing\":{\"dtype\":\"U8\",\"shape\":[8],\"data_offsets\":[0,8]}";
    let text = message(&with_header(&of(texts, wrong), 8));
    assert_eq!(text, "x: direct.lattice_spacing: is U8 [8], not F32 [any]");
}

/// Files whose checksums are right and whose numbers are not finite, in each array of floats.
#[test]
fn numbers_that_are_not_finite_are_refused() {
    let file = filled(&scene(3), &options(Method::MESH, 2));
    let refusal = |change: &dyn Fn(&mut Snapshot)| {
        let mut file = file.clone();
        change(&mut file.contents);
        mesh_from_bytes("x", &mesh_to_bytes(&file), MEMORY).expect_err("not finite").to_string()
    };
    let message = refusal(&|contents| match &mut contents.direct.values {
        DirectValues::SixAxis(values) => values[3 + 2 * 3 * 2] = f32::NAN,
        _ => panic!("another encoding"),
    });
    assert_eq!(message, "x: direct.six_axis: number [0, 2, 1, 0] is NaN, not finite");
    let message = refusal(&|contents| {
        let indirect = contents.indirect.as_mut().expect("bounces");
        *indirect.values.last_mut().expect("values") = f32::INFINITY;
    });
    let points = file.contents.indirect.as_ref().expect("bounces").points.addresses.len();
    assert_eq!(message, format!("x: indirect.values: number [2, {}, 5, 2] is inf, not finite", points - 1));
    let message = refusal(&|contents| contents.indirect.as_mut().expect("bounces").hit_irradiance = f64::NAN);
    assert_eq!(message, "x: indirect.hit_irradiance: number [0] is NaN, not finite");
    let message = refusal(&|contents| contents.direct.points.lattices[0].origin[1] = f32::NEG_INFINITY);
    assert_eq!(message, "x: direct.lattice_origin: number [0, 1] is -inf, not finite");
}

#[test]
fn memory_is_paid_for_before_it_is_taken() {
    let bytes = mesh_to_bytes(&filled(&scene(3), &options(Method::MESH, 2)));
    for limit in [0, 5000, bytes.len() as u64 / 2] {
        let error = mesh_from_bytes("x", &bytes, limit).expect_err("too much");
        assert!(matches!(error, Error::OutOfMemory { limit_bytes, .. } if limit_bytes == limit), "{error}");
    }
}

#[test]
fn files_of_other_scenes_and_settings_are_refused() {
    let (own, other) = (scene(3), scene(4));
    let options = options(Method::MESH, 2);
    let file = filled(&own, &options);
    let path = Path::new("a.safetensors");
    let into = |scene: &Scene, options: &RenderOptions| file.clone().into_mesh(path, scene, options);
    assert!(matches!(into(&other, &options), Err(Error::OtherScene { .. })));
    let finer = options.clone().with(|o| o.mesh.spacing = Spacing::Metres(0.4));
    assert!(matches!(into(&own, &finer), Err(Error::OtherSettings { .. })));
    let more = into(&own, &options.clone().with(|o| o.transport.bounces = 3)).expect_err("more bounces").to_string();
    assert!(more.contains("was made with bounces 2, and the options ask for 3"), "{more}");

    // Fewer bounces are in it.
    let fewer = options.clone().with(|o| o.transport.bounces = 1);
    let mut mesh = into(&own, &fewer).expect("mesh");
    let mut fresh = LightMesh::new(&own, &fewer).expect("mesh");
    assert!(picture(&own, [2.0, 2.0, 6.0], &fewer, &mut mesh) == picture(&own, [2.0, 2.0, 6.0], &fewer, &mut fresh));

    // Contents of another mesh under this one's name.
    let mixed = MeshFile { contents: Snapshot { indirect: None, ..file.contents.clone() }, ..file.clone() };
    let options_without = options.clone().with(|o| o.transport.bounces = 0);
    assert!(mixed.into_mesh(path, &own, &options_without).is_ok());
    let mut bad = file.clone();
    bad.contents.direct.points.addresses[2] = [0, 999, 0, 0];
    let message = bad.into_mesh(path, &own, &options).expect_err("nowhere").to_string();
    assert!(message.starts_with("a.safetensors: mesh contents: direct addresses, point 2: (999, 0, 0)"), "{message}");
    let small = options.with(|o| o.limits.max_memory = 40_000);
    assert!(matches!(into(&own, &small), Err(Error::Mesh { .. })));
    assert_eq!(file.scene, Fingerprint::of_scene(&own));
}

#[test]
fn places_that_cannot_be_read_or_written_are_named() {
    let folder = tempfile::tempdir().expect("folder");
    let file = filled(&scene(3), &options(Method::MESH, 0));
    assert!(matches!(read_mesh(&folder.path().join("none"), MEMORY), Err(Error::Read { .. })));
    assert!(matches!(read_mesh(folder.path(), MEMORY), Err(Error::Read { .. })));
    assert!(matches!(write_mesh(folder.path(), &file), Err(Error::IsFolder { .. })));
    assert!(matches!(write_mesh(&folder.path().join("no/a"), &file), Err(Error::NoFolder { .. })));
}
