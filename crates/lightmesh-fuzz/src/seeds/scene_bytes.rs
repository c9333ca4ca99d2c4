//! Scenes as bytes.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use lightmesh::geometry::{Sphere, TriangleMesh};
use lightmesh::{
    AlphaMode, Camera, Environment, Filter, ImageData, Instance, Light, Material, Projection, SceneData, Texels,
    Texture, TextureRef, UvTransform, Wrap,
};
use lightmesh_io::scene_to_bytes;

use super::Seed;

pub(crate) fn seeds() -> Vec<Seed> {
    [("small", small_scene()), ("rich", rich_scene())]
        .map(|(name, scene)| Seed::new(format!("{name}.bytes"), scene_to_bytes(&scene).expect("no shapes of the user")))
        .into()
}

/// A square that faces the camera.
pub(crate) fn small_scene() -> SceneData {
    let square = TriangleMesh {
        positions: vec![
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(-1.0, 1.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    SceneData {
        meshes: vec![square],
        instances: vec![Instance { mesh: 0, world_from_object: Affine3A::IDENTITY }],
        materials: vec![Material::lambert(Vec3::splat(0.7))],
        cameras: vec![Camera::look_at(Vec3::new(0.0, 0.5, 4.0), Vec3::ZERO, 0.7)],
        ..SceneData::default()
    }
}

/// Something of everything that a scene can have.
pub(crate) fn rich_scene() -> SceneData {
    let mut scene = small_scene();
    let square = &mut scene.meshes[0];
    square.normals = vec![Vec3::Z; 4];
    square.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4];
    square.uvs = [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], vec![Vec2::ONE; 4]];
    square.colors = vec![Vec4::ONE; 4];
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(1.0), Vec3::new(0.5, 0.0, -1.0));
    scene.instances.push(Instance { mesh: 0, world_from_object: turned });
    scene.spheres = vec![
        Sphere { center: Vec3::new(0.0, 0.5, 1.0), radius: 0.3, material: 1 },
        Sphere { center: Vec3::new(1.0, 2.0, 1.0), radius: 0.1, material: 2 },
    ];
    let image = |name: &str, texels| ImageData { name: name.into(), width: 2, height: 1, texels };
    scene.images = vec![
        image("bytes", Texels::Rgba8(Arc::from([[255, 128, 0, 255], [0, 0, 0, 64]]))),
        image("floats", Texels::Rgba32F(Arc::from([[0.5, 0.5, 1.0, 1.0]; 2]))),
    ];
    let texture =
        |image| Texture { image, wrap_s: Wrap::Repeat, wrap_t: Wrap::MirroredRepeat, filter: Filter::Bilinear };
    scene.textures = vec![texture(0), texture(1)];
    let use_of = |texture| Some(TextureRef { texture, uv_set: 0, transform: UvTransform::default() });
    let base = &mut scene.materials[0];
    (base.base_color_texture, base.normal_texture, base.alpha_mode) = (use_of(0), use_of(1), AlphaMode::Blend);
    scene.materials.push(Material { transmission: 1.0, roughness: 0.0, ior: 1.5, ..Material::default() });
    scene.materials.push(Material { emission: Vec3::splat(500.0), ..Material::default() });
    scene.lights = vec![
        Light::Point { position: Vec3::new(0.0, 2.0, 2.0), intensity_cd: Vec3::splat(50.0), range: Some(9.0) },
        Light::Spot {
            position: Vec3::new(2.0, 2.0, 2.0),
            direction: Vec3::new(-1.0, -1.0, -1.0).normalize(),
            intensity_cd: Vec3::splat(20.0),
            range: None,
            inner_cone_angle: 0.1,
            outer_cone_angle: 0.6,
        },
        Light::Directional { direction: Vec3::NEG_Y, illuminance_lux: Vec3::splat(5.0) },
    ];
    let sky = image("sky", Texels::Rgba32F(Arc::from([[1.0, 2.0, 3.0, 1.0], [0.0, 0.1, 9.0, 1.0]])));
    scene.environment = Some(Environment { map: Some(sky), radiance: Vec3::ONE, world_from_map: Quat::IDENTITY });
    let parallel = Camera {
        projection: Projection::Orthographic { xmag: 2.0, ymag: 2.0 },
        ..Camera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.7)
    };
    scene.cameras.push(parallel);
    scene
}
