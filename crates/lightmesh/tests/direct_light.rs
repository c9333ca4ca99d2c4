//! Direct light against closed forms, and the tracers against each other.

use std::f32::consts::PI;

use crate::common::*;
use glam::Vec3;
use lightmesh::metrics::difference;
use lightmesh::{Camera, Interpolation, Light, Method, PaperScale, Scene, Spacing};

/// L = albedo / π · I cosθ / r² on a floor under a point light, seen from above: without anything in the way every
/// method gives it, the mesh too (its visibility is exactly 1).
#[test]
fn a_point_light_over_a_floor_is_albedo_over_pi_times_intensity_cos_over_r_squared() {
    let mut data = floor(Vec3::new(0.8, 0.5, 0.2));
    data.lights.push(point_light(Vec3::new(0.5, 2.0, 0.25), Vec3::new(30.0, 20.0, 10.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.01), Vec3::ZERO, 0.8);
    for method in [Method::Standard, Method::MESH, Method::PAPER, Method::Path] {
        let options = options(method);
        let frame = shoot(&scene, &camera, &options);
        let film = [(10, 7), (32, 24), (63, 40)];
        for (x, y) in film {
            // The floor point of the pixel's centre, by the pinhole's own geometry.
            let tan = 0.4_f32.tan();
            let dx = (x as f32 + 0.5 - 32.0) / 24.0 * tan;
            let dz = (y as f32 + 0.5 - 24.0) / 24.0 * tan;
            let forward = (Vec3::ZERO - Vec3::new(0.0, 5.0, 0.01)).normalize();
            let right = Vec3::X;
            let down = forward.cross(right);
            let ray = forward + right * dx + down * dz;
            let p = Vec3::new(0.0, 5.0, 0.01) + ray * (-5.0 / ray.y);
            let to_light = Vec3::new(0.5, 2.0, 0.25) - p;
            let r = to_light.length();
            let expected = Vec3::new(0.8, 0.5, 0.2) / PI * Vec3::new(30.0, 20.0, 10.0) * (to_light.y / r) / (r * r);
            let got = frame.image.pixels[y * 64 + x];
            assert!(
                (got - expected).abs().max_element() < 1e-3 * expected.max_element(),
                "{method:?} {x},{y}: {got} {expected}"
            );
        }
    }
}

/// The paper's Const + r in place of r²: L = albedo / π · I cosθ / (Const + r).
#[test]
fn the_papers_falloff_replaces_r_squared() {
    let mut data = floor(Vec3::ONE);
    data.lights.push(point_light(Vec3::new(0.0, 2.0, 0.0), Vec3::splat(3.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO, 0.01);
    let falloff = lightmesh::Falloff::ConstantPlusDistance { constant: 0.5 };
    let frame = shoot(&scene, &camera, &options(Method::Standard).with(|o| o.transport.falloff = falloff));
    let expected = 3.0 / PI / (0.5 + 2.0);
    assert!((frame.image.pixels[24 * 64 + 32].x - expected).abs() < 1e-3 * expected);
}

/// Where nothing reflects but Lambert and no bounce is asked for, path tracing does what standard tracing does.
#[test]
fn path_without_bounces_is_standard() {
    let scene = Scene::new(room()).expect("scene");
    let standard = shoot(&scene, &room_camera(), &options(Method::Standard));
    let path = shoot(&scene, &room_camera(), &options(Method::Path));
    let d = difference(&path.image.pixels, &standard.image.pixels);
    assert!(d.max < 1e-4 * standard.image.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max) as f64, "{d:?}");
}

/// A ladder: the six-axis mesh comes closer to exact shadow rays as it is refined; the paper's scalar does not get
/// below its floor, because it cannot know which lights a surface faces.
#[test]
fn refining_the_mesh_brings_it_closer_to_standard() {
    let scene = Scene::new(room()).expect("scene");
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard));
    let error = |method, spacing| {
        let options = options(method).with(|o| o.mesh.spacing = Spacing::Metres(spacing));
        difference(&shoot(&scene, &room_camera(), &options).image.pixels, &truth.image.pixels).relrmse
    };
    let ladder = [0.4, 0.2, 0.1, 0.05].map(|h| error(Method::MESH, h));
    assert!(
        ladder[0] < 0.06 && ladder[1] < 0.7 * ladder[0] && ladder[2] < ladder[1] && ladder[3] < 0.8 * ladder[2],
        "{ladder:?}"
    );
    let papers = [0.1, 0.05].map(|h| error(Method::PAPER, h));
    assert!(papers[1] > 0.8 * papers[0] && papers[1] > 1.5 * ladder[3], "{papers:?} {ladder:?}");
}

/// Every neighbourhood gives a picture that is close to the exact one, and only read points are evaluated.
#[test]
fn neighbourhoods_agree_and_the_mesh_is_lazy() {
    let scene = Scene::new(room()).expect("scene");
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard));
    for interpolation in [Interpolation::Trilinear, Interpolation::Sphere { radius: 1.5 }, Interpolation::Nearest] {
        let options = options(Method::MESH).with(|o| {
            o.mesh.interpolation = interpolation;
            o.mesh.spacing = Spacing::Metres(0.1);
        });
        let frame = shoot(&scene, &room_camera(), &options);
        let d = difference(&frame.image.pixels, &truth.image.pixels);
        let stats = frame.stats.direct;
        assert!(d.relrmse < 0.25 && d.bias.abs() < 0.08, "{interpolation:?}: {d:?}");
        assert!(stats.points_used > 0 && 3 * stats.points_used < stats.points_total, "{interpolation:?}: {stats:?}");
    }
}

/// Formulas (1)-(3) as printed, times one constant, give the visibility form where nothing hides a light and all are
/// equally far: Ĩ is then the same sum everywhere.
#[test]
fn the_papers_literal_form_is_scaled_by_one_constant() {
    let mut data = floor(Vec3::ONE);
    data.lights.push(Light::Directional { direction: Vec3::NEG_Y, illuminance_lux: Vec3::splat(2.0) });
    let scene = Scene::new(data).expect("scene");
    let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO, 0.3);
    let options =
        options(Method::Paper { scale: PaperScale::Constant, field_falloff: lightmesh::Falloff::InverseSquare });
    let frame = shoot(&scene, &camera, &options);
    for p in &frame.image.pixels {
        assert!((p.x - 2.0 / PI).abs() < 1e-4, "{p}");
    }
}

/// Antialiasing shades more but fills no more: the mesh of 16 samples is the mesh of one, but for the points that only
/// the finer sampling sees.
#[test]
fn samples_do_not_multiply_the_fill() {
    let scene = Scene::new(room()).expect("scene");
    let used = |spp| {
        let options = options(Method::MESH).with(|o| o.picture.spp = spp);
        shoot(&scene, &room_camera(), &options).stats.direct.points_used
    };
    assert!(used(16) < used(1) + used(1) / 5, "{} {}", used(16), used(1));
}
