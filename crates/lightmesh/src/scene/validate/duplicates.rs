//! Surfaces that lie where others do: copies that exporters and scripts leave behind. Rays would have to test all of them.

use std::collections::HashMap;

use glam::Vec3;
use rayon::prelude::*;

use crate::geometry::TriangleMesh;
use crate::sampling::hash;
use crate::scene::data::{Instance, SceneData};

/// Corners that differ by no more than about this part of the triangle's largest coordinate are the same: 8 to 16 steps
/// of 32-bit floats.
const SAME: f32 = 1.0 / (1 << 20) as f32;

/// Triangles whose corners differ by no more than about this part of their size are layers of one stack.
const LAYER: f32 = 1.0 / 1024.0;

/// The most layers of a stack: a ray through it has to test them all. Sheets of paper are 1/3000 of their size apart, and
/// so three to a stack.
const MOST_LAYERS: usize = 64;

/// Leaves out triangles that repeat another one of their mesh, and instances that repeat another one of the same material;
/// and of stacks of very many nearly equal ones all but the first [`MOST_LAYERS`]. The first stays, which also wins where
/// a ray meets both. The back of a surface is no copy of its front.
pub(super) fn remove(data: &mut SceneData, warnings: &mut Vec<String>) {
    // Triangles within each mesh.
    let left_out = |mesh: &mut TriangleMesh| {
        let before = mesh.triangles.len();
        remove_triangles(mesh);
        before - mesh.triangles.len()
    };
    let counts: Vec<usize> = data.meshes.par_iter_mut().map(left_out).collect();
    if let Some(first) = counts.iter().position(|&count| count > 0) {
        let (all, name) = (counts.iter().sum::<usize>(), &data.meshes[first].name);
        warnings.push(format!(
            "{all} triangle(s) lie where others of their mesh do and are left out, the first in mesh {first} \"{name}\""
        ));
    }

    // Instances in the world.
    let (meshes, instances) = (&data.meshes, &data.instances);
    let key = |instance: &Instance, precision| instance_key(meshes, instance, precision);
    let stacks = instances.par_iter().map(|instance| key(instance, Precision::Layer)).collect();
    let repeats = repeats(
        stacks,
        |i| key(&instances[i], Precision::Same),
        |i, j| are_equal(meshes, &instances[i], &instances[j]),
    );
    if let Some(first) = repeats.iter().position(|&repeat| repeat) {
        let (mesh, before) = (data.instances[first].mesh, data.instances.len());
        keep(&mut data.instances, &repeats);
        warnings.push(format!(
            "{} instance(s) lie where others of the same shape and material do and are left out, the first of mesh {mesh} \
             \"{}\"",
            before - data.instances.len(),
            data.meshes[mesh].name
        ));
    }
}

fn remove_triangles(mesh: &mut TriangleMesh) {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
    let place = |i: usize| rounded(corners(&mesh.triangles[i]), Precision::Same);
    let stacks = mesh.triangles.par_iter().map(|t| hash_of(&rounded(corners(t), Precision::Layer))).collect();
    let repeats = repeats(stacks, |i| hash_of(&place(i)), |i, j| place(i) == place(j));
    keep(&mut mesh.triangles, &repeats);
}

/// Keeps what repeats nothing.
fn keep<T>(all: &mut Vec<T>, repeats: &[bool]) {
    if repeats.contains(&true) {
        let mut repeats = repeats.iter();
        all.retain(|_| repeats.next() != Some(&true));
    }
}

/// Says of each of some things whether it repeats an earlier one, or is one too many of its stack. `stacks`: a hash of
/// each thing's stack; `key`: a hash of its place; `equal`: whether two of one key are at one place.
fn repeats(stacks: Vec<u64>, key: impl Fn(usize) -> u64, equal: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    let mut order: Vec<u32> = (0..stacks.len() as u32).collect();
    order.par_sort_unstable_by_key(|&i| (stacks[i as usize], i));
    let mut repeats = vec![false; stacks.len()];
    for run in order.chunk_by(|&i, &j| stacks[i as usize] == stacks[j as usize]).filter(|run| run.len() > 1) {
        let mut firsts: HashMap<u64, usize> = HashMap::new();
        for i in run.iter().map(|&i| i as usize) {
            let key = key(i);
            repeats[i] = match firsts.get(&key) {
                Some(&first) if equal(first, i) => true,
                _ => firsts.len() >= MOST_LAYERS,
            };
            if !repeats[i] {
                firsts.entry(key).or_insert(i);
            }
        }
    }
    repeats
}

/// How closely places are compared.
#[derive(Clone, Copy, Debug)]
enum Precision {
    /// To within [`SAME`].
    Same,
    /// To within [`LAYER`].
    Layer,
}

/// A triangle's corners as integers that are the same for all that lie at the same place: the least corner first, in the
/// triangle's own direction. The last numbers tell the steps that corners are rounded to; 0: these are their bits.
///
/// Where a step of [`SAME`] is no small part of the triangle, only equal bits are the same place.
fn rounded(corners: [Vec3; 3], precision: Precision) -> [[i32; 3]; 4] {
    let largest = corners.iter().fold(0.0, |m: f32, p| m.max(p.abs().max_element()));
    let size = (corners[1] - corners[0]).abs().max((corners[2] - corners[0]).abs()).max_element();
    // Powers of two, so that scaling is exact; they change at sizes that are less usual than 1 and 2.
    let power_of_two = |x: f32| f32::from_bits((1.37 * x).to_bits() & 0x7f80_0000);
    let (same, layer) = (power_of_two(largest) * SAME, power_of_two(size) * LAYER);
    let (integers, step) = if same < layer && same > 1e-36 {
        let step = match precision {
            Precision::Same => same,
            Precision::Layer => layer,
        };
        (corners.map(|p| (p / step).round().as_ivec3().to_array()), step.to_bits() as i32)
    } else {
        // Adding zero makes −0 the same as 0.
        (corners.map(|p| (p + Vec3::ZERO).to_array().map(|x| x.to_bits() as i32)), 0)
    };
    let [a, b, c] = integers;
    let [a, b, c] = [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or(integers);
    [a, b, c, [step, 0, 0]]
}

fn hash_of(numbers: &[[i32; 3]; 4]) -> u64 {
    let fold = |seed: u32| numbers.iter().flatten().fold(seed, |h, &x| hash(h ^ x as u32));
    u64::from(fold(1)) << 32 | u64::from(fold(2))
}

/// A hash of where an instance's first and last triangle are, what it is made of and how much.
fn instance_key(meshes: &[TriangleMesh], instance: &Instance, precision: Precision) -> u64 {
    let mesh = &meshes[instance.mesh];
    let (Some(first), Some(last)) = (mesh.triangles.first(), mesh.triangles.last()) else { return 0 };
    let [first, last] = [first, last].map(|t| hash_of(&placed(mesh, instance, t, precision)));
    let counts = [mesh.triangles.len() as u32, mesh.material as u32].into_iter().fold(3, |h, x| hash(h ^ x));
    (first ^ last.rotate_left(17)).wrapping_add(u64::from(counts))
}

fn placed(mesh: &TriangleMesh, instance: &Instance, triangle: &[u32; 3], precision: Precision) -> [[i32; 3]; 4] {
    rounded(triangle.map(|i| instance.world_from_object.transform_point3(mesh.positions[i as usize])), precision)
}

/// Whether two instances are of one material and all of their triangles lie at the same places.
fn are_equal(meshes: &[TriangleMesh], a: &Instance, b: &Instance) -> bool {
    if a.mesh == b.mesh && a.world_from_object == b.world_from_object {
        return true;
    }
    let (of_a, of_b) = (&meshes[a.mesh], &meshes[b.mesh]);
    let place = |mesh, instance, triangle| placed(mesh, instance, triangle, Precision::Same);
    of_a.material == of_b.material
        && of_a.triangles.len() == of_b.triangles.len()
        && of_a.triangles.iter().zip(&of_b.triangles).all(|(t, u)| place(of_a, a, t) == place(of_b, b, u))
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::Material;

    fn mesh(triangles: &[[Vec3; 3]]) -> TriangleMesh {
        TriangleMesh {
            positions: triangles.as_flattened().to_vec(),
            triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..TriangleMesh::default()
        }
    }

    fn scene(meshes: Vec<TriangleMesh>, places: &[(usize, Vec3)]) -> SceneData {
        let place = |&(mesh, at): &(usize, Vec3)| Instance { mesh, world_from_object: Affine3A::from_translation(at) };
        let materials = vec![Material::default(), Material::default()];
        SceneData { instances: places.iter().map(place).collect(), meshes, materials, ..SceneData::default() }
    }

    const TRIANGLE: [Vec3; 3] = [Vec3::new(3.0, 1.0, 0.0), Vec3::new(4.0, 1.0, 0.0), Vec3::new(3.0, 2.0, 0.5)];

    /// Turned corners and a step of rounding are the same place; the back, and what is a millimetre away, are not.
    #[test]
    fn copies_of_triangles_go() {
        let [a, b, c] = TRIANGLE;
        let (step, aside) = (Vec3::splat(2e-7), Vec3::new(0.0, 0.0, 1e-3));
        let triangles = [[a, b, c], [b, c, a], [a, c, b], [a, b, c].map(|p| p + aside), [a + step, b, c]];
        let mut data = scene(vec![mesh(&triangles)], &[(0, Vec3::ZERO)]);
        let mut warnings = Vec::new();
        remove(&mut data, &mut warnings);
        assert_eq!(data.meshes[0].triangles, [[0, 1, 2], [6, 7, 8], [9, 10, 11]]);
        assert!(warnings[0].starts_with("2 triangle(s)") && warnings.len() == 1, "{warnings:?}");
    }

    /// Small triangles far from the origin differ by steps of rounding, and are no copies.
    #[test]
    fn small_triangles_stay() {
        let far = |x: f32| TRIANGLE.map(|p| p * 0.02 + Vec3::new(900.0 + x, 0.0, 0.0));
        let mut data = scene(vec![mesh(&[far(0.0), far(6e-5), far(0.0)])], &[(0, Vec3::ZERO)]);
        remove(&mut data, &mut Vec::new());
        assert_eq!(data.meshes[0].triangles.len(), 2);
    }

    /// The same mesh twice, and another mesh with the same triangles; not one of another material.
    #[test]
    fn copies_of_instances_go() {
        let other = TriangleMesh { material: 1, ..mesh(&[TRIANGLE]) };
        let meshes = vec![mesh(&[TRIANGLE]), mesh(&[TRIANGLE]), other];
        let places = [(0, Vec3::ZERO), (0, Vec3::X), (0, Vec3::ZERO), (1, Vec3::ZERO), (2, Vec3::ZERO)];
        let mut data = scene(meshes, &places);
        let mut warnings = Vec::new();
        remove(&mut data, &mut warnings);
        let left: Vec<usize> = data.instances.iter().map(|i| i.mesh).collect();
        assert_eq!(left, [0, 0, 2]);
        assert!(warnings[0].starts_with("2 instance(s)"), "{warnings:?}");
    }

    /// Two thousand layers in a ten-thousandth of their size, none where another one is: a few stacks of 64. Twenty that
    /// are a thousandth of it apart stay.
    #[test]
    fn stacks_are_no_higher_than_some() {
        let layer = |i: u32, step: f32| TRIANGLE.map(|p| p + Vec3::new(0.0, 0.0, i as f32 * step));
        let count = |layers: Vec<[Vec3; 3]>| {
            let mut data = scene(vec![mesh(&layers)], &[(0, Vec3::ZERO)]);
            remove(&mut data, &mut Vec::new());
            data.meshes[0].triangles.len()
        };
        let left = count((0..2000).map(|i| layer(i, 5e-8)).collect());
        assert!((1..=4 * MOST_LAYERS).contains(&left), "{left}");
        assert_eq!(count((0..20).map(|i| layer(i, 1e-3)).collect()), 20);
    }
}
