//! What building a scene takes is within what it is estimated to take, so that a limit can be kept.
//!
//! A program of its own: it counts every allocation.

#[path = "common/counting.rs"]
mod counting;

use std::sync::atomic::Ordering::Relaxed;

use counting::{LIVING, PEAK};
use glam::{Affine3A, Vec3};
use lightmesh::geometry::TriangleMesh;
use lightmesh::{EmitterOptions, Error, Instance, Light, Limits, Material, Scene, SceneData};

/// Buffers of threads and of the first build, whatever the scene.
const FIXED: u64 = 1 << 20;

/// Numbers in [0, 1).
struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        (word >> 22 ^ word) as f32 / 4_294_967_296.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// Triangles of edges `size(i)` anywhere in a cube of 10 m.
fn soup(count: u32, size: impl Fn(u32) -> f32) -> TriangleMesh {
    let mut random = Random(7);
    let corners = (0..count).flat_map(|i| {
        let middle = random.point() * 10.0;
        [(); 3].map(|()| middle + random.point() * size(i))
    });
    let positions = corners.collect();
    TriangleMesh {
        positions,
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Default::default()
    }
}

/// A rough ground of 2 n² triangles.
fn ground(n: u32) -> TriangleMesh {
    let mut random = Random(3);
    let positions =
        (0..(n + 1) * (n + 1)).map(|i| Vec3::new((i % (n + 1)) as f32, random.unit(), (i / (n + 1)) as f32));
    let cells = (0..n * n).map(|i| i / n * (n + 1) + i % n);
    let triangles = cells.flat_map(|i| [[i, i + n + 1, i + 1], [i + 1, i + n + 1, i + n + 2]]).collect();
    TriangleMesh { positions: positions.collect(), triangles, ..Default::default() }
}

fn scene(mesh: TriangleMesh, copies: u32, material: Material, lamps: u32) -> SceneData {
    let place = |i: u32| Instance { mesh: 0, world_from_object: Affine3A::from_translation(Vec3::X * (20 * i) as f32) };
    let mut random = Random(11);
    let lamp = |_| Light::Point { position: random.point() * 10.0, intensity_cd: Vec3::ONE, range: None };
    SceneData {
        meshes: vec![mesh],
        instances: (0..copies).map(place).collect(),
        materials: vec![material],
        lights: (0..lamps).map(lamp).collect(),
        ..SceneData::default()
    }
}

/// The bytes that building is said to take: those of the refusal by a limit of one byte.
fn estimate(data: &SceneData) -> u64 {
    match Scene::within(data.clone(), &EmitterOptions::default(), &Limits { max_memory: 1 }) {
        Err(Error::OutOfMemory { needed_bytes, .. }) => needed_bytes,
        other => panic!("one byte is too little, not {:?}", other.map(|scene| scene.bytes())),
    }
}

/// Many triangles and few, small and large ones, copies with a tree of their own, emitters, lamps, glass.
#[test]
fn building_takes_no_more_than_it_is_said_to() {
    let grey = || Material::lambert(Vec3::splat(0.5));
    let bright = Material { emission: Vec3::ONE, ..grey() };
    let glass = Material { transmission: 1.0, ..grey() };
    let scenes = [
        ("ground", scene(ground(150), 1, grey(), 1)),
        ("small triangles", scene(soup(40_000, |_| 0.05), 1, grey(), 1)),
        ("large triangles", scene(soup(10_000, |_| 8.0), 1, grey(), 1)),
        ("both", scene(soup(40_000, |i| if i % 100 == 0 { 10.0 } else { 0.02 }), 1, grey(), 1)),
        ("copies", scene(ground(40), 4000, grey(), 1)),
        ("few copies", scene(ground(150), 3, grey(), 1)),
        ("emitter", scene(ground(150), 1, bright, 0)),
        ("lamps", scene(ground(20), 1, grey(), 40_000)),
        ("glass", scene(ground(150), 1, glass, 1)),
    ];
    for (name, data) in scenes {
        let estimated = estimate(&data);
        let before = LIVING.load(Relaxed);
        PEAK.store(before, Relaxed);
        let own = data.bytes();
        let built = Scene::within(data, &EmitterOptions::default(), &Limits { max_memory: estimated }).expect(name);
        let (took, held) = ((PEAK.load(Relaxed) - before) as u64, (LIVING.load(Relaxed) - before) as u64);
        assert!(own + took <= estimated + FIXED, "{name}: {own} and {took} of {estimated} bytes");
        assert!(own + held <= built.bytes() + FIXED, "{name}: {own} and {held} of {} bytes held", built.bytes());
        // No empty promise: an estimate that is far too large refuses what would fit.
        assert!(estimated <= 4 * (own + took) + FIXED, "{name}: {own} and {took} of {estimated} bytes");
    }
}
