//! Meshes whose density falls with the distance from the eye.

use crate::common::*;
use glam::Vec3;
use lightmesh::{Aov, Camera, Error, Frame, Interpolation, LightMesh, Method, RenderOptions, Scene, Spacing, render};

fn with(method: Method, graded: Option<f32>) -> RenderOptions {
    let aovs = [Aov::Depth, Aov::MeshLevel].into_iter().collect();
    options(method).with(|o| {
        o.mesh.lod_distance = graded;
        o.picture.aovs = aovs;
        o.mesh.interpolation = Interpolation::Trilinear;
    })
}

fn values(frame: &Frame, aov: Aov) -> &[f32] {
    &frame.layers.iter().find(|layer| layer.aov == aov).expect("a layer").values
}

/// Root mean square difference of the pixels that are chosen.
fn error(frame: &Frame, truth: &Frame, choose: impl Fn(usize) -> bool) -> f64 {
    let chosen: Vec<usize> = (0..truth.image.pixels.len()).filter(|&i| choose(i)).collect();
    assert!(chosen.len() > 50, "{}", chosen.len());
    let square = |&i: &usize| f64::from((frame.image.pixels[i] - truth.image.pixels[i]).length_squared());
    (chosen.iter().map(square).sum::<f64>() / chosen.len() as f64).sqrt()
}

/// Every step brings what is near nearer to exact shadow rays, with fewer points than half the spacing everywhere
/// takes; what is far away keeps its light to the last bit, and levels go up towards the eye.
#[test]
fn what_is_near_is_nearer_to_the_truth() {
    let scene = Scene::new(room()).expect("scene");
    let sized = |graded| {
        with(Method::MESH, graded).with(|o| {
            o.picture.width = 128;
            o.picture.height = 96;
        })
    };
    let shot = |options: &RenderOptions| shoot(&scene, &room_camera(), options);
    let (plain, near, all) = (shot(&sized(None)), shot(&sized(Some(3.5))), shot(&sized(Some(1e6))));
    let truth = shot(&sized_standard().with(|o| o.picture.aovs = [Aov::Depth].into_iter().collect()));
    let depth = values(&near, Aov::Depth);
    // Depth is along the axis, distances are larger: up to 1.5 times in the corners.
    let is_near = |i: usize| depth[i] < 2.1;
    let [before, after] = [&plain, &near].map(|frame| error(frame, &truth, is_near));
    assert!(after < 0.8 * before, "{after} {before}");
    for (i, &level) in values(&near, Aov::MeshLevel).iter().enumerate() {
        if depth[i] > 3.9 {
            assert_eq!((near.image.pixels[i], level), (plain.image.pixels[i], 0.0), "{i}");
        }
        assert!(!is_near(i) || level >= 1.0, "{i}: {level} at {} m", depth[i]);
    }
    let half = shot(&sized(None).with(|o| o.mesh.spacing = Spacing::Metres(0.1)));
    let [plain, near, half, all] = [plain, near, half, all].map(|frame| frame.stats.direct);
    assert!(plain.points_refined == 0 && near.points_refined > 0, "{near:?}");
    assert!(near.points_used < half.points_used, "{near:?} {half:?}");
    assert!(all.points_used == all.points_refined && all.points_used > 4 * half.points_used, "{all:?} {half:?}");
}

fn sized_standard() -> RenderOptions {
    options(Method::Standard).with(|o| {
        o.picture.width = 128;
        o.picture.height = 96;
    })
}

/// Every method with a mesh has finer points near the eye, for indirect light too, and its second frame is its first,
/// whatever other camera, and whatever other distance, came between.
#[test]
fn what_came_before_does_not_matter() {
    let scene = Scene::new(room()).expect("scene");
    let elsewhere = Camera::look_at(Vec3::new(-1.5, 2.5, -1.5), Vec3::new(0.0, 0.5, 0.5), 1.0);
    for method in [Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED] {
        let with = |graded| {
            with(method, Some(graded)).with(|o| {
                o.transport.bounces = 1;
                o.mesh.gather_rays = Some(32);
            })
        };
        let first = shoot(&scene, &room_camera(), &with(2.5));
        assert!(first.stats.direct.points_refined > 0, "{method:?}");
        assert_eq!(first.stats.indirect.points_refined > 0, method != Method::UNBIASED, "{method:?}");
        let mut mesh = LightMesh::new(&scene, &with(2.5)).expect("mesh");
        render(&scene, &elsewhere, &with(2.5), &mut mesh, &()).expect("frame");
        render(&scene, &room_camera(), &with(4.0), &mut mesh, &()).expect("frame");
        let second = render(&scene, &room_camera(), &with(2.5), &mut mesh, &()).expect("frame");
        assert_eq!(first.image, second.image, "{method:?}");
        assert!(!mesh.is_compatible(&with(2.5).with(|o| o.mesh.lod_distance = None)));
    }
}

/// What is refined because it is wrong comes after what is near.
#[test]
fn it_goes_with_refinement() {
    let scene = Scene::new(room()).expect("scene");
    let options = with(Method::MESH, Some(2.0)).with(|o| o.mesh.refine = Some(1));
    let both = shoot(&scene, &room_camera(), &options);
    let near = shoot(&scene, &room_camera(), &options.clone().with(|o| o.mesh.refine = None));
    let truth = shoot(&scene, &room_camera(), &crate::common::options(Method::Standard));
    assert!(both.stats.direct.points_refined > near.stats.direct.points_refined);
    let [both, near] = [both, near].map(|frame| error(&frame, &truth, |_| true));
    assert!(both < near, "{both} {near}");
}

/// Where points would not fit into half of the memory, what is near stays coarser.
#[test]
fn density_keeps_to_the_memory_limit() {
    let scene = Scene::new(room()).expect("scene");
    let shot = |max_memory| {
        let options = with(Method::MESH, Some(1e6)).with(|o| o.limits.max_memory = max_memory);
        shoot(&scene, &room_camera(), &options).stats.direct
    };
    let all = shot(4 << 30);
    let some = shot(8 * all.bytes);
    let none = shot(2 << 20);
    assert!(0 < some.points_refined && some.points_refined < all.points_refined / 2, "{some:?} {all:?}");
    assert!(none.points_refined == 0 && none.points_used > 0, "{none:?}");
}

#[test]
fn it_is_for_trilinear_meshes() {
    let refused = |options: RenderOptions, word: &str| match options.validate() {
        Err(Error::InvalidOption { option, .. }) => assert_eq!(option, word),
        other => panic!("{other:?}"),
    };
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        refused(with(Method::MESH, Some(bad)), "lod-distance");
    }
    let plain = |method| options(method).with(|o| o.mesh.lod_distance = Some(2.0));
    refused(plain(Method::Standard), "lod-distance");
    refused(plain(Method::Path), "lod-distance");
    // Its own neighbourhood is a sphere.
    refused(plain(Method::PAPER), "interpolation");
    refused(plain(Method::MESH).with(|o| o.mesh.interpolation = Interpolation::Nearest), "interpolation");
    assert!(plain(Method::MESH).validate().is_ok() && plain(Method::UNBIASED).validate().is_ok());
}
