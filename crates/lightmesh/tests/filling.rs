//! Meshes that several processes fill together.

mod common;

use common::*;

use lightmesh::filling::{self, BrickPoints, Wanted};
use lightmesh::portions::{self, PictureSamples};
use lightmesh::{Error, Interpolation, LightMesh, Method, RenderOptions, Scene, render};

/// Every point that a picture reads is wanted before: filled by then, none is left for the picture.
#[test]
fn demand_is_what_a_picture_reads() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    let camera = room_camera();
    for method in [Method::Mesh, Method::Paper, Method::Hybrid, Method::Unbiased] {
        for refine in [None, Some(2)] {
            let interpolation = if refine.is_some() { Interpolation::Trilinear } else { Interpolation::Auto };
            let options = RenderOptions { width: 200, height: 150, spp: 3, refine, interpolation, ..options(method) };
            let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
            let prepared = portions::prepare(&scene, &camera, &options, &mut mesh, &()).expect("prepared");
            for _ in 0..mesh.level_count() {
                let mut wanted = Wanted::default();
                for i in 0..portions::wave_count(&options).expect("count") {
                    let part = (&prepared, PictureSamples::All, i..i + 1);
                    let more = filling::demand(&scene, &camera, &options, &mut mesh, part, &()).expect("wanted");
                    wanted.join(&more);
                }
                let before = mesh.stats().points_used;
                filling::fill_direct(&scene, &options, &mut mesh, &wanted.direct, &()).expect("filled");
                assert_eq!(mesh.stats().points_used - before, wanted.len(), "{method:?} {refine:?}");
            }
            let frame = render(&scene, &camera, &options, &mut mesh, &()).expect("frame");
            let (mine, all) = (frame.stats.fill_shadow_rays, frame.stats.rays.shadow);
            assert_eq!(mine, 0, "{method:?} {refine:?}: {mine} of {all} shadow rays");
            assert_eq!(frame.image, shoot(&scene, &camera, &options).image, "{method:?} {refine:?}");
        }
    }
}

#[test]
fn bricks_of_another_mesh_are_refused() {
    let scene = Scene::new(room()).expect("scene");
    let options = RenderOptions { bounces: 1, ..options(Method::Mesh) };
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    for (level, brick) in [(1, 0), (0, u32::MAX)] {
        let bricks = [BrickPoints { level, brick, places: [1; 8] }];
        let direct = filling::fill_direct(&scene, &options, &mut mesh, &bricks, &()).expect_err("no such brick");
        assert!(direct.to_string().contains("another mesh"), "{direct}");
        let indirect = filling::Gathering::new(&scene, &options, &mesh, &bricks, &());
        assert!(matches!(indirect, Err(Error::InvalidOption { option: "bricks", .. })));
    }
    assert_eq!(mesh.stats().points_used, 0);
}

#[test]
fn bricks_are_joined_place_by_place() {
    let brick = |level, brick, places: u64| BrickPoints { level, brick, places: [places, 0, 0, 0, 0, 0, 0, 1] };
    let mut some = Wanted { direct: vec![brick(0, 3, 1), brick(1, 0, 4)], indirect: Vec::new() };
    some.join(&Wanted { direct: vec![brick(0, 2, 7), brick(0, 3, 6)], indirect: vec![brick(0, 0, 1)] });
    assert_eq!(some.direct, [brick(0, 2, 7), brick(0, 3, 7), brick(1, 0, 4)]);
    assert_eq!(some.len(), 4 + 4 + 2 + 2);
    assert!(!some.is_empty() && Wanted::default().is_empty());
}
