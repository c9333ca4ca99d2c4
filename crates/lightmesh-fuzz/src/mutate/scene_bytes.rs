//! Scenes as bytes: their fields as a tree of JSON, their numbers, or the bytes behind a length that is made right.

use fastrand::Rng;
use lightmesh::SceneData;

use super::{LONGEST, bytes, few_times, json, numbers, scene_floats};

/// Bytes before the scene: a name, and a length.
const NAME: usize = 16;
const HEADER: usize = NAME + 8;

pub(crate) fn mutate(input: &[u8], rng: &mut Rng) -> Vec<u8> {
    let scene = lightmesh_io::scene_from_bytes(input).ok();
    let changed = match (scene, rng.u8(0..8)) {
        (Some(scene), 0..=2) => as_tree(&scene, rng),
        (Some(mut scene), 3..=6) => {
            few_times(rng, |rng| change_numbers(&mut scene, rng));
            lightmesh_io::scene_to_bytes(&scene).ok()
        }
        _ => None,
    };
    let mut changed = changed.unwrap_or_else(|| {
        let mut bytes = input.to_vec();
        few_times(rng, |rng| bytes::change(&mut bytes, rng));
        if bytes.len() >= HEADER && rng.u8(0..16) != 0 {
            let length = (bytes.len() - HEADER) as u64;
            bytes[NAME..HEADER].copy_from_slice(&length.to_le_bytes());
        }
        bytes
    });
    changed.truncate(2 * LONGEST);
    changed
}

/// Changes the scene as JSON; `None` where what comes out is none any more.
fn as_tree(scene: &SceneData, rng: &mut Rng) -> Option<Vec<u8>> {
    let mut tree = serde_json::to_value(scene).ok()?;
    json::change(&mut tree, rng);
    lightmesh_io::scene_to_bytes(&serde_json::from_value(tree).ok()?).ok()
}

/// Sets a number to a hostile one.
fn change_numbers(scene: &mut SceneData, rng: &mut Rng) {
    match rng.u8(0..8) {
        0 => {
            let mut all = scene_floats::doubles(scene);
            if !all.is_empty() {
                let at = rng.usize(0..all.len());
                *all[at] = numbers::double(rng);
            }
        }
        1 => {
            // Everything of one mesh far away, or tiny.
            let factor = numbers::float(rng);
            if !scene.meshes.is_empty() {
                let at = rng.usize(0..scene.meshes.len());
                scene.meshes[at].positions.iter_mut().for_each(|p| *p *= factor);
            }
        }
        _ => {
            let mut all = scene_floats::floats(scene);
            if !all.is_empty() {
                let at = rng.usize(0..all.len());
                *all[at] = numbers::float(rng);
            }
        }
    }
}
