//! What changes a fingerprint and what does not.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::*;
use crate::geometry::TriangleMesh;
use crate::scene::{EmitterOptions, ImageData, Texels};
use crate::{Camera, Environment, Instance, Light, Material, Method, SceneData, Texture, TextureRef, UvTransform};

fn data() -> SceneData {
    let texels = [[1, 2, 3, 255], [4, 5, 6, 255]];
    let image = |texels| ImageData { name: String::new(), width: 2, height: 1, texels };
    let mut mesh = TriangleMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    mesh.uvs[0] = vec![Vec2::ZERO; 3];
    let texture = TextureRef { texture: 0, uv_set: 0, transform: UvTransform::default() };
    SceneData {
        meshes: vec![mesh],
        instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
        materials: vec![Material { base_color_texture: Some(texture), ..Material::default() }],
        textures: vec![Texture {
            image: 0,
            wrap_s: Default::default(),
            wrap_t: Default::default(),
            filter: Default::default(),
        }],
        images: vec![image(Texels::Rgba8(Arc::new(texels)))],
        lights: vec![Light::Point { position: Vec3::Z, intensity_cd: Vec3::ONE, range: None }],
        environment: Some(Environment {
            map: Some(image(Texels::Rgba32F(Arc::new([[1.0; 4], [2.0; 4]])))),
            radiance: Vec3::ONE,
            world_from_map: Quat::IDENTITY,
        }),
        ..SceneData::default()
    }
}

pub(crate) fn of(data: SceneData) -> Fingerprint {
    Fingerprint::of_scene(&Scene::new(data).expect("scene"))
}

/// Pinned: another machine, or another version of the program, must come to the same numbers. Where values of mesh
/// points become others,
/// [`VALUES_VERSION`] counts up, and the second one changes.
#[test]
fn fingerprints_are_the_same_everywhere() {
    assert_eq!(of(data()).to_string(), "5139fdfc8c9c6cbfc0ad9107744ca1a5");
    assert_eq!(Fingerprint::of_settings(&RenderOptions::default()).to_string(), "58868de8016c0b726f805028f2091250");
}

#[test]
fn digits_read_back() {
    let fingerprint = Fingerprint(0x0123_4567_89ab_cdef);
    assert_eq!(fingerprint.to_string(), "00000000000000000123456789abcdef");
    assert_eq!(fingerprint.to_string().parse(), Ok(fingerprint));
    assert!("xyz".parse::<Fingerprint>().is_err() && "".parse::<Fingerprint>().is_err());
}

#[test]
fn whatever_changes_light_changes_the_fingerprint_of_a_scene() {
    let changes: [fn(&mut SceneData); 14] = [
        |_| {},
        |d| d.meshes[0].positions[1].x = 1.000_001,
        |d| d.meshes[0].triangles[0] = [0, 2, 1],
        |d| d.meshes[0].uvs[0][2].y = 0.5,
        |d| d.meshes[0].normals = vec![Vec3::Z; 3],
        |d| d.instances[0].world_from_object.translation.y = 1e-3,
        |d| d.instances.push(Instance { mesh: 0, world_from_object: Affine3A::from_translation(Vec3::X) }),
        |d| d.materials[0].emission = Vec3::X,
        |d| d.materials[0].double_sided = true,
        |d| d.materials[0].base_color_texture = None,
        |d| d.images[0].texels = Texels::Rgba8(Arc::new([[1, 2, 3, 255], [4, 5, 7, 255]])),
        |d| d.lights[0] = Light::Point { position: Vec3::Z, intensity_cd: Vec3::ONE, range: Some(9.0) },
        |d| d.environment = None,
        |d| d.textures[0].wrap_t = crate::scene::Wrap::ClampToEdge,
    ];
    let mut seen = std::collections::HashSet::new();
    for (i, change) in changes.into_iter().enumerate() {
        let mut data = data();
        change(&mut data);
        assert!(seen.insert(of(data)), "change {i}");
    }
    let emitters = EmitterOptions { light_samples: 65, ..EmitterOptions::default() };
    let scene = Scene::with_emitters(data(), &emitters).expect("scene");
    assert!(seen.insert(Fingerprint::of_scene(&scene)));

    // Not light: names and cameras.
    let mut named = data();
    named.materials[0].name = "oak".into();
    named.cameras.push(Camera::look_at(Vec3::ONE, Vec3::ZERO, 1.0));
    assert!(!seen.insert(of(named)));
}

#[test]
fn whatever_changes_mesh_points_changes_the_fingerprint_of_settings() {
    let base = RenderOptions::default();
    let other = |change: fn(&mut RenderOptions)| {
        let mut options = base.clone();
        change(&mut options);
        Fingerprint::of_settings(&options)
    };
    let changes: [fn(&mut RenderOptions); 16] = [
        |_| {},
        |o| o.method = Method::PAPER,
        |o| o.method = Method::Hybrid,
        |o| o.method = Method::with_error(0.05),
        |o| o.mesh.spacing = Spacing::Metres(0.1),
        |o| o.mesh.spacing = Spacing::Fraction(0.1),
        |o| o.mesh.indirect_spacing = Spacing::Metres(0.1),
        |o| o.mesh.interpolation = Interpolation::Nearest,
        |o| o.mesh.interpolation = Interpolation::TrilinearWith(MissingCorners::Mirror),
        |o| o.mesh.weight = PointWeight::Gaussian,
        |o| o.mesh.refine = Some(1),
        |o| o.transport.light_error = 0.02,
        |o| o.mesh.gather_rays = Some(255),
        |o| o.transport.depth = 7,
        |o| o.seed = 1,
        |o| o.transport.falloff = Falloff::ConstantPlusDistance { constant: 1.0 },
    ];
    let seen: std::collections::HashSet<_> = changes.into_iter().map(other).collect();
    assert_eq!(seen.len(), changes.len());
    // Not of mesh points: pictures; and the same points under another name.
    let same: [fn(&mut RenderOptions); 4] = [
        |o| o.picture.width = 7,
        |o| o.picture.spp = 9,
        |o| o.transport.bounces = 1,
        |o| o.mesh.interpolation = Interpolation::Trilinear,
    ];
    assert!(same.into_iter().all(|change| other(change) == other(|_| {})));
    assert_eq!(other(|o| o.method = Method::Hybrid), other(|o| o.method = Method::UNBIASED));
}
