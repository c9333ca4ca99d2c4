//! Meshes that several processes fill together.

use crate::common::*;

use glam::Vec3;
use lightmesh::distributed::{self, BounceValues, BrickMask, GatherBatch, PictureSamples, PointRequests, WaveRequest};
use lightmesh::{Error, Interpolation, LightMesh, Method, RenderOptions, Scene, Snapshot, render};

/// Every point that a picture reads is requested before, by the samples of every pixel and by those on emitter edges:
/// when those are filled, none is left for the picture, and it is the one that fills its mesh as it goes.
#[test]
fn requested_points_are_those_that_a_picture_reads() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    let camera = room_camera();
    for method in [Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED] {
        for (refine, spp) in [(None, 3), (Some(2), 1), (Some(2), 3)] {
            let interpolation = if refine.is_some() { Interpolation::Trilinear } else { Interpolation::Auto };
            let options = options(method).with(|o| {
                o.picture.width = 200;
                o.picture.height = 150;
                o.picture.spp = spp;
                o.mesh.refine = refine;
                o.mesh.interpolation = interpolation;
            });
            let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
            let prepared = distributed::prepare(&scene, &camera, &options, &mut mesh, &()).expect("prepared");
            let fill_for = |mesh: &mut LightMesh, samples: PictureSamples<'_>, waves: u64| {
                for _ in 0..mesh.level_count() {
                    let mut wanted = PointRequests::default();
                    for i in 0..waves {
                        let request = WaveRequest { prepared: &prepared, samples, waves: i..i + 1 };
                        let more = distributed::requested_points(&scene, &camera, &options, mesh, request, &());
                        wanted.merge(&more.expect("wanted"));
                    }
                    let before = mesh.stats().points_used;
                    distributed::fill_direct(&scene, &options, mesh, &wanted.direct, &()).expect("filled");
                    assert_eq!(mesh.stats().points_used - before, wanted.len(), "{method:?} {refine:?} {spp}");
                }
            };
            let waves = distributed::wave_count(&options).expect("count");
            fill_for(&mut mesh, PictureSamples::All, waves);
            let draw = |i| {
                let request = WaveRequest { prepared: &prepared, samples: PictureSamples::All, waves: i..i + 1 };
                let part = distributed::render_waves(&scene, &camera, &options, &mut mesh, request, &()).expect("part");
                assert_eq!(part.stats.fill_shadow_rays, 0, "{method:?} {refine:?} {spp}");
                part
            };
            let parts: Vec<_> = (0..waves).map(draw).collect();
            let edges = distributed::find_emitter_edges(&scene, &camera, &options, &parts).expect("edges");
            if let Some(edges) = &edges {
                fill_for(&mut mesh, PictureSamples::EmitterEdges(edges), edges.waves);
            }
            let frame = render(&scene, &camera, &options, &mut mesh, &()).expect("frame");
            let (mine, all) = (frame.stats.fill_shadow_rays, frame.stats.rays.shadow);
            assert_eq!(mine, 0, "{method:?} {refine:?} {spp}: {mine} of {all} shadow rays");
            assert_eq!(frame.image, shoot(&scene, &camera, &options).image, "{method:?} {refine:?} {spp}");
        }
    }
}

/// The mesh of a third machine, which takes in what two have learned.
fn fill_by_two(scene: &Scene, options: &RenderOptions) -> LightMesh {
    let camera = room_camera();
    let new = || LightMesh::new(scene, options).expect("mesh");
    let mut meshes = [new(), new(), new()];
    let prepared: Vec<_> = meshes
        .iter_mut()
        .map(|mesh| distributed::prepare(scene, &camera, options, mesh, &()).expect("prepared"))
        .collect();
    let mut gathered_for = PointRequests::default();
    for _ in 0..meshes[0].level_count() {
        // Waves in turn.
        let mut wanted = PointRequests::default();
        for i in 0..distributed::wave_count(options).expect("count") {
            let at = i as usize % 2;
            let request = WaveRequest { prepared: &prepared[at], samples: PictureSamples::All, waves: i..i + 1 };
            let more =
                distributed::requested_points(scene, &camera, options, &mut meshes[at], request, &()).expect("wanted");
            wanted.merge(&more);
        }

        // Groups of a brick or two, until no point is new.
        let mut groups: Vec<GatherBatch> = Vec::new();
        let mut new = PointRequests { direct: Vec::new(), indirect: wanted.indirect.clone() };
        while !new.is_empty() {
            let first = groups.len();
            for bricks in new.indirect.chunks(2) {
                groups.push(GatherBatch::new(scene, options, &meshes[0], bricks, &()).expect("group"));
            }
            gathered_for.merge(&new);
            new = PointRequests::default();
            for group in &groups[first..] {
                let further = group.requests(scene, &meshes[0]);
                new.merge(&PointRequests { direct: Vec::new(), indirect: further.indirect });
                wanted.merge(&PointRequests { direct: further.direct, indirect: Vec::new() });
            }
            new.remove(&gathered_for);
        }

        // Bricks of direct light in turn, the last first.
        let learned: Vec<Snapshot> = (wanted.direct.chunks(3).rev().zip([0, 1].into_iter().cycle()))
            .map(|(bricks, at)| {
                distributed::fill_direct(scene, options, &mut meshes[at], bricks, &()).expect("filled");
                let of = PointRequests { direct: bricks.to_vec(), indirect: Vec::new() };
                meshes[at].snapshot_of(&of).expect("contents")
            })
            .collect();
        for contents in &learned {
            meshes.iter_mut().for_each(|mesh| mesh.merge(contents).expect("absorbed"));
        }

        // Reflection after reflection, all groups each.
        for (i, group) in groups.iter_mut().enumerate() {
            group.light(scene, options, &mut meshes[i % 2], &()).expect("light");
        }
        let mut below = BounceValues::default();
        for k in 0..=options.transport.bounces {
            let reflect = |group: &mut GatherBatch| group.bounce(scene, k, &below).expect("level");
            let parts: Vec<BounceValues> = groups.iter_mut().rev().map(reflect).collect();
            below = BounceValues::merge(&parts);
        }
        for group in &groups {
            let snapshot = group.snapshot(&meshes[0]).expect("all levels");
            meshes.iter_mut().for_each(|mesh| mesh.merge(&snapshot).expect("absorbed"));
        }
    }
    let [_, _, mesh] = meshes;
    mesh
}

/// A mesh that two machines filled together gives the picture, and leaves almost nothing to fill: points that surfaces
/// without any to read ask for are found out on the way.
#[test]
fn a_mesh_that_several_fill_is_the_mesh_that_one_fills() {
    // A wall that shines a little is found by gather rays alone.
    let [dark, shining] = [0.0, 0.02].map(|emission| {
        let mut data = room_with_mirror();
        data.materials[0].emission = Vec3::splat(emission);
        Scene::new(data).expect("scene")
    });
    for (scene, method, bounces, refine) in [
        (&dark, Method::MESH, 0, None),
        (&dark, Method::MESH, 1, None),
        (&dark, Method::MESH, 2, Some(1)),
        (&dark, Method::PAPER, 3, None),
        (&dark, Method::Hybrid, 3, None),
        (&shining, Method::MESH, 0, None),
        (&shining, Method::MESH, 3, None),
    ] {
        let base = options(method).with(|o| {
            o.picture.width = 200;
            o.picture.height = 150;
            o.picture.spp = 3;
            o.mesh.gather_rays = Some(32);
            // What short rays meet is found while the picture is drawn: 5% more points of the indirect mesh.
            o.mesh.near_rays = 0;
        });
        let options = base.with(|o| {
            o.transport.bounces = bounces;
            o.mesh.refine = refine;
        });
        let whole = shoot(scene, &room_camera(), &options);
        let mut mesh = fill_by_two(scene, &options);
        let before = (mesh.stats().points_used, mesh.indirect_stats().points_used);
        let frame = render(scene, &room_camera(), &options, &mut mesh, &()).expect("frame");
        let case = format!("{method:?}, {bounces} bounces, {refine:?}");
        assert_eq!(frame.image, whole.image, "{case}");
        let after = (mesh.stats().points_used, mesh.indirect_stats().points_used);
        assert!(after.0 - before.0 <= after.0 / 50, "{case}: {before:?} points, then {after:?}");
        assert!(after.1 - before.1 <= after.1 / 50, "{case}: {before:?} points, then {after:?}");
    }
}

#[test]
fn bricks_of_another_mesh_are_refused() {
    let scene = Scene::new(room()).expect("scene");
    let options = options(Method::MESH).with(|o| o.transport.bounces = 1);
    let mut mesh = LightMesh::new(&scene, &options).expect("mesh");
    for (level, brick) in [(1, 0), (0, 0), (0, u64::MAX)] {
        let bricks = [BrickMask { level, brick, mask: [1; 8] }];
        let direct = distributed::fill_direct(&scene, &options, &mut mesh, &bricks, &()).expect_err("no such brick");
        assert!(direct.to_string().contains("another mesh"), "{direct}");
        let indirect = GatherBatch::new(&scene, &options, &mesh, &bricks, &());
        assert!(matches!(indirect, Err(Error::InvalidBricks { .. })));
    }
    assert_eq!(mesh.stats().points_used, 0);
}

#[test]
fn bricks_are_joined_place_by_place() {
    let brick = |level, brick, places: u64| BrickMask { level, brick, mask: [places, 0, 0, 0, 0, 0, 0, 1] };
    let mut some = PointRequests { direct: vec![brick(0, 3, 1), brick(1, 0, 4)], indirect: Vec::new() };
    some.merge(&PointRequests { direct: vec![brick(0, 2, 7), brick(0, 3, 6)], indirect: vec![brick(0, 0, 1)] });
    assert_eq!(some.direct, [brick(0, 2, 7), brick(0, 3, 7), brick(1, 0, 4)]);
    assert_eq!(some.len(), 4 + 4 + 2 + 2);
    assert!(!some.is_empty() && PointRequests::default().is_empty());
}
