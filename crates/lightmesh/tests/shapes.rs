//! Surfaces that are not triangles: anything that can answer "ray hit?" and "normal?" renders in every tracer.

use crate::common::*;
use glam::{Vec2, Vec3};
use lightmesh::geometry::{Aabb, Ray, Shape, Sphere, TriangleMesh};
use lightmesh::metrics::difference;
use lightmesh::{Camera, Material, Method, Scene, SceneData, ShapeEntry, Spacing};

const MAJOR: f32 = 0.7;
const MINOR: f32 = 0.25;
const CENTER: Vec3 = Vec3::new(0.0, 0.6, 0.0);

/// A torus about the Y axis through [`CENTER`], met by sphere tracing its distance.
#[derive(Debug)]
struct Torus;

impl Torus {
    fn distance(p: Vec3) -> f32 {
        let q = p - CENTER;
        Vec2::new(Vec2::new(q.x, q.z).length() - MAJOR, q.y).length() - MINOR
    }
}

impl Shape for Torus {
    fn bounds(&self) -> Aabb {
        let half = Vec3::new(MAJOR + MINOR, MINOR, MAJOR + MINOR);
        Aabb { min: CENTER - half, max: CENTER + half }
    }

    fn intersect(&self, ray: &Ray) -> Option<f32> {
        let length = ray.direction.length();
        let inside = Self::distance(ray.at(ray.t_min + 1e-4 / length)) < 0.0;
        let mut t = ray.t_min + 1e-4 / length;
        for _ in 0..512 {
            let d = Self::distance(ray.at(t)).abs();
            if d < 2e-5 {
                return (t < ray.t_max).then_some(t);
            }
            t += d / length;
            if t > ray.t_max || (!inside && d > 10.0) {
                return None;
            }
        }
        None
    }

    fn normal(&self, point: Vec3) -> Vec3 {
        let q = point - CENTER;
        let ring = Vec3::new(q.x, 0.0, q.z).normalize_or(Vec3::X) * MAJOR;
        (q - ring).normalize()
    }
}

/// The same torus in triangles with smooth normals.
fn triangulated() -> TriangleMesh {
    let (n, m) = (256, 96);
    let mut mesh = TriangleMesh { material: 1, ..TriangleMesh::default() };
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (std::f32::consts::TAU * i as f32 / n as f32, std::f32::consts::TAU * j as f32 / m as f32);
            let out = Vec3::new(a.cos(), 0.0, a.sin());
            let normal = out * b.cos() + Vec3::Y * b.sin();
            mesh.positions.push(CENTER + out * MAJOR + normal * MINOR);
            mesh.normals.push(normal);
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
}

fn stage() -> SceneData {
    let mut data = floor(Vec3::splat(0.6));
    data.materials.push(Material::lambert(Vec3::new(0.7, 0.4, 0.2)));
    data.lights = vec![
        point_light(Vec3::new(1.5, 2.5, 1.0), Vec3::splat(20.0)),
        point_light(Vec3::new(-1.0, 2.0, 1.5), Vec3::new(5.0, 10.0, 15.0)),
    ];
    data
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.4, 2.2, 3.0), Vec3::new(0.0, 0.4, 0.0), 0.9)
}

#[test]
fn a_users_torus_looks_like_its_triangles_in_every_tracer() {
    let mut shaped = stage();
    shaped.shapes.push(ShapeEntry { shape: std::sync::Arc::new(Torus), material: 1 });
    let mut meshed = stage();
    place(&mut meshed, triangulated());
    let (shaped, meshed) = (Scene::new(shaped).expect("scene"), Scene::new(meshed).expect("scene"));
    for method in [Method::Standard, Method::MESH, Method::Path] {
        let options = options(method).with(|o| o.mesh.spacing = Spacing::Metres(0.2));
        let (a, b) = (shoot(&shaped, &camera(), &options), shoot(&meshed, &camera(), &options));
        let d = difference(&a.image.pixels, &b.image.pixels);
        // A pixel at a shadow's edge or the silhouette may go either way.
        assert!(d.relrmse < 0.06 && d.bias.abs() < 0.005, "{method:?}: {d:?}");
    }
}

#[test]
fn an_analytic_sphere_casts_the_shadow_of_its_cone() {
    // A sphere of radius 0.5 at y = 1 under a light at y = 3: the shadow's radius on the floor is 3 tan(asin(0.5 / 2)).
    let mut data = floor(Vec3::ONE);
    data.lights.push(point_light(Vec3::new(0.0, 3.0, 0.0), Vec3::splat(10.0)));
    data.spheres.push(Sphere { center: Vec3::Y, radius: 0.5, material: 0 });
    let scene = Scene::new(data).expect("scene");
    let radius = 3.0 * (0.25_f32).asin().tan();
    for (x, lit) in [(radius * 0.98, false), (radius * 1.02, true)] {
        let eye = Vec3::new(x, 0.4, 0.0);
        let frame = shoot(&scene, &Camera::look_at(eye, Vec3::new(x, 0.0, 0.0), 0.01), &options(Method::Standard));
        assert_eq!(frame.image.pixels[24 * 64 + 32].x > 0.0, lit, "{x}");
    }
}

/// Points of the mesh inside an analytic sphere see its back and are invalid; readers leave them out.
#[test]
fn mesh_points_inside_a_solid_are_invalid() {
    let mut data = stage();
    data.spheres.push(Sphere { center: Vec3::new(0.0, 0.8, 0.0), radius: 0.8, material: 1 });
    let scene = Scene::new(data).expect("scene");
    let options = options(Method::MESH).with(|o| o.mesh.spacing = Spacing::Metres(0.15));
    let stats = shoot(&scene, &camera(), &options).stats.direct;
    assert!(stats.points_invalid > 0 && stats.points_invalid * 4 < stats.points_used, "{stats:?}");
}

/// A surface without extent has a box of size zero; the mesh's spacing is still a length.
#[derive(Debug)]
struct Nowhere;

impl Shape for Nowhere {
    fn bounds(&self) -> Aabb {
        Aabb { min: Vec3::ONE, max: Vec3::ONE }
    }

    fn intersect(&self, _: &Ray) -> Option<f32> {
        None
    }

    fn normal(&self, _: Vec3) -> Vec3 {
        Vec3::Y
    }
}

#[test]
fn a_scene_of_a_single_point_renders_black() {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::ONE)], ..SceneData::default() };
    data.shapes.push(ShapeEntry { shape: std::sync::Arc::new(Nowhere), material: 0 });
    let scene = Scene::new(data).expect("scene");
    let options = options(Method::MESH).with(|o| o.mesh.spacing = Spacing::Auto);
    assert!(shoot(&scene, &camera(), &options).image.pixels.iter().all(|&p| p == Vec3::ZERO));
}
