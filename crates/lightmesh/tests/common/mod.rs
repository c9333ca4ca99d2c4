//! Small scenes that tests share.

use glam::{Affine3A, Vec3};
use lightmesh::geometry::TriangleMesh;
use lightmesh::{
    Camera, Frame, Instance, Light, LightMesh, Material, Method, RenderOptions, Scene, SceneData, Spacing, render,
};

/// Two triangles `a b c d`, counter-clockwise from the front.
pub(crate) fn quad(corners: [Vec3; 4], material: usize) -> TriangleMesh {
    TriangleMesh {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..TriangleMesh::default()
    }
}

/// An axis-aligned box with outward faces.
pub(crate) fn cuboid(min: Vec3, max: Vec3, material: usize) -> TriangleMesh {
    let corner = |i: usize| {
        let pick = |bit: usize, lo: f32, hi: f32| if i & bit == 0 { lo } else { hi };
        Vec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z))
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    TriangleMesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        material,
        ..TriangleMesh::default()
    }
}

/// The same surface, facing the other way.
pub(crate) fn inside_out(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

pub(crate) fn place(data: &mut SceneData, mesh: TriangleMesh) {
    data.instances.push(Instance { mesh: data.meshes.len(), world_from_object: Affine3A::IDENTITY });
    data.meshes.push(mesh);
}

pub(crate) fn point_light(position: Vec3, intensity_cd: Vec3) -> Light {
    Light::Point { position, intensity_cd, range: None }
}

/// A 20 × 20 m Lambertian floor at y = 0.
pub(crate) fn floor(albedo: Vec3) -> SceneData {
    let mut data = SceneData { materials: vec![Material::lambert(albedo)], ..SceneData::default() };
    let c = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    place(&mut data, quad([c(-10.0, 10.0), c(10.0, 10.0), c(10.0, -10.0), c(-10.0, -10.0)], 0));
    data
}

/// A closed room of 4 × 3 × 4 m with a box in it and three coloured lights.
pub(crate) fn room() -> SceneData {
    let mut data = SceneData {
        materials: vec![Material::lambert(Vec3::splat(0.7)), Material::lambert(Vec3::new(0.6, 0.3, 0.2))],
        lights: vec![
            point_light(Vec3::new(-1.0, 2.5, 1.0), Vec3::new(20.0, 12.0, 8.0)),
            point_light(Vec3::new(1.4, 2.0, 1.2), Vec3::new(4.0, 8.0, 20.0)),
            point_light(Vec3::new(0.2, 2.8, -1.3), Vec3::new(10.0, 10.0, 10.0)),
        ],
        ..SceneData::default()
    };
    place(&mut data, inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0)));
    place(&mut data, cuboid(Vec3::new(-0.5, 0.0, -0.6), Vec3::new(0.6, 1.0, 0.5), 1));
    data
}

/// The room with a lamp of its own in view, and a box that mirrors: outlines, and waves that follow waves.
pub(crate) fn room_with_mirror() -> SceneData {
    let mut data = room();
    data.materials[1] = Material { metallic: 1.0, roughness: 0.0, ..Material::lambert(Vec3::splat(0.8)) };
    data.materials.push(Material { emission: Vec3::splat(300.0), ..Material::lambert(Vec3::ZERO) });
    place(&mut data, cuboid(Vec3::new(-1.4, 1.2, -1.4), Vec3::new(-0.9, 1.6, -1.1), 2));
    data
}

pub(crate) fn room_camera() -> Camera {
    Camera::look_at(Vec3::new(0.3, 1.7, 1.95), Vec3::new(0.0, 0.9, -0.5), 1.2)
}

/// A picture of 64 × 48 pixels, one sample each, direct light only.
pub(crate) fn options(method: Method) -> RenderOptions {
    let spacing = Spacing::Metres(0.2);
    RenderOptions::default().with(|o| {
        o.method = method;
        o.picture.width = 64;
        o.picture.height = 48;
        o.picture.spp = 1;
        o.transport.bounces = 0;
        o.mesh.spacing = spacing;
    })
}

pub(crate) fn shoot(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Frame {
    let mut mesh = LightMesh::new(scene, options).expect("mesh");
    render(scene, camera, options, &mut mesh, &()).expect("frame")
}
