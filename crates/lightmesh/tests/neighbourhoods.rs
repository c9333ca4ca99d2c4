//! What a surface reads of the mesh around it: rules for missing corners, weights of points in a sphere.

use crate::common::*;
use glam::Vec3;
use lightmesh::metrics::difference;
use lightmesh::{
    Error, Image, Interpolation, LightMesh, Material, Method, MissingCorners, PointWeight, RenderOptions, Scene,
    SceneData, render,
};

const RULES: [MissingCorners; 4] =
    [MissingCorners::Zero, MissingCorners::Nearest, MissingCorners::Mirror, MissingCorners::One];

fn with_rule(method: Method, rule: MissingCorners) -> RenderOptions {
    options(method).with(|o| o.mesh.interpolation = Interpolation::TrilinearWith(rule))
}

fn mean(image: &Image) -> f32 {
    image.pixels.iter().map(|p| p.element_sum()).sum::<f32>() / image.pixels.len() as f32
}

fn refused(options: &RenderOptions, word: &str) {
    match options.validate() {
        Err(Error::InvalidOption { option, .. }) => assert_eq!(option, word, "{options:?}"),
        other => panic!("{other:?} of {options:?}"),
    }
}

/// A lit floor without anything on it: all corners before it see every light, so that Ĩ = 1 by three of the rules and
/// s, the height of the surface above the lower lattice plane, by the fourth. The floor's box is flat: the plane half a
/// cell above its lower wall is h/2 above the floor, and s = 1/2.
#[test]
fn a_bare_floor_has_the_share_of_the_corners_that_are_there() {
    let mut data = floor(Vec3::ONE);
    data.lights.push(point_light(Vec3::new(0.5, 2.0, 0.25), Vec3::splat(30.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = lightmesh::Camera::look_at(Vec3::new(0.0, 5.0, 0.01), Vec3::ZERO, 0.8);
    let truth = shoot(&scene, &camera, &options(Method::Standard)).image;
    for method in [Method::MESH, Method::PAPER] {
        for rule in RULES {
            let image = shoot(&scene, &camera, &with_rule(method, rule)).image;
            let expected = if rule == MissingCorners::Zero { 0.5 } else { 1.0 };
            for (p, t) in image.pixels.iter().zip(&truth.pixels) {
                assert!((p.x / t.x - expected).abs() < 2e-3, "{method:?}, {rule:?}: {p} of {t}");
            }
        }
    }
}

/// Zero is darker everywhere than one, by what is missing; the other two lie between, as plain trilinear does, and near
/// the truth.
#[test]
fn zero_is_dark_and_one_is_bright() {
    let scene = Scene::new(room()).expect("scene");
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard)).image;
    for method in [Method::MESH, Method::PAPER] {
        let plain = options(method).with(|o| o.mesh.interpolation = Interpolation::Trilinear);
        let plain = mean(&shoot(&scene, &room_camera(), &plain).image);
        let [zero, nearest, mirror, one] =
            RULES.map(|rule| shoot(&scene, &room_camera(), &with_rule(method, rule)).image);
        assert!(zero.pixels.iter().zip(&one.pixels).all(|(z, o)| z.cmple(*o + 1e-6 * o.max_element()).all()));
        assert!(mean(&zero) < 0.75 * plain && mean(&one) > 1.01 * plain, "{} {plain} {}", mean(&zero), mean(&one));
        for image in [&nearest, &mirror] {
            let d = difference(&image.pixels, &truth.pixels);
            assert!(d.relrmse < 0.25 && d.bias.abs() < 0.08, "{method:?}: {d:?}");
        }
        assert_ne!(nearest, mirror);
    }
}

/// A slit of 0.1 m between two blocks, and a mesh of 0.2 m: on its floor all corners are inside the blocks. Two rules
/// say what that means, with the other two it is traced.
#[test]
fn where_no_corner_is_there_the_rule_says_what_that_means() {
    let mut data = floor(Vec3::splat(0.5));
    place(&mut data, cuboid(Vec3::new(-3.0, -1.0, -3.0), Vec3::new(-0.05, 1.0, 3.0), 0));
    place(&mut data, cuboid(Vec3::new(0.05, -1.0, -3.0), Vec3::new(3.0, 1.0, 3.0), 0));
    data.lights.push(point_light(Vec3::new(0.0, 4.0, 0.0), Vec3::splat(100.0)));
    let scene = Scene::new(data).expect("scene");
    let camera = lightmesh::Camera::look_at(Vec3::new(0.0, 4.0, 0.01), Vec3::ZERO, 0.3);
    let truth = shoot(&scene, &camera, &options(Method::Standard)).image;
    for rule in RULES {
        let frame = shoot(&scene, &camera, &with_rule(Method::MESH, rule));
        let traced = matches!(rule, MissingCorners::Nearest | MissingCorners::Mirror);
        assert_eq!(frame.stats.exact_fallbacks > 0, traced, "{rule:?}");
        // The floor of the slit is in sight of the light.
        let middle = 24 * 64 + 32;
        let expected = if rule == MissingCorners::Zero { 0.0 } else { truth.pixels[middle].x };
        assert!(truth.pixels[middle].x > 0.5 && (frame.image.pixels[middle].x - expected).abs() < 1e-4, "{rule:?}");
    }
}

/// With bounces: the indirect field goes on as before, and a second frame of the same mesh is the first.
#[test]
fn rules_go_with_bounces_and_a_second_frame_only_reads() {
    let scene = Scene::new(room()).expect("scene");
    let options = with_rule(Method::MESH, MissingCorners::Mirror).with(|o| {
        o.transport.bounces = 2;
        o.mesh.gather_rays = Some(64);
    });
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    let first = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
    let second = render(&scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
    assert_eq!(first.image, second.image);
    assert_eq!(second.stats.rays.shadow, 0);
    let plain = options.clone().with(|o| o.mesh.interpolation = Interpolation::Trilinear);
    assert!(!mesh.is_compatible(&plain) && mesh.is_compatible(&options));
    assert!(!mesh.is_compatible(&with_rule(Method::MESH, MissingCorners::Nearest)));
}

#[test]
fn rules_are_for_direct_light_by_the_mean_visibility() {
    for rule in RULES {
        assert!(with_rule(Method::MESH, rule).validate().is_ok() && with_rule(Method::PAPER, rule).validate().is_ok());
        refused(&with_rule(Method::Hybrid, rule), "interpolation");
        refused(&with_rule(Method::UNBIASED, rule), "interpolation");
        refused(&with_rule(Method::MESH, rule).with(|o| o.method = Method::with_error(0.05)), "interpolation");
        refused(&with_rule(Method::MESH, rule).with(|o| o.mesh.refine = Some(1)), "interpolation");
    }
}

const WEIGHTS: [PointWeight; 4] =
    [PointWeight::Constant, PointWeight::Gaussian, PointWeight::Inverse, PointWeight::Cosine];

/// Other weights are other pictures, as near to the truth; a mesh keeps its weight.
#[test]
fn weights_change_the_picture_a_little() {
    let scene = Scene::new(room()).expect("scene");
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard)).image;
    let interpolation = Interpolation::Sphere { radius: 2.0 };
    for method in [Method::MESH, Method::PAPER] {
        let with = |weight| {
            options(method).with(|o| {
                o.mesh.interpolation = interpolation;
                o.mesh.weight = weight;
            })
        };
        let images = WEIGHTS.map(|weight| shoot(&scene, &room_camera(), &with(weight)).image);
        for (i, image) in images.iter().enumerate() {
            let d = difference(&image.pixels, &truth.pixels);
            assert!(d.relrmse < 0.3 && d.bias.abs() < 0.1, "{method:?}, {:?}: {d:?}", WEIGHTS[i]);
            assert!(images[..i].iter().all(|other| other != image), "{:?}", WEIGHTS[i]);
        }
        let mesh = LightMesh::new(&scene, &with(PointWeight::Cosine)).expect("mesh");
        assert!(mesh.is_compatible(&with(PointWeight::Cosine)) && !mesh.is_compatible(&with(PointWeight::Gaussian)));
    }
}

/// Points that are near count for more, so shadows are sharper: nearer to the truth than with equal weights.
#[test]
fn a_gaussian_is_sharper_than_equal_weights() {
    let scene = Scene::new(room()).expect("scene");
    let truth = shoot(&scene, &room_camera(), &options(Method::Standard)).image;
    let interpolation = Interpolation::Sphere { radius: 3.0 };
    let error = |weight| {
        let options = options(Method::MESH).with(|o| {
            o.mesh.interpolation = interpolation;
            o.mesh.weight = weight;
        });
        difference(&shoot(&scene, &room_camera(), &options).image.pixels, &truth.pixels).relrmse
    };
    let [constant, gaussian] = [PointWeight::Constant, PointWeight::Gaussian].map(error);
    assert!(gaussian < 0.95 * constant, "{gaussian} {constant}");
}

/// In a furnace of emission 1 and albedo 1/2, emission, what it lights and two reflections of that make 1 + 1/2 + 1/4 +
/// 1/8 everywhere, whatever the weights: they are normalised.
#[test]
fn weights_are_normalised_for_indirect_light_too() {
    let glow = Material { emission: Vec3::ONE, ..Material::lambert(Vec3::splat(0.5)) };
    let mut data = SceneData { materials: vec![glow], ..SceneData::default() };
    place(&mut data, inside_out(cuboid(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0), 0)));
    let scene = Scene::new(data).expect("scene");
    for weight in WEIGHTS {
        let interpolation = Interpolation::Sphere { radius: 1.5 };
        let options = options(Method::MESH).with(|o| {
            o.mesh.interpolation = interpolation;
            o.mesh.weight = weight;
            o.transport.bounces = 2;
            o.mesh.gather_rays = Some(64);
        });
        for p in shoot(&scene, &room_camera(), &options).image.pixels {
            assert!((p / 1.875 - Vec3::ONE).abs().max_element() < 0.02, "{weight:?}: {p}");
        }
    }
}

#[test]
fn weights_are_for_spheres() {
    let gaussian = |method| options(method).with(|o| o.mesh.weight = PointWeight::Gaussian);
    refused(&gaussian(Method::MESH), "weight");
    refused(&gaussian(Method::Hybrid), "weight");
    let rule = Interpolation::TrilinearWith(MissingCorners::Zero);
    for interpolation in [Interpolation::Trilinear, Interpolation::Nearest, rule] {
        refused(&gaussian(Method::PAPER).with(|o| o.mesh.interpolation = interpolation), "weight");
    }
    // The paper's own neighbourhood is a sphere.
    assert!(gaussian(Method::PAPER).validate().is_ok());
}
