//! The light of a first picture: decided by light, not by presence.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use lightmesh::{
    Camera, FirstLight, ImageData, Light, LightMesh, Material, Method, RenderOptions, Scene, SceneData, Survey, Texels,
    Texture, TextureRef, Wrap, render,
};

use crate::common::{cuboid, floor, inside_out, place, point_light, quad, room, room_camera};

/// A box of 2 m on nothing, and a camera that sees it.
fn product() -> (SceneData, Camera) {
    let mut data = SceneData { materials: vec![Material::lambert(Vec3::splat(0.8))], ..SceneData::default() };
    place(&mut data, cuboid(Vec3::splat(-1.0), Vec3::ONE, 0));
    let camera = Camera::framing(&data.bounds());
    (data, camera)
}

fn wanted(data: &SceneData, camera: &Camera) -> FirstLight {
    let scene = Scene::new(data.clone()).expect("a scene");
    Survey::new(&scene, camera).expect("a survey").wanted
}

/// Nothing shines at all; black emission, black lamps, a lamp beyond its range, a spot that looks away.
#[test]
fn light_that_reaches_nothing_is_none() {
    let (data, camera) = product();
    assert_eq!(wanted(&data, &camera), FirstLight::Studio);
    let at = Vec3::new(0.0, 6.0, 3.0);
    let spot = |direction| Light::Spot {
        position: at,
        direction,
        intensity_cd: Vec3::splat(1000.0),
        range: None,
        inner_cone_angle: 0.2,
        outer_cone_angle: 0.4,
    };
    for (light, expected) in [
        (point_light(at, Vec3::ZERO), FirstLight::Studio),
        (Light::Point { position: at, intensity_cd: Vec3::splat(1000.0), range: Some(2.0) }, FirstLight::Studio),
        (spot(Vec3::Y), FirstLight::Studio),
        (spot(-at.normalize()), FirstLight::Own),
        (point_light(at, Vec3::splat(1000.0)), FirstLight::Own),
        (point_light(at, Vec3::splat(0.1)), FirstLight::Own),
        (Light::Directional { direction: Vec3::NEG_Y, illuminance_lux: Vec3::ZERO }, FirstLight::Studio),
        (Light::Directional { direction: Vec3::new(0.0, -0.6, -0.8), illuminance_lux: Vec3::ONE }, FirstLight::Own),
    ] {
        let data = SceneData { lights: vec![light], ..data.clone() };
        assert_eq!(wanted(&data, &camera), expected, "{light:?}");
    }
}

/// Emission: a black texture, a factor of zero, a small dim triangle on a box, and a panel over a floor.
#[test]
fn emission_counts_by_what_it_lights() {
    let (mut data, camera) = product();
    let c = |x: f32, y: f32| Vec3::new(x, y, 1.001);
    place(&mut data, quad([c(0.0, 0.0), c(0.02, 0.0), c(0.02, 0.02), c(0.0, 0.02)], 1));
    for emission in [0.0, 0.1, 1.0] {
        let emitter = Material { emission: Vec3::splat(emission), ..Material::default() };
        let data = SceneData { materials: vec![data.materials[0].clone(), emitter], ..data.clone() };
        assert_eq!(wanted(&data, &camera), FirstLight::Studio, "{emission}");
    }

    // All of the box glows, by a texture that is black or white.
    for (byte, expected) in [(0, true), (255, false)] {
        let (mut data, _) = product();
        let texels = Texels::Rgba8(Arc::new([[byte, byte, byte, 255]; 4]));
        data.images.push(ImageData { name: String::new(), width: 2, height: 2, texels });
        data.textures.push(Texture {
            image: 0,
            wrap_s: Wrap::Repeat,
            wrap_t: Wrap::Repeat,
            filter: Default::default(),
        });
        let texture = TextureRef { texture: 0, uv_set: 0, transform: Default::default() };
        data.materials[0].emission = Vec3::ONE;
        data.materials[0].emission_texture = Some(texture);
        data.meshes[0].uvs[0] = vec![Vec2::splat(0.5); 8];
        let survey = Survey::new(&Scene::new(data).expect("a scene"), &camera).expect("a survey");
        assert_eq!((survey.wanted == FirstLight::Studio, survey.has_own_light), (expected, !expected));
    }

    // A panel of 1 cd/m² lights the floor under it.
    let mut data = floor(Vec3::splat(0.5));
    data.materials.push(Material { emission: Vec3::ONE, ..Material::default() });
    let c = |x: f32, z: f32| Vec3::new(x, 3.0, z);
    place(&mut data, quad([c(-1.0, -1.0), c(1.0, -1.0), c(1.0, 1.0), c(-1.0, 1.0)], 1));
    let camera = Camera::look_at(Vec3::new(0.0, 2.0, 6.0), Vec3::ZERO, 0.8);
    assert_eq!(wanted(&data, &camera), FirstLight::Own);
}

/// A closed room without its lamps gets one at the camera, a room with a hole in its ceiling a sky; with its lamps
/// neither. Twice the same.
#[test]
fn closed_rooms_are_lit_from_the_camera() {
    let lit = room();
    assert_eq!(wanted(&lit, &room_camera()), FirstLight::Own);
    let dark = SceneData { lights: Vec::new(), ..lit };
    assert_eq!(wanted(&dark, &room_camera()), FirstLight::Headlight);

    let mut open = SceneData { materials: vec![Material::lambert(Vec3::splat(0.7))], ..SceneData::default() };
    let mut walls = inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0));
    place(&mut open, walls.clone());
    let camera = Camera::look_at(Vec3::new(1.5, 1.5, 1.5), Vec3::new(-1.0, 1.0, -1.0), 1.0);
    assert_eq!(wanted(&open, &camera), FirstLight::Headlight);
    // Without the ceiling.
    walls.triangles.retain(|t| t.iter().any(|&i| walls.positions[i as usize].y < 1.0));
    open.meshes[0] = walls;
    assert_eq!(wanted(&open, &camera), FirstLight::Studio);
}

/// A camera in a solid sees backs; one that looks away sees nothing, and is given the studio all the same.
#[test]
fn places_where_cameras_are_lost() {
    let (data, _) = product();
    let scene = Scene::new(data).expect("a scene");
    let inside = Survey::new(&scene, &Camera::look_at(Vec3::ZERO, Vec3::Z, 1.0)).expect("a survey");
    assert_eq!((inside.back_faces, inside.seen, inside.open), (1.0, 1.0, false));
    let away = Survey::new(&scene, &Camera::look_at(Vec3::Z * 5.0, Vec3::Z * 9.0, 1.0)).expect("a survey");
    assert_eq!((away.seen, away.wanted), (0.0, FirstLight::Studio));
}

/// The room's picture with the lamp at the camera, and the box's in the studio, whatever the size and place of the
/// scene: nearly everything that is seen is brighter than a hundredth of the mean.
#[test]
fn the_light_that_is_added_shows_the_scene() {
    let dark = SceneData { lights: Vec::new(), ..room() };
    let (data, camera) = product();
    let mut views = vec![(dark, room_camera())];
    for (size, offset) in [(1.0, 0.0), (0.0005, 0.0), (5000.0, 0.0), (1.0, 1000.0)] {
        let mut data = data.clone();
        let offset = Vec3::splat(offset);
        data.meshes[0].positions.iter_mut().for_each(|p| *p = *p * size + offset);
        let camera = if size == 1.0 && offset == Vec3::ZERO { camera.clone() } else { Camera::framing(&data.bounds()) };
        views.push((data, camera));
    }
    for (data, camera) in views {
        let scene = Scene::new(data).expect("a scene");
        let survey = Survey::new(&scene, &camera).expect("a survey");
        assert_ne!(survey.wanted, FirstLight::Own);
        let scene = scene.with_first_light(&survey, 1.0, 0.0).expect("light");
        let options = RenderOptions::default().with(|o| {
            o.method = Method::Path;
            (o.picture.width, o.picture.height, o.picture.spp) = (32, 24, 4);
        });
        let mut mesh = LightMesh::new(&scene, &options).expect("no mesh");
        let image = render(&scene, &camera, &options, &mut mesh, &()).expect("a picture").image;
        let mean = image.pixels.iter().map(|p| p.y).sum::<f32>() / image.pixels.len() as f32;
        let bright = image.pixels.iter().filter(|p| p.y > 0.01 * mean).count();
        assert!(bright * 10 > image.pixels.len() * 9, "{bright} {mean}");
    }
}

/// The floor under a box in the studio is darker near it than far away, and no floor is seen from below it.
#[test]
fn what_stands_in_the_studio_casts_a_shadow() {
    let (data, camera) = product();
    let scene = Scene::new(data).expect("a scene");
    let survey = Survey::new(&scene, &camera).expect("a survey");
    let scene = scene.with_first_light(&survey, 1.0, 0.0).expect("light");
    let pixel = |eye: Vec3, target: Vec3| {
        let options = RenderOptions::default().with(|o| {
            o.method = Method::Standard;
            (o.picture.width, o.picture.height, o.picture.spp) = (1, 1, 1);
        });
        let mut mesh = LightMesh::new(&scene, &options).expect("no mesh");
        render(&scene, &Camera::look_at(eye, target, 0.01), &options, &mut mesh, &()).expect("a picture").image.pixels
            [0]
    };
    let beside = pixel(Vec3::new(1.15, 5.0, 0.0), Vec3::new(1.15, -1.0, 0.0));
    let beyond = pixel(Vec3::new(30.0, 5.0, 0.0), Vec3::new(30.0, -1.0, 0.0));
    assert!(beside.y < 0.8 * beyond.y, "{beside} {beyond}");
    let below = pixel(Vec3::new(1.15, -2.0, 0.0), Vec3::new(1.15, -3.0, 0.0));
    assert_eq!(below, beyond);
}

/// Unlit surfaces are known to the display, for every method alike.
#[test]
fn displays_know_what_is_unlit() {
    let (mut data, camera) = product();
    data.materials.push(Material { base_color: Vec3::new(1.0, 0.5, 0.1), unlit: true, ..Material::default() });
    data.meshes[0].material = 1;
    let scene = Scene::new(data).expect("a scene");
    for method in [Method::MESH, Method::Standard, Method::Path] {
        let options = RenderOptions::default().with(|o| {
            o.method = method;
            (o.picture.width, o.picture.height, o.picture.spp) = (24, 16, 4);
        });
        let mut mesh = LightMesh::new(&scene, &options).expect("a mesh");
        let image = render(&scene, &camera, &options, &mut mesh, &()).expect("a picture").image;
        let middle = 8 * 24 + 12;
        let unlit = image.display.unlit[middle] - glam::Vec4::new(1.0, 0.5, 0.1, 1.0);
        assert!(unlit.abs().max_element() < 1e-6, "{method:?} {unlit}");
    }
}
