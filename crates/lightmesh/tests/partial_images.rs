//! Partial images: rendered anywhere, in any order, they merge to the picture that is made in one go.

use crate::common::*;
use std::ops::Range;

use glam::Vec3;
use lightmesh::distributed::{self, PartialImage, PictureSamples, Prepared, WaveRequest};
use lightmesh::{Aov, Camera, Error, Frame, LightMesh, Method, RenderOptions, Scene};

const METHODS: [Method; 6] =
    [Method::Standard, Method::MESH, Method::PAPER, Method::Hybrid, Method::UNBIASED, Method::Path];

/// One of several machines: it has the scene, and a mesh of its own.
struct Machine<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    options: &'a RenderOptions,
    mesh: LightMesh,
    prepared: Prepared,
}

impl<'a> Machine<'a> {
    fn new(scene: &'a Scene, camera: &'a Camera, options: &'a RenderOptions) -> Self {
        let mut mesh = LightMesh::new(scene, options).expect("mesh");
        let prepared = distributed::prepare(scene, camera, options, &mut mesh, &()).expect("prepared");
        Self { scene, camera, options, mesh, prepared }
    }

    fn render(&mut self, samples: PictureSamples<'_>, waves: Range<u64>) -> Result<PartialImage, Error> {
        let request = WaveRequest { prepared: &self.prepared, samples, waves };
        distributed::render_waves(self.scene, self.camera, self.options, &mut self.mesh, request, &())
    }
}

/// The picture from two machines that take waves in turn, the last first.
fn by_two(scene: &Scene, options: &RenderOptions) -> Frame {
    let camera = room_camera();
    let mut machines = [Machine::new(scene, &camera, options), Machine::new(scene, &camera, options)];
    let mut all = |samples: PictureSamples<'_>, count: u64| -> Vec<PartialImage> {
        (0..count).rev().map(|i| machines[i as usize % 2].render(samples, i..i + 1).expect("part")).collect()
    };
    let count = distributed::wave_count(options).expect("count");
    assert!(count > 1);
    let parts = all(PictureSamples::All, count);
    let edges = distributed::find_emitter_edges(scene, &camera, options, &parts).expect("edges");
    let edge_parts = edges.as_ref().map(|edges| all(PictureSamples::EmitterEdges(edges), edges.waves));
    let edges = edges.as_ref().zip(edge_parts.as_deref());
    distributed::merge_images(scene, &camera, options, &parts, edges).expect("frame")
}

#[test]
fn partial_images_merge_to_the_picture_that_is_made_in_one_go() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    for method in METHODS {
        // 3 samples: waves are not full. 200 × 150 × 3 of them: two waves.
        let aovs = [Aov::Normal, Aov::Depth, Aov::Direct].into_iter().collect();
        let options = options(method).with(|o| {
            o.picture.width = 200;
            o.picture.height = 150;
            o.picture.spp = 3;
            o.transport.bounces = 1;
            o.picture.aovs = aovs;
        });
        let whole = shoot(&scene, &room_camera(), &options);
        let parts = by_two(&scene, &options);
        assert_eq!(parts.image, whole.image, "{method:?}");
        assert_eq!(parts.layers, whole.layers, "{method:?}");
        assert_eq!(parts.stats.rays.primary, whole.stats.rays.primary, "{method:?}");
    }
}

/// Refined meshes and a bound on the error: every machine comes to the same plan.
#[test]
fn machines_come_to_the_same_plan() {
    let mut data = room_with_mirror();
    let lamp = |i: u32| point_light(Vec3::new(-1.8 + 0.1 * i as f32, 2.7, 0.03 * (i % 7) as f32), Vec3::splat(2.0));
    data.lights.extend((0..36).map(lamp));
    let scene = Scene::new(data).expect("scene");
    let base = options(Method::MESH).with(|o| {
        o.picture.width = 300;
        o.picture.height = 240;
    });
    for options in [
        base.clone().with(|o| {
            o.method = Method::with_error(0.05);
            o.transport.bounces = 1;
        }),
        base.clone().with(|o| o.mesh.refine = Some(2)),
        base.with(|o| o.mesh.lod_distance = Some(2.0)),
    ] {
        let whole = shoot(&scene, &room_camera(), &options);
        let parts = by_two(&scene, &options);
        assert_eq!(parts.image, whole.image, "{options:?}");
        assert_eq!(parts.stats.estimated_error, whole.stats.estimated_error);
    }
}

#[test]
fn parts_that_do_not_fit_together_are_refused() {
    let scene = Scene::new(room_with_mirror()).expect("scene");
    let options = options(Method::MESH).with(|o| {
        o.picture.width = 200;
        o.picture.height = 150;
        o.picture.spp = 3;
    });
    let camera = room_camera();
    let mut machine = Machine::new(&scene, &camera, &options);
    let [first, second] = [0..1, 1..2].map(|waves| machine.render(PictureSamples::All, waves).expect("part"));
    let message = |parts: &[PartialImage]| match distributed::merge_images(&scene, &camera, &options, parts, None) {
        Err(Error::InvalidParts { what }) => what,
        other => panic!("{other:?}"),
    };
    assert!(message(&[]).contains("waves 0 to 2 are missing"));
    assert!(message(std::slice::from_ref(&second)).contains("waves 0 to 1"));
    assert!(message(&[first.clone(), first.clone(), second.clone()]).contains("twice"));
    let foreign = PartialImage { values: second.values[1..].to_vec(), ..second };
    assert!(message(&[first.clone(), foreign.clone()]).contains("another picture"));

    // Which samples met emitters is there for every pixel, or nowhere.
    let edges = |parts: &[PartialImage]| distributed::find_emitter_edges(&scene, &camera, &options, parts);
    let blind = |part: &PartialImage| PartialImage { emitter_seen: Vec::new(), ..part.clone() };
    assert!(edges(&[first.clone(), foreign.clone()]).expect("edges").is_some());
    assert!(edges(&[first.clone(), blind(&foreign)]).is_err());
    assert!(edges(&[blind(&first), blind(&foreign)]).expect("none").is_none());
    let nothing = options.clone().with(|o| o.picture.spp = 0);
    assert!(distributed::find_emitter_edges(&scene, &camera, &nothing, &[]).is_err());
    assert!(distributed::merge_images(&scene, &camera, &nothing, &[], None).is_err());

    assert!(machine.render(PictureSamples::All, 2..3).is_err());
    assert!(machine.render(PictureSamples::All, 1..1).is_err());
    lightmesh::render(&scene, &camera, &options, &mut machine.mesh, &()).expect("frame");
    let error = machine.render(PictureSamples::All, 0..1).expect_err("another picture came between");
    assert!(error.to_string().contains("another picture"), "{error}");
}
