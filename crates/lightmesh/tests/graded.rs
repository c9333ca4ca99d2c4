//! Meshes whose density falls with the distance from the eye.

use crate::common::*;
use glam::Vec3;
use lightmesh::{Aov, Camera, Error, Frame, Interpolation, LightMesh, Method, RenderOptions, Scene, Spacing, render};

fn with(method: Method, graded: Option<f32>) -> RenderOptions {
    let aovs = [Aov::Depth, Aov::MeshLevel].into_iter().collect();
    RenderOptions { graded, aovs, interpolation: Interpolation::Trilinear, ..options(method) }
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

/// Every step brings what is near nearer to exact shadow rays, with fewer points than half the spacing everywhere takes; what is far away
/// keeps its light to the last bit, and levels go up towards the eye.
#[test]
fn what_is_near_is_nearer_to_the_truth() {
    let scene = Scene::new(room()).expect("scene");
    let sized = |graded| RenderOptions { width: 128, height: 96, ..with(Method::Mesh, graded) };
    let shot = |options: &RenderOptions| shoot(&scene, &room_camera(), options);
    let (plain, near, all) = (shot(&sized(None)), shot(&sized(Some(3.5))), shot(&sized(Some(1e6))));
    let truth = shot(&RenderOptions { aovs: [Aov::Depth].into_iter().collect(), ..sized_standard() });
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
    let half = shot(&RenderOptions { spacing: Spacing::Metres(0.1), ..sized(None) });
    let [plain, near, half, all] = [plain, near, half, all].map(|frame| frame.stats.direct);
    assert!(plain.points_refined == 0 && near.points_refined > 0, "{near:?}");
    assert!(near.points_used < half.points_used, "{near:?} {half:?}");
    assert!(all.points_used == all.points_refined && all.points_used > 4 * half.points_used, "{all:?} {half:?}");
}

fn sized_standard() -> RenderOptions {
    RenderOptions { width: 128, height: 96, ..options(Method::Standard) }
}

/// Every method with a mesh has finer points near the eye, for indirect light too, and its second frame is its first, whatever other
/// camera, and whatever other distance, came between.
#[test]
fn what_came_before_does_not_matter() {
    let scene = Scene::new(room()).expect("scene");
    let elsewhere = Camera::look_at(Vec3::new(-1.5, 2.5, -1.5), Vec3::new(0.0, 0.5, 0.5), 1.0);
    for method in [Method::Mesh, Method::Paper, Method::Hybrid, Method::Unbiased] {
        let with = |graded| RenderOptions { bounces: 1, gather_rays: 32, ..with(method, Some(graded)) };
        let first = shoot(&scene, &room_camera(), &with(2.5));
        assert!(first.stats.direct.points_refined > 0, "{method:?}");
        assert_eq!(first.stats.indirect.points_refined > 0, method != Method::Unbiased, "{method:?}");
        let mut mesh = LightMesh::new(&scene, &with(2.5)).expect("mesh");
        render(&scene, &elsewhere, &with(2.5), &mut mesh, &()).expect("frame");
        render(&scene, &room_camera(), &with(4.0), &mut mesh, &()).expect("frame");
        let second = render(&scene, &room_camera(), &with(2.5), &mut mesh, &()).expect("frame");
        assert_eq!(first.image, second.image, "{method:?}");
        assert!(!mesh.is_compatible(&RenderOptions { graded: None, ..with(2.5) }));
    }
}

/// What is refined because it is wrong comes after what is near.
#[test]
fn it_goes_with_refinement() {
    let scene = Scene::new(room()).expect("scene");
    let options = RenderOptions { refine: Some(1), ..with(Method::Mesh, Some(2.0)) };
    let both = shoot(&scene, &room_camera(), &options);
    let near = shoot(&scene, &room_camera(), &RenderOptions { refine: None, ..options.clone() });
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
        let options = RenderOptions { max_memory, ..with(Method::Mesh, Some(1e6)) };
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
        refused(with(Method::Mesh, Some(bad)), "graded");
    }
    let plain = |method| RenderOptions { graded: Some(2.0), ..options(method) };
    refused(plain(Method::Standard), "graded");
    refused(plain(Method::Path), "graded");
    // Its own neighbourhood is a sphere.
    refused(plain(Method::Paper), "interpolation");
    refused(RenderOptions { interpolation: Interpolation::Nearest, ..plain(Method::Mesh) }, "interpolation");
    assert!(plain(Method::Mesh).validate().is_ok() && plain(Method::Unbiased).validate().is_ok());
}
