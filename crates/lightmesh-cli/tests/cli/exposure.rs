//! Automatic exposure of rendered pictures.

use std::path::Path;

use glam::{DMat3, Vec3};
use lightmesh::{Camera, Light, LightMesh, Method, RenderOptions, Scene, render};
use lightmesh_io::output::{auto_exposure, exposure_of};

/// A camera in a room that only the lamps of one half light turns once round, 10° at a time: the exposure changes by less
/// than 0.15 EV from view to view, that of the pictures alone by more.
#[test]
fn a_turning_camera_has_a_steady_exposure() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room_15.glb");
    let mut data = lightmesh_io::load(&path, &Default::default()).expect("a scene of the repository").data;
    let middle = data.bounds().center();
    data.lights.retain(|light| matches!(light, Light::Point { position, .. } if position.x < middle.x));
    let scene = Scene::new(data).expect("a scene");
    let options = RenderOptions::default().with(|o| {
        o.method = Method::Path;
        (o.picture.width, o.picture.height, o.picture.spp) = (30, 20, 4);
    });
    let mut mesh = LightMesh::new(&scene, &options).expect("no mesh");
    let eye = middle.with_y(1.6);
    let (steady, of_pictures): (Vec<f32>, Vec<f32>) = (0..36)
        .map(|i| {
            let mut camera = Camera::look_at(eye, eye + Vec3::NEG_Z, 0.8);
            camera.world_from_camera.matrix3 = DMat3::from_rotation_y(f64::from(10 * i).to_radians());
            let image = render(&scene, &camera, &options, &mut mesh, &()).expect("a picture").image;
            (exposure_of(&image), auto_exposure(&image.pixels))
        })
        .unzip();
    let step = |ev: &[f32]| (0..ev.len()).map(|i| (ev[i] - ev[(i + 1) % ev.len()]).abs()).fold(0.0, f32::max);
    assert!(step(&steady) < 0.15, "{steady:?}");
    assert!(step(&of_pictures) > 0.3, "{of_pictures:?}");
    let range = |ev: &[f32]| ev.iter().fold(f32::MIN, |a, b| a.max(*b)) - ev.iter().fold(f32::MAX, |a, b| a.min(*b));
    assert!(range(&steady) > 0.1, "the meter looks where the camera does: {steady:?}");
}
